"""What the kernels do as plain Python, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

CODE = """
import importlib, sys, warnings
warnings.simplefilter("ignore", RuntimeWarning)  # wrapping integers, as in machine code
sys.stdout.buffer.write(eval(sys.argv[2], vars(importlib.import_module(sys.argv[1]))))
"""


def interpreted(module: str, call: str) -> bytes:
    """What a call in a module of tests returns where nothing is compiled."""
    assert os.environ.get("NUMBA_DISABLE_JIT", "0") == "0", "nothing is compiled here either"
    done = subprocess.run(
        [sys.executable, "-c", CODE, module, call],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=True,
    )
    return done.stdout
