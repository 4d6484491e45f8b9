"""Plugin bundle: images of timelines by preset, and their descriptions.

`bundle.c` is compiled with them. LV2 hosts read two Turtle files before loading a bundle.
"""

from __future__ import annotations

import hashlib
import math
import re
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC
from importlib import metadata, resources
from urllib.parse import quote

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.errors import OverviewWarning
from overview_dsp.kernels import layout
from overview_dsp.kernels.derive import ARRIVAL_S
from overview_dsp.offline.export.browser_memory import encode_engine
from overview_dsp.offline.export.c_code import prepared_engine
from overview_dsp.offline.rendering.many import RenderedJob, render_jobs, render_many

SOURCES = resources.files("overview_dsp.offline.export") / "plugin"
IMAGES = "images.bin"  # file with all images, which `data.h` includes
_UNIT_OF_KEY = re.compile(r"_(db|hz|ms|s|mnm)$")


@dataclass(frozen=True)
class Image:
    """Image of a timeline in a preset: bytes, tail in seconds, parameter values, and map.

    The tail is that at 48 kHz and below; it is longer for each octave of the sample rate above. The
    map has times (s) and their positions (0 to 1).
    """

    data: bytes
    tail_s: float
    tail_per_octave_s: float
    values: tuple[float, ...]
    map: tuple[tuple[float, float], ...]


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
        """Name of its files: ASCII letters, or a digest."""
        plain = unicodedata.normalize("NFKD", self.name).encode("ascii", "ignore").decode()
        return re.sub(r"[^a-z0-9]+", "-", plain.lower()).strip("-") or f"timeline-{self._digest}"

    @property
    def _digest(self) -> str:
        return hashlib.sha256(self.name.encode()).hexdigest()[:8]

    @property
    def _own_name(self) -> str:
        """Name for ids, different for different names: a digest follows a slug that differs."""
        return self.slug if self.slug == self.name else f"{self.slug}.{self._digest}"

    @property
    def id(self) -> str:
        """Id by which projects find the plugin, independent of its data."""
        return f"org.overview-dsp.{self._own_name}"

    def of_preset(self, preset: int) -> tuple[Image, ...]:
        """Return the images of a preset, by timeline."""
        return self.images[preset :: len(self.presets)]

    def uri(self, preset: int) -> str:
        """Return the URI of a preset's LV2 plugin, by which projects find it, as by `id`."""
        return f"urn:overview-dsp:{self._own_name}:{quote(self.presets[preset], safe='')}"

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
    starts = tuple(
        timeline.start.replace(tzinfo=UTC).timestamp() if timeline.start else math.nan
        for timeline in timelines.values()
    )
    names = tuple(preset.name for preset in presets)
    images = list(_with_tails(images, timelines.values(), presets, seed))
    return Bundle(name, tuple(timelines), starts, names, tuple(images))


def _image_of(timeline: Timeline, preset: Preset, seed: int) -> Image:
    engine = prepared_engine(timeline, preset, seed)
    data = encode_engine(engine)
    values = engine.memory[layout.PARAMS : layout.PARAMS + layout.PARAMETERS]
    made = engine.surface.angle_map
    points = zip(made.time_s.tolist(), made.position.tolist(), strict=True)
    return Image(data, engine.tail_seconds, 0.0, tuple(map(float, values)), tuple(points))


_FROM_END = sweep(8.0, 1.0, 1.0)  # a disk at rest at the end has the longest way back
_HELD = tuple(sweep(2.0, place, place) for place in (np.arange(1, 17) * 0.618 % 1.0).tolist())
_TAIL_MARGIN_S = 0.1  # for other movements and sample rates


def _with_tails(
    images: Sequence[Image], timelines: Iterable[Timeline], presets: Sequence[Preset], seed: int
) -> Iterator[Image]:
    """Yield images with an upper bound of the time from a release to the last sound.

    A released disk moves to its last target, for `ARRIVAL_S` at most, and then returns for no
    longer than from rest at the end of the timeline. Bristles and detents may hold it anywhere, so
    that its return is measured from several positions. At higher rates, softer texture is heard.
    """
    with warnings.catch_warnings(action="ignore"):  # the images gave them
        jobs = list(render_jobs(timelines, presets, (_FROM_END,), (seed,)))
        highs = render_many(jobs, 4 * 48_000)
        for image, one, high in zip(images, render_many(jobs), highs, strict=True):
            tail_s = _sound_s(one)
            per_octave_s = max(0.0, _sound_s(high) - tail_s) / 2.0 if tail_s < math.inf else 0.0
            if one.surface.bristles is not None or one.surface.detents is not None:
                held = render_many([replace(one.job, gesture=gesture) for gesture in _HELD])
                tail_s = max(tail_s, *map(_sound_s, held))
            tail_s = min(ARRIVAL_S + tail_s + _TAIL_MARGIN_S, image.tail_s)
            yield replace(image, tail_s=tail_s, tail_per_octave_s=min(per_octave_s, image.tail_s))


def _sound_s(one: RenderedJob[None]) -> float:
    """Return the time from the release to the last sound; a render ends 30 s after the gesture."""
    last = int(np.flatnonzero(np.append(True, one.samples.any(axis=1)))[-1])
    is_over = last < len(one.samples)
    return last / one.sample_rate - one.job.gesture.duration_s if is_over else math.inf


def _quoted(text: str) -> str:
    """Return a C string of any text, with octal escapes of three digits."""
    plain = set(range(32, 127)) - set(b'"\\?')
    return '"' + "".join(chr(b) if b in plain else f"\\{b:03o}" for b in text.encode()) + '"'


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
    choices = ("off", "on") if isinstance(known.default, bool) else map(str, known.choices)
    return f"{section.capitalize()} {words}", section.capitalize(), tuple(choices)


