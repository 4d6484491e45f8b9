"""C export of a voice for programs without Python, and compilation of plugins.

`kernel.c` and `overview.h` are the Python kernels, translated by `tools/build_c.py`. The folder
also has an image of the timeline and the preset, an example and two build files. Plugins contain
the same sources. They are compiled by the system's compiler, or by PyPI's ziglang for other
machines.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError, quoted
from overview_dsp.files.atomic import make_folder, write_file
from overview_dsp.kernels.sources import sources_digest
from overview_dsp.offline.export.browser_memory import encode_engine
from overview_dsp.signal.engine.engine import Engine

IMAGE = "timeline.image"
_FILES = ("kernel.c", "operations.h", "overview.h", "example.c", "Makefile", "CMakeLists.txt")
_IMAGE_RATE = 48_000.0  # arbitrary: `overview_prepare` sets the rate of a voice

_FLAGS = ("-std=c11", "-O2", "-shared", "-fvisibility=hidden")
# after those in CC, which may let the compiler change the arithmetic
_EXACT = ("-fno-fast-math", "-ffp-contract=off")
_ZIG = {
    # an old glibc, for compatibility with newer ones
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-macos": "x86_64-macos",
    "aarch64-macos": "aarch64-macos",
}
TARGETS = tuple(_ZIG)  # names of the machines for which plugins can be compiled
_SYSTEMS = {"linux": "linux", "darwin": "macos", "win32": "windows"}
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}


def export_c(
    timeline: Timeline, preset: Preset, folder: str | os.PathLike[str], *, seed: int = 0
) -> list[Path]:
    """Write C source with an image of a timeline and a preset.

    Compiled with any C99 or C++ compiler, it is bit-identical to `render` at any sample rate.

    Parameters
    ----------
    timeline : Timeline
        Data of the voice.
    preset : Preset
        Parameters of feel and sound.
    folder : str or path
        Folder, created if missing; existing files are overwritten.
    seed : int
        Seed of the texture noise.

    Returns
    -------
    list of Path
        Written files.

    Raises
    ------
    InputError
        The folder can't be written.
    OverviewError
        `kernel.c` is older than the kernels.

    Examples
    --------
    >>> [path.name for path in ov.export.export_c(match, football, "voice")]
    ['kernel.c', 'operations.h', 'overview.h', 'example.c', 'Makefile', 'CMakeLists.txt', \
'timeline.image']
    """
    contents = c_sources(*_FILES)
    contents[IMAGE] = encode_engine(prepared_engine(timeline, preset, seed))
    return write_files(folder, contents)


def prepared_engine(timeline: Timeline, preset: Preset, seed: int) -> Engine:
    """Return an engine whose memory is the initial image of a voice."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(_IMAGE_RATE)
    return engine


def write_files(folder: str | os.PathLike[str], contents: Mapping[str, bytes]) -> list[Path]:
    """Write files by their paths in a folder, each completely; return the paths."""
    written = [Path(folder, path) for path in contents]
    for path, content in zip(written, contents.values(), strict=True):
        make_folder(path.parent)
        write_file(path, content)
    return written


def c_sources(*names: str) -> dict[str, bytes]:
    """Return files of the package's C folder by name; OverviewError if kernel.c is outdated."""
    source = resources.files("overview_dsp.offline.export") / "c"
    contents = {name: (source / name).read_bytes() for name in names}
    if f"kernels {sources_digest()}\n".encode() not in contents["kernel.c"][:1000]:
        raise OverviewError("kernel.c is older than the kernels: run python tools/build_c.py")
    return contents


@dataclass(frozen=True)
class Machine:
    """Target of a plugin: processor (such as `x86_64`) and `linux`, `windows` or `macos`."""

    processor: str
    system: str


def machine_of(target: str | None) -> Machine:
    """Return the machine of a target, or this one; raise InputError if it is unknown."""
    if target is None:
        processor = platform.machine().lower()
        system = _SYSTEMS.get(sys.platform, "linux")
        return Machine(_MACHINES.get(processor, processor), system)
    if target not in _ZIG:
        raise InputError(f"target is {quoted(target)}; must be one of {', '.join(TARGETS)}")
    return Machine(*target.split("-"))


def compiler_of(target: str | None) -> list[str]:
    """Return the command of the system's C compiler, or of ziglang, as always for a target."""
    zig = [sys.executable, "-m", "ziglang", "cc"]
    has_zig = importlib.util.find_spec("ziglang") is not None
    if target is not None:
        if not has_zig:
            raise OverviewError(f"a plugin for {target} needs ziglang: pip install ziglang")
        return [*zig, "-target", _ZIG[target], "-s"]
    chosen = os.environ.get("CC", "").split()
    if chosen:
        if shutil.which(chosen[0]) is None:
            raise OverviewError(f"CC is {quoted(chosen[0])}, which is not installed")
        return chosen
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
    """Compile a shared library; raise OverviewError with the compiler's first error."""
    code = [] if machine.system == "windows" else ["-fPIC"]
    command = [*compiler, *_FLAGS, *_EXACT, *code, *sources, "-o", name, "-lm"]
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, errors="replace", check=False
        )
    except OSError as error:
        raise OverviewError(f"the C compiler {compiler[0]} doesn't start: {error}") from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or [done.stderr]
        raise OverviewError(f"the C compiler {compiler[0]} failed: {lines[0].strip()}")
