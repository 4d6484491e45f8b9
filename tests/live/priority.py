"""Priority for what a test plays in real time beside whatever else runs on the machine."""

from __future__ import annotations

import contextlib
import os


def urgently():
    """Go ahead of other programs, where that is allowed; for `preexec_fn` (POSIX)."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, -15)
