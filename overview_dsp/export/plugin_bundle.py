"""What a plugin holds: images of a timeline by preset, embedded in the text of `bundle.c`."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import metadata

from overview_dsp.engine.engine import Engine
from overview_dsp.export.browser_memory import encode_engine
from overview_dsp.kernels import layout
from overview_dsp.presets.model import Preset
from overview_dsp.presets.parameters import PARAMETERS
from overview_dsp.timeline import Timeline

_IMAGE_RATE = 48_000.0  # of no consequence: a voice goes to its own when it is prepared
_UNIT_OF_KEY = re.compile(r"_(db|hz|ms|s|mnm)$")


@dataclass(frozen=True)
class Image:
    """A preset of a bundle: the name, the image, its tail in seconds, its parameters' values."""

    name: str
    data: bytes
    tail_s: float
    values: tuple[float, ...]

    @property
    def digest(self) -> str:
        """SHA-256, in hexadecimal."""
        return hashlib.sha256(self.data).hexdigest()

    @property
    def uri(self) -> str:
        """Of its LV2 plugin: of other data it is another plugin."""
        return f"urn:overview-dsp:{self.digest[:32]}"


def image_of(timeline: Timeline, preset: Preset, seed: int) -> Image:
    """The image of a timeline in a preset."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(_IMAGE_RATE)
    data = encode_engine(engine)
    values = engine.memory[layout.PARAMS : layout.PARAMS + layout.PARAMETERS]
    return Image(preset.name, data, engine.tail_seconds, tuple(map(float, values)))


def _quoted(text: bytes) -> str:
    """A C string of any bytes; always three digits, so that a digit may follow."""
    return '"' + "".join(_ESCAPED[byte] for byte in text) + '"'


_ESCAPED = [
    chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}"
    for byte in range(256)
]


def parameter_ids() -> list[str]:
    """The ids of what isn't the surface's, in the memory's order."""
    columns = [name for name in vars(layout) if name.startswith("PARAM_")]
    columns.sort(key=lambda name: getattr(layout, name))
    ids = {id.upper().replace(".", "_"): id for id in PARAMETERS}
    return [ids[name.removeprefix("PARAM_")] for name in columns]


def label_of(id: str) -> tuple[str, str, tuple[str, ...]]:
    """A parameter's name, its section, and the texts of its choices."""
    section, _, key = id.partition(".")
    known = PARAMETERS[id]
    words = _UNIT_OF_KEY.sub("", key).replace("_", " ")
    if isinstance(known.default, bool):
        choices: tuple[str, ...] = ("off", "on")
    else:
        choices = tuple(map(str, known.choices))
    return f"{section.capitalize()} {words}", section.capitalize(), choices


def bundle_source(called: str, slug: str, images: Sequence[Image]) -> Iterator[str]:
    """The text of `bundle.c`, in pieces."""

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
    for number, id in enumerate(parameter_ids()):
        name, section, choices = label_of(id)
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
            f"    {{{text(image.name)}, {text(image.uri)}, {text(image.digest)},\n"
            f"     image_{number}, {len(image.data)}, {image.tail_s.hex()},\n     {{{values}}}}},\n"
        )
    yield "};\n"
