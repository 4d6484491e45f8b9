"""What an LV2 host reads of a bundle before it loads it: two files in Turtle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.offline.export.plugin_bundle import Bundle, label_of, parameter_ids

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
    """The text of `manifest.ttl`: a plugin for each preset, all in one library."""
    plugins = "".join(
        f"<{bundle.uri(number)}> a lv2:Plugin ; "
        f"lv2:binary <{library}> ; rdfs:seeAlso <{DESCRIPTIONS}> .\n"
        for number in range(len(bundle.presets))
    )
    return _PREFIXES + plugins


def description(bundle: Bundle) -> str:
    """The text of the file that the manifest points to: names, ports, ranges, units."""
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
    """What makes a control port one of several choices."""
    points = " , ".join(
        f"[ rdfs:label {_text(choice)} ; rdf:value {number}.0 ]"
        for number, choice in enumerate(choices)
    )
    return f" ; lv2:portProperty lv2:enumeration , lv2:integer ; lv2:scalePoint {points}"


def _controls(values: Sequence[float]) -> Iterator[str]:
    """A control port for each parameter that isn't the surface's."""
    for id, value in zip(parameter_ids(), values, strict=True):
        known = PARAMETERS[id]
        name, _, choices = label_of(id)
        low, high = (0.0, len(choices) - 1.0) if choices else (known.low, known.high)
        port = (
            f'a lv2:InputPort , lv2:ControlPort ; lv2:symbol "{id.replace(".", "_")}" ; '
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
