"""Plugin bundle: images of timelines by preset, and their descriptions.

`bundle.c` is compiled with them. LV2 hosts read two Turtle files before loading a bundle.
"""

from __future__ import annotations

import hashlib
import math
import re
import unicodedata
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from importlib import metadata

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import OverviewWarning
from overview_dsp.kernels import layout
from overview_dsp.offline.export.browser_memory import encode_engine
from overview_dsp.offline.export.c_code import prepared_engine

IMAGES = "images.bin"  # file with all images, which `bundle.c` includes
_UNIT_OF_KEY = re.compile(r"_(db|hz|ms|s|mnm)$")


@dataclass(frozen=True)
class Image:
    """Image of a timeline in a preset: bytes, tail in seconds, parameter values, and map.

    The map has times (s) and their positions (0 to 1).
    """

    data: bytes
    tail_s: float
    values: tuple[float, ...]
    map: tuple[tuple[float, float], ...]

    @property
    def digest(self) -> str:
        """SHA-256 digest in hexadecimal."""
        return hashlib.sha256(self.data).hexdigest()


@dataclass(frozen=True)
class Bundle:
    """Bundle: name of the plugin, timelines and presets by name, and an image for each pair.

    Images are ordered by timeline, then by preset. The timelines' starts are seconds since 1970 in
    local time, NaN without a calendar.
    """

    name: str
    timelines: tuple[str, ...]
    starts_s: tuple[float, ...]
    presets: tuple[str, ...]
    images: tuple[Image, ...]

    @property
    def slug(self) -> str:
        """Name for ids and files: ASCII letters, or a digest."""
        plain = unicodedata.normalize("NFKD", self.name).encode("ascii", "ignore").decode()
        digest = hashlib.sha256(self.name.encode()).hexdigest()
        return re.sub(r"[^a-z0-9]+", "-", plain.lower()).strip("-") or f"timeline-{digest[:8]}"

    @property
    def id(self) -> str:
        """Id by which projects find the plugin, independent of its data."""
        return f"org.overview-dsp.{self.slug}"

    def of_preset(self, preset: int) -> tuple[Image, ...]:
        """Return the images of a preset, by timeline."""
        return self.images[preset :: len(self.presets)]

    def uri(self, preset: int) -> str:
        """Return the URI of a preset's LV2 plugin, which depends on the data."""
        digests = [image.digest for image in self.of_preset(preset)]
        if len(digests) > 1:
            digests = [hashlib.sha256("".join(digests).encode()).hexdigest()]
        return f"urn:overview-dsp:{digests[0][:32]}"

    @property
    def data(self) -> bytes:
        """Content of `images.bin`."""
        return b"".join(image.data for image in self.images)


def bundle_of(
    name: str, timelines: Mapping[str, Timeline], presets: Sequence[Preset], seed: int
) -> Bundle:
    """Return the images of all timelines in all presets.

    Equal warnings are shown once, with the names of their timelines and preset.
    """
    images: list[Image] = []
    noted: dict[tuple[str, str, type[Warning]], list[str]] = {}
    for called, timeline in timelines.items():
        for preset in presets:
            with warnings.catch_warnings(record=True) as notes:
                warnings.simplefilter("always", OverviewWarning)
                images.append(_image_of(timeline, preset, seed))
            for one in dict.fromkeys((str(note.message), note.category) for note in notes):
                noted.setdefault((preset.name, *one), []).append(called)
    for (preset_name, text, category), of in noted.items():
        warnings.warn(f"{', '.join(of)} in {preset_name}: {text}", category, stacklevel=3)
    starts = tuple(_start_of(timeline) for timeline in timelines.values())
    names = tuple(preset.name for preset in presets)
    return Bundle(name, tuple(timelines), starts, names, tuple(images))


def _start_of(timeline: Timeline) -> float:
    if timeline.start is None:
        return math.nan
    return (timeline.start.replace(tzinfo=None) - datetime(1970, 1, 1)) / timedelta(seconds=1)


def _image_of(timeline: Timeline, preset: Preset, seed: int) -> Image:
    engine = prepared_engine(timeline, preset, seed)
    data = encode_engine(engine)
    values = engine.memory[layout.PARAMS : layout.PARAMS + layout.PARAMETERS]
    made = engine.surface.angle_map
    points = zip(made.time_s.tolist(), made.position.tolist(), strict=True)
    return Image(data, engine.tail_seconds, tuple(map(float, values)), tuple(points))


def _quoted(text: bytes) -> str:
    """Return a C string of any text, with octal escapes of three digits."""
    return '"' + "".join(_ESCAPED[byte] for byte in text) + '"'


_ESCAPED = [
    chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}"
    for byte in range(256)
]


