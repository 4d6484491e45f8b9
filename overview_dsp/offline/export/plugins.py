"""Audio plugins: the voice in C with images of timelines, compiled for audio workstations.

`plugin/` has the sources: `voice.h` is shared by all formats, `bundle.h` declares the generated
data. Formats differ in the location of the library and in additional files for hosts. The sources
are compiled by the system's compiler, or by PyPI's ziglang for other machines.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import plistlib
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError, quoted
from overview_dsp.files.atomic import make_folder
from overview_dsp.files.toml import load_toml
from overview_dsp.offline.export.c_code import c_sources, write_files
from overview_dsp.offline.export.plugin_bundle import (
    DESCRIPTIONS,
    IMAGES,
    SOURCES,
    Bundle,
    bundle_of,
    bundle_source,
    description,
    manifest,
)

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
_LIBRARY = {"linux": ".so", "windows": ".dll", "macos": ".dylib"}


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


def contents_of(to: str, bundle: Bundle, machine: Machine, library: bytes) -> dict[str, bytes]:
    """Return the files of a plugin by their relative paths; the first is the library.

    A VST3 folder has one library per system.
    """
    called = f"{bundle.slug}.{to}"
    if to == "lv2":
        name = f"plugin{_LIBRARY[machine.system]}"
        return {
            f"{called}/{name}": library,
            f"{called}/{DESCRIPTIONS}": description(bundle).encode(),
            f"{called}/manifest.ttl": manifest(name, bundle).encode(),
        }
    if machine.system == "macos":
        inside = PurePosixPath(called, "Contents")
        described = {
            "CFBundleExecutable": bundle.slug,
            "CFBundleIdentifier": bundle.id,
            "CFBundleName": "".join(c if c.isprintable() else " " for c in bundle.name),
            **load_toml(__file__, "documents.toml")["macos"],
        }
        return {
            str(inside / "MacOS" / bundle.slug): library,
            str(inside / "Info.plist"): plistlib.dumps(described),
            str(inside / "PkgInfo"): b"BNDL????",
        }
    if to == "clap":
        return {called: library}
    system, suffix = ("win", "vst3") if machine.system == "windows" else ("linux", "so")
    is_arm = machine.processor == "aarch64" and system == "win"  # which has its own name
    processor = "arm64" if is_arm else machine.processor
    inside = PurePosixPath(called, "Contents", f"{processor}-{system}")
    return {str(inside / f"{bundle.slug}.{suffix}"): library}


MOST_NAMES = 64  # highest number of timelines and of presets in a plugin
_SHARED_SOURCES = ("bundle.h", "data.h", "voice.h")
_OWN_SOURCES = {
    "clap": ("values.h", "state.h", "clap.h", "clap.c"),
    "lv2": ("lv2.h", "lv2.c"),
    "vst3": ("values.h", "state.h", "vst3.h", "vst3_controller.h", "vst3_events.h", "vst3.c"),
}
PLUGIN_FORMATS = tuple(_OWN_SOURCES)


def build_plugin(
    timeline: Timeline | Mapping[str, Timeline],
    presets: Preset | Sequence[Preset],
    to: str,
    folder: str | os.PathLike[str],
    *,
    name: str | None = None,
    seed: int = 0,
    target: str | None = None,
) -> Path:
    """Compile timelines to an audio plugin, an instrument for hosts of its format.

    It needs no Python and is bit-identical to `render` at any sample rate.

    Parameters
    ----------
    timeline : Timeline or mapping of str to Timeline
        Data, or several timelines by name, one of which is selected in the host.
    presets : Preset or sequence of Preset
        Parameters of feel and sound; one of up to 64 presets is selected in the host.
    to : str
        Format: `"clap"`, `"vst3"`, or `"lv2"` (a bundle with a plugin for each preset).
    folder : str or path
        Folder, created if missing. An existing plugin of this name is replaced, in a VST3 the
        library of the same system.
    name : str, optional
        Name of the plugin; default: the first timeline's title.
    seed : int
        Seed of the texture noise.
    target : str, optional
        Target machine, compiled with ziglang: `"x86_64-linux"`, `"aarch64-linux"`,
        `"x86_64-windows"`, `"x86_64-macos"` or `"aarch64-macos"`. Default: this machine.

    Returns
    -------
    Path
        Path of the plugin.

    Raises
    ------
    InputError
        The format or target is unknown, there are no or too many presets or timelines, two presets
        have the same name, or the folder can't be written.
    OverviewError
        The C compiler is missing or fails.

    Examples
    --------
    >>> ov.export.build_plugin(match, football, "clap", "plugins", name="match").name
    'match.clap'
    """
    if to not in PLUGIN_FORMATS:
        raise InputError(f"to is {quoted(to)}; must be {' or '.join(PLUGIN_FORMATS)}")
    chosen = (presets,) if isinstance(presets, Preset) else tuple(presets)
    if isinstance(timeline, Timeline):
        timelines: Mapping[str, Timeline] = {timeline.title or "timeline": timeline}
    else:
        timelines = timeline
    for what, count in (("presets", len(chosen)), ("timelines", len(timelines))):
        if not 1 <= count <= MOST_NAMES:
            raise InputError(f"there are {count} {what}; must be 1 to {MOST_NAMES}")
    if len({preset.name for preset in chosen}) < len(chosen):
        raise InputError("two presets of the plugin have the same name; names must be unique")
    machine, compiler = machine_of(target), compiler_of(target)
    called = name or next(iter(timelines.values())).title or next(iter(timelines))
    bundle = bundle_of(called.strip(), timelines, chosen, seed)
    made = make_folder(folder)
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        for source in (*_SHARED_SOURCES, *_OWN_SOURCES[to]):
            (work / source).write_bytes((SOURCES / source).read_bytes())
        for source, content in c_sources("kernel.c", "operations.h", "overview.h").items():
            (work / source).write_bytes(content)
        (work / "bundle.c").write_text("".join(bundle_source(bundle)), encoding="ascii")
        (work / IMAGES).write_bytes(bundle.data)
        compile_library(compiler, machine, [f"{to}.c", "bundle.c", "kernel.c"], work, "plugin.bin")
        library = (work / "plugin.bin").read_bytes()
    write_files(made, contents_of(to, bundle, machine, library))
    return made / f"{bundle.slug}.{to}"
