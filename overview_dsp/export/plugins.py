"""Audio plugins: the voice in C with the images of a timeline, compiled for digital workstations.

`plugin/` holds the sources: `voice.h` is what every format shares, `bundle.h` what is written here.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError, OverviewError, shown
from overview_dsp.export.browser_memory import encode_engine
from overview_dsp.export.c_folder import c_sources
from overview_dsp.files.atomic import make_folder, whole_file
from overview_dsp.kernels import layout
from overview_dsp.presets.model import Preset
from overview_dsp.presets.parameters import PARAMETERS
from overview_dsp.timeline import Timeline

PLUGIN_FORMATS = ("clap",)
MOST_PRESETS = 16
"""In a plugin: each takes 20 MB of memory where it is used."""

_SOURCES = ("bundle.h", "voice.h")
_OWN_SOURCES = {"clap": ("clap.h", "clap.c")}
_FLAGS = ("-std=c11", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off")
_IMAGE_RATE = 48_000.0  # of no consequence: a voice goes to its own when it is prepared
_UNIT_OF_KEY = re.compile(r"_(db|hz|ms|s|mnm)$")


@dataclass(frozen=True)
class _Image:
    """A preset of a bundle: the name, the image, its tail in seconds, its parameters' values."""

    name: str
    data: bytes
    tail_s: float
    values: tuple[float, ...]

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.data).hexdigest()


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
        The format: `"clap"`.
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
    images = [_image(timeline, preset, seed) for preset in chosen]
    made = make_folder(folder)
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        sources = resources.files("overview_dsp.export") / "plugin"
        for source in (*_SOURCES, *_OWN_SOURCES[to]):
            (work / source).write_bytes((sources / source).read_bytes())
        for source, content in c_sources("kernel.c", "overview.h").items():
            (work / source).write_bytes(content)
        bundle = "".join(_bundle(called, slug, images))
        (work / "bundle.c").write_text(bundle, encoding="ascii")
        _compile(compiler, [f"{to}.c", "bundle.c", "kernel.c"], work, "plugin.bin")
        plugin = made / f"{slug}.clap"
        with whole_file(plugin) as path:
            shutil.copyfile(work / "plugin.bin", path)
    return plugin


def _image(timeline: Timeline, preset: Preset, seed: int) -> _Image:
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(_IMAGE_RATE)
    data = encode_engine(engine)
    values = engine.memory[layout.PARAMS : layout.PARAMS + layout.PARAMETERS]
    return _Image(preset.name, data, engine.tail_seconds, tuple(map(float, values)))


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


def _quoted(text: bytes) -> str:
    """A C string of any bytes; always three digits, so that a digit may follow."""
    return '"' + "".join(_ESCAPED[byte] for byte in text) + '"'


_ESCAPED = [
    chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}"
    for byte in range(256)
]


def _parameters() -> list[str]:
    """The ids of what isn't the surface's, in the memory's order."""
    columns = [name for name in vars(layout) if name.startswith("PARAM_")]
    columns.sort(key=lambda name: getattr(layout, name))
    ids = {id.upper().replace(".", "_"): id for id in PARAMETERS}
    return [ids[name.removeprefix("PARAM_")] for name in columns]


def _label(id: str) -> tuple[str, str, tuple[str, ...]]:
    """A parameter's name, its section, and the texts of its choices."""
    section, _, key = id.partition(".")
    known = PARAMETERS[id]
    words = _UNIT_OF_KEY.sub("", key).replace("_", " ")
    if isinstance(known.default, bool):
        choices: tuple[str, ...] = ("off", "on")
    else:
        choices = tuple(map(str, known.choices))
    return f"{section.capitalize()} {words}", section.capitalize(), choices


def _bundle(called: str, slug: str, images: list[_Image]) -> Iterator[str]:
    """The text of `bundle.c`."""

    def text(value: str) -> str:
        return _quoted(value.encode())

    yield '#include "bundle.h"\n\n'
    version = metadata.version("overview-dsp")
    for what, value in (
        ("id", f"org.overview-dsp.{slug}"),
        ("name", called),
        ("version", version),
        ("description", "A timeline under the hand: clicks to hear, a vibration to feel."),
    ):
        yield f"const char bundle_{what}[] = {text(value)};\n"
    labels = []
    for number, id in enumerate(_parameters()):
        name, section, choices = _label(id)
        if choices:
            yield f"static const char *const choices_{number}[] = "
            yield f"{{{', '.join(map(text, choices))}}};\n"
        listed = f"choices_{number}" if choices else "NULL"
        labels.append(f"    {{{text(name)}, {text(section)}, {listed}}},\n")
    yield "const bundle_label bundle_labels[OVERVIEW_PARAMETERS] = {\n"
    yield "".join(labels) + "};\n"
    for number, image in enumerate(images):
        yield f"static const char image_{number}[] =\n"
        for at in range(0, len(image.data), 1000):
            yield f"    {_quoted(image.data[at : at + 1000])}\n"
        yield ";\n"
    yield f"const int bundle_presets_count = {len(images)};\n"
    yield "const bundle_preset bundle_presets[] = {\n"
    for number, image in enumerate(images):
        values = ", ".join(value.hex() for value in image.values)
        yield (
            f"    {{{text(image.name)}, {text(image.digest)}, image_{number}, {len(image.data)}, "
            f"{image.tail_s.hex()},\n     {{{values}}}}},\n"
        )
    yield "};\n"