def parameter_ids() -> list[str]:
    """Return the ids of the kernel's parameters in the order of the memory."""
    columns = [name for name in vars(layout) if name.startswith("PARAM_")]
    columns.sort(key=lambda name: getattr(layout, name))
    ids = {id.upper().replace(".", "_"): id for id in PARAMETERS}
    return [ids[name.removeprefix("PARAM_")] for name in columns]


_HOST_IDS = {
    "tactor.reference_torque_mnm": "tactor.full_torque_mnm",
    "click.reference_torque_mnm": "click.full_torque_mnm",
}
"""The ids of renamed parameters in hosts, whose projects keep the first one."""


def host_id(id: str) -> str:
    """Return the id under which hosts store a parameter; it never changes."""
    return _HOST_IDS.get(id, id)


def label_of(id: str) -> tuple[str, str, tuple[str, ...]]:
    """Return a parameter's name, section, and texts of its choices."""
    section, _, key = id.partition(".")
    known = PARAMETERS[id]
    words = _UNIT_OF_KEY.sub("", key).replace("_", " ")
    if isinstance(known.default, bool):
        choices: tuple[str, ...] = ("off", "on")
    else:
        choices = tuple(map(str, known.choices))
    return f"{section.capitalize()} {words}", section.capitalize(), choices


_DATA = """
#if defined __APPLE__
__asm__(".const\\n.private_extern _bundle_data\\n.p2align 3\\n_bundle_data:\\n"
        ".incbin \\"{file}\\"\\n.text\\n");
#elif defined _WIN32
__asm__(".section .rdata,\\"dr\\"\\n.globl bundle_data\\n.p2align 3\\nbundle_data:\\n"
        ".incbin \\"{file}\\"\\n.text\\n");
#else
__asm__(".pushsection .rodata\\n.globl bundle_data\\n.hidden bundle_data\\n.p2align 3\\n"
        "bundle_data:\\n.incbin \\"{file}\\"\\n.popsection\\n");
#endif
""".replace("{file}", IMAGES)


def bundle_source(bundle: Bundle) -> Iterator[str]:
    """Yield the text of `bundle.c`, which includes the file `images.bin`."""

    def text(value: str) -> str:
        return _quoted(value.encode())

    yield '#include "bundle.h"\n\n#include <math.h>\n\n'
    for what, value in (
        ("id", bundle.id),
        ("name", bundle.name),
        ("version", metadata.version("overview-dsp")),
        ("description", "A timeline under the hand: clicks to hear, a vibration to feel."),
    ):
        yield f"const char bundle_{what}[] = {text(value)};\n"
    named = hashlib.sha256(f"{bundle.id} in VST3".encode()).hexdigest()
    words = ", ".join(f"0x{named[at : at + 8]}" for at in range(0, 32, 8))
    yield f"const uint32_t bundle_class[4] = {{{words}}};\n"
    labels = []
    for number, id in enumerate(parameter_ids()):
        name, section, choices = label_of(id)
        if choices:
            yield f"static const char *const choices_{number}[] = "
            yield f"{{{', '.join(map(text, choices))}}};\n"
        listed = f"choices_{number}" if choices else "NULL"
        texts = ", ".join(map(text, (host_id(id), name, section)))
        labels.append(f"    {{{texts}, {listed}}},\n")
    yield "const bundle_label bundle_labels[OVERVIEW_PARAMETERS] = {\n"
    yield "".join(labels) + "};\n"
    yield f"const int bundle_timelines_count = {len(bundle.timelines)};\n"
    yield f"const char *const bundle_timelines[] = {{{', '.join(map(text, bundle.timelines))}}};\n"
    starts = ", ".join("NAN" if start != start else start.hex() for start in bundle.starts_s)
    yield f"const double bundle_starts[] = {{{starts}}};\n"
    yield f"const int bundle_presets_count = {len(bundle.presets)};\n"
    yield "const bundle_preset bundle_presets[] = {\n"
    for number, preset in enumerate(bundle.presets):
        values = ", ".join(value.hex() for value in bundle.of_preset(number)[0].values)
        yield f"    {{{text(preset)}, {text(bundle.uri(number))},\n     {{{values}}}}},\n"
    yield "};\n"
    for number, image in enumerate(bundle.images):
        points = ", ".join(f"{{{time.hex()}, {place.hex()}}}" for time, place in image.map)
        yield f"static const double map_{number}[][2] = {{{points}}};\n"
    yield "const bundle_image bundle_images[] = {\n"
    at = 0
    for number, image in enumerate(bundle.images):
        size, points = len(image.data), f"map_{number}, {len(image.map)}"
        yield f"    {{{text(image.digest)}, {at}, {size}, {image.tail_s.hex()}, {points}}},\n"
        at += size
    yield "};\n" + _DATA


DESCRIPTIONS = "plugins.ttl"