def bundle_source(bundle: Bundle) -> Iterator[str]:
    """Yield the text of `bundle.c`, which includes the file `images.bin`."""
    yield '#include "bundle.h"\n\n#include <math.h>\n\n'
    yield f"const char bundle_id[] = {_quoted(bundle.id)};\n"
    yield f"const char bundle_name[] = {_quoted(bundle.name)};\n"
    yield f"const char bundle_version[] = {_quoted(metadata.version('overview-dsp'))};\n"
    named = hashlib.sha256(f"{bundle.id} in VST3".encode()).hexdigest()
    words = ", ".join(f"0x{named[at : at + 8]}" for at in range(0, 32, 8))
    yield f"const uint32_t bundle_class[4] = {{{words}}};\n"
    labels = []
    for number, id in enumerate(parameter_ids()):
        name, section, choices = label_of(id)
        if choices:
            yield f"static const char *const choices_{number}[] = "
            yield f"{{{', '.join(map(_quoted, choices))}}};\n"
        listed = f"choices_{number}" if choices else "NULL"
        texts = ", ".join(map(_quoted, (host_id(id), name, section)))
        labels.append(f"    {{{texts}, {listed}, {PARAMETERS[id].scale == 'log':d}}},\n")
    yield "const bundle_label bundle_labels[OVERVIEW_PARAMETERS] = {\n"
    yield "".join(labels) + "};\n"
    yield f"const int bundle_timelines_count = {len(bundle.timelines)};\n"
    listed = ", ".join(map(_quoted, bundle.timelines))
    yield f"const char *const bundle_timelines[] = {{{listed}}};\n"
    starts = ", ".join("NAN" if start != start else start.hex() for start in bundle.starts_s)
    yield f"const double bundle_starts[] = {{{starts}}};\n"
    yield f"const int bundle_presets_count = {len(bundle.presets)};\n"
    yield "const bundle_preset bundle_presets[] = {\n"
    for number, preset in enumerate(bundle.presets):
        values = ", ".join(value.hex() for value in bundle.of_preset(number)[0].values)
        yield f"    {{{_quoted(preset)}, {_quoted(bundle.uri(number))},\n     {{{values}}}}},\n"
    yield "};\n"
    for number, image in enumerate(bundle.images):
        points = ", ".join(f"{{{time.hex()}, {place.hex()}}}" for time, place in image.map)
        yield f"static const double map_{number}[][2] = {{{points}}};\n"
    yield "const bundle_image bundle_images[] = {\n"
    at = 0
    for number, image in enumerate(bundle.images):
        size, points = len(image.data), f"map_{number}, {len(image.map)}"
        digest = _quoted(hashlib.sha256(image.data).hexdigest())
        tail = f"{image.tail_s.hex()}, {image.tail_per_octave_s.hex()}"
        yield f"    {{{digest}, {at}, {size}, {tail}, {points}}},\n"
        at += size
    yield '};\n#include "data.h"\n'


DESCRIPTIONS = "plugins.ttl"


def manifest(library: str, bundle: Bundle) -> str:
    """Return the text of `manifest.ttl`: one plugin per preset, all in one library."""
    plugins = "".join(
        f"<{bundle.uri(number)}> a lv2:Plugin ; "
        f"lv2:binary <{library}> ; rdfs:seeAlso <{DESCRIPTIONS}> .\n"
        for number in range(len(bundle.presets))
    )
    return _file_text("prefixes.ttl") + plugins


def description(bundle: Bundle) -> str:
    """Return the text of the file with names, ports, ranges and units."""
    plugins = []
    for number, preset in enumerate(bundle.presets):
        name = bundle.name if len(bundle.presets) == 1 else f"{bundle.name}, {preset}"
        ports = [
            *_file_text("ports.ttl").splitlines(),
            *_controls(bundle.of_preset(number)[0].values),
        ]
        if len(bundle.timelines) > 1:
            ports.append(
                'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "timeline" ; '
                'lv2:name "Timeline" ; lv2:default 0.0 ; lv2:minimum 0.0 ; '
                f"lv2:maximum {len(bundle.timelines) - 1}.0{_enumeration(bundle.timelines)}"
            )
        numbered = (f"[ {port} ; lv2:index {index} ]" for index, port in enumerate(ports))
        listed = " ,\n    ".join(numbered)
        plugins.append(
            f"<{bundle.uri(number)}> a lv2:InstrumentPlugin , lv2:Plugin ; "
            f"doap:name {_text(name)} ;\n"
            "    doap:license <https://spdx.org/licenses/MIT> ;\n"
            "    lv2:requiredFeature urid:map ; lv2:optionalFeature lv2:hardRTCapable ;\n"
            "    lv2:minorVersion 2 ; lv2:microVersion 0 ;\n"
            f"    lv2:port {listed} .\n\n"
        )
    return _file_text("prefixes.ttl") + "".join(plugins)


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
        if known.unit in ("dB", "Hz", "ms", "s"):
            port += f" ; units:unit units:{known.unit.lower()}"
        elif known.unit:
            unit = _text(known.unit)
            port += (
                f" ; units:unit [ a units:Unit ; rdfs:label {unit} ; units:symbol {unit} ; "
                f"units:render {_text(f'%f {known.unit}')} ]"
            )
        yield port


def _file_text(name: str) -> str:
    return (SOURCES / name).read_text(encoding="utf-8")


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " else " " for c in escaped) + '"'
