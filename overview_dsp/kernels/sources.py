"""State of the kernels' sources, and the mode in which they run.

Thread: any.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import numba

# numba sets its options as attributes at run time
CONFIG: Any = numba.config


@cache
def sources_digest() -> str:
    """Return a digest of all kernel source files, independent of line endings."""
    digest = hashlib.sha256()
    folder = Path(__file__).parent
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes().replace(b"\r\n", b"\n"))
    return digest.hexdigest()[:16]


def runs_as_python() -> bool:
    """Return whether kernels run as plain Python (`NUMBA_DISABLE_JIT`)."""
    return bool(CONFIG.DISABLE_JIT)
