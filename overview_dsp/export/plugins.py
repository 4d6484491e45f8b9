"""Audio plugins: the voice in C with the images of a timeline, compiled for digital workstations.

`plugin/` holds the sources: `voice.h` is what every format shares, `bundle.h` what is written here.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from overview_dsp.errors import InputError, OverviewError, shown
from overview_dsp.export.c_folder import c_sources
from overview_dsp.export.lv2_turtle import DESCRIPTIONS, description, manifest
from overview_dsp.export.plugin_bundle import Image, bundle_source, image_of
from overview_dsp.files.atomic import make_folder, whole_file
from overview_dsp.presets.model import Preset
from overview_dsp.timeline import Timeline

PLUGIN_FORMATS = ("clap", "lv2")
MOST_PRESETS = 16
"""In a plugin: each takes 20 MB of memory where it is used."""

_SOURCES = ("bundle.h", "voice.h")
_OWN_SOURCES = {"clap": ("clap.h", "clap.c"), "lv2": ("lv2.h", "lv2.c")}
_FLAGS = ("-std=c11", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off")


def build_plugin(
    timeline: Timeline,
    presets: Preset | Sequence[Preset],
    to: str,
    folder: str | os.PathLike[str],
    *,
    name: str | None = None,
    seed: int = 0,
) -> Path:
    """Compile a timeline to an audio plugin, an instrument that any host of its format plays.

    It needs no Python, and makes the samples of `render`, bit for bit, at any sample rate.

    Parameters
    ----------
    timeline : Timeline
        The data under the hand.
    presets : Preset or sequence of Preset
        How it is felt and heard; of several, up to 16, one is chosen in the host.
    to : str
        The format: `"clap"`, or `"lv2"`: a bundle with a plugin for each preset.
    folder : str or path
        Made, if need be; a plugin of this name in it is replaced.
    name : str, optional
        What it is called; the timeline's title if it isn't given.
    seed : int
        Of the surface's grain.

    Returns
    -------
    Path
        The plugin.

    Raises
    ------
    InputError
        No such format, no or too many presets, two of one name; a folder that can't be written to.
    OverviewError
        There is no C compiler, or it fails.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> ov.export.build_plugin(match, football, "clap", "plugins", name="match").name
    'match.clap'
    """
    if to not in PLUGIN_FORMATS:
        raise InputError(f"no plugin format {shown(to)}; it is {' or '.join(PLUGIN_FORMATS)}")
    chosen = (presets,) if isinstance(presets, Preset) else tuple(presets)
    if not 1 <= len(chosen) <= MOST_PRESETS:
        raise InputError(f"a plugin holds 1 to {MOST_PRESETS} presets, not {len(chosen)}")
    if len({preset.name for preset in chosen}) < len(chosen):
        raise InputError("two presets of a plugin have the same name: name each once")
    called = (name or timeline.title or "timeline").strip()
    slug = re.sub(r"[^a-z0-9]+", "-", called.lower()).strip("-") or "timeline"
    compiler = _compiler()
    images = [image_of(timeline, preset, seed) for preset in chosen]
    made = make_folder(folder)
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        sources = resources.files("overview_dsp.export") / "plugin"
        for source in (*_SOURCES, *_OWN_SOURCES[to]):
            (work / source).write_bytes((sources / source).read_bytes())
        for source, content in c_sources("kernel.c", "operations.h", "overview.h").items():
            (work / source).write_bytes(content)
        bundle = "".join(bundle_source(called, slug, images))
        (work / "bundle.c").write_text(bundle, encoding="ascii")
        _compile(compiler, [f"{to}.c", "bundle.c", "kernel.c"], work, "plugin.bin")
        if to == "lv2":
            return _lv2_bundle(made / f"{slug}.lv2", work / "plugin.bin", called, images)
        plugin = made / f"{slug}.clap"
        with whole_file(plugin) as path:
            shutil.copyfile(work / "plugin.bin", path)
    return plugin


def _lv2_bundle(folder: Path, binary: Path, called: str, images: list[Image]) -> Path:
    """A bundle's folder: the binary, and what hosts read before they load it."""
    make_folder(folder)
    library = "plugin.dll" if os.name == "nt" else "plugin.so"
    contents = {
        library: binary.read_bytes(),
        DESCRIPTIONS: description(called, images).encode(),
        "manifest.ttl": manifest(library, images).encode(),
    }
    for name, content in contents.items():
        with whole_file(folder / name) as path:
            path.write_bytes(content)
    return folder


def _compiler() -> list[str]:
    """The system's C compiler, or the one of PyPI's ziglang."""
    if sys.platform == "darwin":
        raise OverviewError("plugins can't be built on macOS yet: build on Linux or Windows")
    given = os.environ.get("CC", "").split()
    if given:
        if shutil.which(given[0]) is None:
            raise OverviewError(f"there is no compiler {shown(given[0])}, which CC names")
        return given
    for command in ("cc", "gcc", "clang"):
        if shutil.which(command):
            return [command]
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc"]
    raise OverviewError(
        "a plugin needs a C compiler: install gcc or clang (Debian, Ubuntu: apt install gcc), or "
        "pip install ziglang"
    )


def _compile(compiler: list[str], sources: list[str], folder: Path, target: str) -> None:
    """Compile a shared object; OverviewError with the compiler's first error."""
    code = [] if os.name == "nt" else ["-fPIC"]
    command = [*compiler, *_FLAGS, *code, *sources, "-o", target, "-lm"]
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, errors="replace", check=False
        )
    except OSError as error:
        raise OverviewError(f"the C compiler {compiler[0]} doesn't start: {error}") from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or [done.stderr]
        raise OverviewError(f"the C compiler {compiler[0]} failed: {lines[0].strip()}")
