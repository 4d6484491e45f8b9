"""What figures were measured on: the processor, its cores, and what compiled the kernels."""

from __future__ import annotations

import platform
import re
from importlib.metadata import version
from pathlib import Path

from overview_dsp.offline.rendering.many import usable_cores
from overview_dsp.public import counted


def this_machine() -> str:
    """A line: `AMD EPYC 7763, 2 cores, Linux, Python 3.11.7, numba 0.61.0`."""
    return (
        f"{_processor()}, {counted(usable_cores(), 'core')}, {platform.system()}, "
        f"Python {platform.python_version()}, numba {version('numba')}"
    )


def _processor() -> str:
    known = Path("/proc/cpuinfo")
    if known.exists():
        found = re.search(r"^model name\s*: (.+)$", known.read_text(), re.MULTILINE)
        if found:
            return " ".join(found[1].split())
    return platform.processor() or platform.machine()
