"""Build of C sources to shared libraries, where a compiler is installed."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path

from overview_dsp.errors import OverviewError

PEERS = Path(__file__).resolve().parents[1] / "peers"
"""The sources of the versions in other languages."""


class MissingError(OverviewError):
    """Missing compiler or program of a contender."""


def compiler() -> str:
    """Return the C compiler's name.

    Raises
    ------
    MissingError
        No compiler is installed.
    """
    for name in ("gcc", "cc", "clang"):
        if shutil.which(name):
            return name
    raise MissingError("no C compiler (gcc, cc or clang)")


def built(path: Path, flags: tuple[str, ...], folder: Path | None = None) -> Path:
    """Compile a C source to a shared library, once for each text and flags, and return its path.

    `folder` receives it; None: a new folder in the system's temporary one.

    Raises
    ------
    MissingError
        No compiler.
    OverviewError
        The source does not compile.
    """
    name = compiler()
    what = hashlib.sha256(path.read_bytes() + " ".join(flags).encode()).hexdigest()[:16]
    folder = folder or Path(tempfile.mkdtemp(prefix="overview-bench-"))
    target = folder / f"{path.stem}-{what}.so"
    if not target.exists():
        unit = target.with_suffix(".o")
        # linked without the flags: fast arithmetic makes a library that turns denormals off in the
        # process that loads it, and this process also measures and tests other code
        for command in (
            [name, *flags, "-fPIC", "-c", str(path), "-o", str(unit)],
            [name, "-shared", str(unit), "-o", str(target), "-lm"],
        ):
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise OverviewError(f"{path.name}: {name} says: {done.stderr.strip()[:300]}")
    return target
