"""The compiler of a plugin's library: the system's own, or PyPI's ziglang for other machines."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from overview_dsp.errors import InputError, OverviewError, shown

_FLAGS = ("-std=c11", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
_ZIG = {
    # an old glibc: what is linked against it runs on newer ones too
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-macos": "x86_64-macos",
    "aarch64-macos": "aarch64-macos",
}
TARGETS = tuple(_ZIG)
"""Machines that plugins are compiled for, as their names are written."""

_SYSTEMS = {"linux": "linux", "darwin": "macos", "win32": "windows"}
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}


@dataclass(frozen=True)
class Machine:
    """What a plugin runs on: `x86_64` or the like, and `linux`, `windows` or `macos`."""

    processor: str
    system: str


def machine_of(target: str | None) -> Machine:
    """The machine of a target, or this one; InputError if there is no such target."""
    if target is None:
        processor = platform.machine().lower()
        system = _SYSTEMS.get(sys.platform, "linux")
        return Machine(_MACHINES.get(processor, processor), system)
    if target not in _ZIG:
        raise InputError(f"no target {shown(target)}; it is {', '.join(TARGETS)}")
    return Machine(*target.split("-"))


def compiler_of(target: str | None) -> list[str]:
    """The system's C compiler, or ziglang; for a target always that one."""
    zig = [sys.executable, "-m", "ziglang", "cc"]
    has_zig = importlib.util.find_spec("ziglang") is not None
    if target is not None:
        if not has_zig:
            raise OverviewError(f"a plugin for {target} needs ziglang: pip install ziglang")
        return [*zig, "-target", _ZIG[target], "-s"]
    given = os.environ.get("CC", "").split()
    if given:
        if shutil.which(given[0]) is None:
            raise OverviewError(f"there is no compiler {shown(given[0])}, which CC names")
        return given
    for command in ("cc", "gcc", "clang"):
        if shutil.which(command):
            return [command]
    if has_zig:
        return zig
    raise OverviewError(
        "a plugin needs a C compiler: install gcc or clang (Debian, Ubuntu: apt install gcc), or "
        "pip install ziglang"
    )


def compile_library(
    compiler: Sequence[str], machine: Machine, sources: Sequence[str], folder: Path, name: str
) -> None:
    """Compile a shared library into the folder; OverviewError with the compiler's first error."""
    code = [] if machine.system == "windows" else ["-fPIC"]
    command = [*compiler, *_FLAGS, *code, *sources, "-o", name, "-lm"]
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, errors="replace", check=False
        )
    except OSError as error:
        raise OverviewError(f"the C compiler {compiler[0]} doesn't start: {error}") from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or [done.stderr]
        raise OverviewError(f"the C compiler {compiler[0]} failed: {lines[0].strip()}")