_PREFIXES = """\
@prefix atom: <http://lv2plug.in/ns/ext/atom#> .
@prefix doap: <http://usefulinc.com/ns/doap#> .
@prefix lv2: <http://lv2plug.in/ns/lv2core#> .
@prefix midi: <http://lv2plug.in/ns/ext/midi#> .
@prefix pprops: <http://lv2plug.in/ns/ext/port-props#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix units: <http://lv2plug.in/ns/extensions/units#> .
@prefix urid: <http://lv2plug.in/ns/ext/urid#> .

"""
_UNITS = {"dB": "db", "Hz": "hz", "ms": "ms", "s": "s"}
_FIXED_PORTS = (
    "a lv2:InputPort , atom:AtomPort ; atom:bufferType atom:Sequence ; "
    "atom:supports midi:MidiEvent ; lv2:designation lv2:control ; "
    'lv2:symbol "events" ; lv2:name "Taps"',
    'a lv2:OutputPort , lv2:AudioPort ; lv2:symbol "click" ; lv2:name "Click"',
    'a lv2:OutputPort , lv2:AudioPort ; lv2:symbol "tactor" ; lv2:name "Tactor"',
    'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "theta2" ; lv2:name "Angle" ; '
    "lv2:default 0.0 ; lv2:minimum 0.0 ; lv2:maximum 1.0",
    'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "touch" ; lv2:name "Touch" ; '
    "lv2:default 0.0 ; lv2:minimum 0.0 ; lv2:maximum 1.0 ; lv2:portProperty lv2:toggled",
)


def manifest(library: str, bundle: Bundle) -> str:
    """Return the text of `manifest.ttl`: one plugin per preset, all in one library."""
    plugins = "".join(
        f"<{bundle.uri(number)}> a lv2:Plugin ; "
        f"lv2:binary <{library}> ; rdfs:seeAlso <{DESCRIPTIONS}> .\n"
        for number in range(len(bundle.presets))
    )
    return _PREFIXES + plugins


def description(bundle: Bundle) -> str:
    """Return the text of the file with names, ports, ranges and units."""
    plugins = []
    for number, preset in enumerate(bundle.presets):
        name = bundle.name if len(bundle.presets) == 1 else f"{bundle.name}, {preset}"
        ports = [*_FIXED_PORTS, *_controls(bundle.of_preset(number)[0].values)]
        if len(bundle.timelines) > 1:
            ports.append(
                'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "timeline" ; '
                'lv2:name "Timeline" ; lv2:default 0.0 ; lv2:minimum 0.0 ; '
                f"lv2:maximum {len(bundle.timelines) - 1}.0{_enumeration(bundle.timelines)}"
            )
        listed = " ,\n    ".join(
            f"[ {port} ; lv2:index {index} ]" for index, port in enumerate(ports)
        )
        plugins.append(
            f"<{bundle.uri(number)}> a lv2:InstrumentPlugin , lv2:Plugin ; "
            f"doap:name {_text(name)} ;\n"
            "    doap:license <https://spdx.org/licenses/MIT> ;\n"
            "    lv2:requiredFeature urid:map ; lv2:optionalFeature lv2:hardRTCapable ;\n"
            "    lv2:minorVersion 2 ; lv2:microVersion 0 ;\n"
            f"    lv2:port {listed} .\n\n"
        )
    return _PREFIXES + "".join(plugins)


def _enumeration(choices: Sequence[str]) -> str:
    """Return the properties of a control port with choices."""
    points = " , ".join(
        f"[ rdfs:label {_text(choice)} ; rdf:value {number}.0 ]"
        for number, choice in enumerate(choices)
    )
    return f" ; lv2:portProperty lv2:enumeration , lv2:integer ; lv2:scalePoint {points}"


def _controls(values: Sequence[float]) -> Iterator[str]:
    """Return a control port for each kernel parameter."""
    for id, value in zip(parameter_ids(), values, strict=True):
        known = PARAMETERS[id]
        name, _, choices = label_of(id)
        low, high = (0.0, len(choices) - 1.0) if choices else (known.low, known.high)
        port = (
            f'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "{host_id(id).replace(".", "_")}" ; '
            f"lv2:name {_text(name)} ; "
            f"lv2:default {value!r} ; lv2:minimum {low!r} ; lv2:maximum {high!r}"
        )
        if isinstance(known.default, bool):
            port += " ; lv2:portProperty lv2:toggled"
        elif choices:
            port += _enumeration(choices)
        elif known.scale == "log":
            port += " ; lv2:portProperty pprops:logarithmic"
        if known.unit in _UNITS:
            port += f" ; units:unit units:{_UNITS[known.unit]}"
        elif known.unit:
            unit = _text(known.unit)
            port += (
                f" ; units:unit [ a units:Unit ; rdfs:label {unit} ; units:symbol {unit} ; "
                f"units:render {_text(f'%f {known.unit}')} ]"
            )
        yield port


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " else " " for c in escaped) + '"'
