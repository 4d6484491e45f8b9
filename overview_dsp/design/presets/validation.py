"""A preset file's text to Preset: a pydantic model made from the parameter table checks it.

Errors name file and line, also where the value stands in a file that the preset extends.

A preset file and those it extends, as one.

`extends = "football"` takes everything from that preset (a bundled or own name, or a path from the
file's folder) and changes what is written here: single keys, kinds, variables. A list of modes is
taken whole. Variables of the base may be set anew, and what is worked out from them follows.

Preset files of older schema versions, brought up to the present one.

| version | what is new |
|---|---|
| 1 | the first |
| 2 | `extends`, `authors`, `[tags]`, `[variables]`, `kinds.*.spacing_percent` |
| 3 | `[clutch]`: `max_speed_ratio` was `disk.catch_up`, `tap_duration_s` was `disk.unfold_s` |
| 4 | other names (`_RENAMED`, `_RENAMED_OF_KIND`): `intensity_gain` was `ambience`, for example |

In version 2 a tap took `unfold_s / catch_up`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

from overview_dsp.design.presets.expressions import ExpressionError, evaluate_expressions
from overview_dsp.design.presets.model import (
    DEFAULT_KIND,
    TAG_SCALES,
    ClickMode,
    EventKind,
    Preset,
    Tags,
)
from overview_dsp.design.presets.parameter import Parameter
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MAX_ALIASES,
    MAX_POINTS,
    MODE_PARAMETERS,
    SECTIONS,
)
from overview_dsp.errors import InputError, shown
from overview_dsp.files.schema import Allowed, Fault, Path, Strict, checked, named
from overview_dsp.files.toml import line_of, parse_toml
from overview_dsp.kernels.layout import MAX_KINDS, MAX_MODES

SCHEMA = 4

_RENAMED = {
    "surface.ambience": "surface.intensity_gain",
    "surface.grip": "surface.torque_ratio",
    "surface.ring": "surface.decay_scale",
    "tactor.full_torque_mnm": "tactor.reference_torque_mnm",
    "click.full_torque_mnm": "click.reference_torque_mnm",
    "twist.turn_deg": "twist.engage_deg",
    "twist.join_ms": "twist.blend_ms",
    "follow.map": "follow.layout",
}
"""Parameter ids of schema 3 that have another name in schema 4."""

_RENAMED_OF_KIND = {"also": "aliases", "ring": "decay_scale"}
"""The same for the keys of an event kind."""


def migrate_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by parameter id, with the ids and meanings of the present schema."""
    found = {_RENAMED.get(id, id): value for id, value in values.items()}
    ratio = found.pop("disk.catch_up", None)
    tap_s = found.pop("disk.unfold_s", None)
    if ratio is not None:
        found["clutch.max_speed_ratio"] = ratio
    if tap_s is not None:
        known = all(isinstance(value, int | float) for value in (ratio, tap_s))
        found["clutch.tap_duration_s"] = min(tap_s / ratio, 10.0) if known and ratio else tap_s
    return found


def migrate_kind(kind: Mapping[str, Any]) -> dict[str, Any]:
    """Return an event kind's data, with the keys of the present schema."""
    return {_RENAMED_OF_KIND.get(key, key): value for key, value in kind.items()}


def migrate(data: dict[str, Any]) -> dict[str, Any]:
    """Return a file's data in the present schema; an unknown version is left for the check."""
    version = data.get("schema")
    if type(version) is not int or not 1 <= version < SCHEMA:
        return data
    tables = {name: data[name] for name in SECTIONS if isinstance(data.get(name), dict)}
    found = {**data, "schema": SCHEMA, **{name: {} for name in tables}}
    values = {
        f"{name}.{key}": value for name, keys in tables.items() for key, value in keys.items()
    }
    for id, value in migrate_values(values).items():
        section, _, key = id.partition(".")
        table = found.setdefault(section, {})
        if isinstance(table, dict):
            table[key] = value
    if isinstance(kinds := data.get("kinds"), dict):
        found["kinds"] = {
            name: migrate_kind(kind) if isinstance(kind, dict) else kind
            for name, kind in kinds.items()
        }
    return found


MAX_LAYERS = 8

Find = Callable[[str, str], tuple[str, str]]
"""From (what `extends` says, the file that says it) to (the base's file, its text)."""


@dataclass(frozen=True)
class Layer:
    """One file: where it is, its text, and its data in the present schema."""

    source: str
    text: str
    data: dict[str, Any]


def read_layers(source: str, text: str, find: Find) -> list[Layer]:
    """The file and its bases, the file first.

    Raises
    ------
    InputError
        Not TOML; a base that isn't there, is no name, or extends what extends it.
    """
    layers = [_layer(source, text)]
    while (base := layers[-1].data.get("extends")) is not None:
        here = layers[-1]
        if not isinstance(base, str):
            raise InputError(f"{here.source}: extends = {shown(base)}; it is a preset's name")
        if len(layers) == MAX_LAYERS:
            raise InputError(f"{source}: more than {MAX_LAYERS} presets extend each other")
        try:
            found = find(base, here.source)
        except InputError as error:
            raise InputError(f"{here.source}: extends: {error}") from None
        if any(found[0] == layer.source for layer in layers):
            raise InputError(f"{here.source}: extends {base!r}, which extends it in turn")
        layers.append(_layer(*found))
    return layers


def _layer(source: str, text: str) -> Layer:
    return Layer(source, text, migrate(parse_toml(text, source)))


def merged(layers: list[Layer]) -> dict[str, Any]:
    """The data of all layers as one, the first layer's last word."""
    found: dict[str, Any] = {}
    for layer in reversed(layers):
        own = {key: value for key, value in layer.data.items() if key != "extends"}
        found = _over(found, own)
    return found


def _over(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    found = dict(base)
    for key, value in own.items():
        below = found.get(key)
        if not (isinstance(below, dict) and isinstance(value, dict)):
            found[key] = value
            continue
        found[key] = _over(below, value)
        # an event's width is given in one of two ways: the file's own is meant
        _one_width(found[key], value)
    return found


def _one_width(found: dict[str, Any], own: dict[str, Any]) -> None:
    for given, other in (("width_percent", "width_ms"), ("width_ms", "width_percent")):
        if given in own and other not in own:
            found.pop(other, None)


def layer_of(layers: list[Layer], path: Path) -> Layer:
    """The layer that says a value: the first one that has it, else the file itself."""
    for layer in layers:
        value: Any = layer.data
        for part in path:
            try:
                value = value[part]
            except (KeyError, IndexError, TypeError):
                break
        else:
            return layer
    return layers[0]


MAP_DOC = (
    "The intensity map: of even steps of the timeline's curve, the part of the ambience that is "
    "felt there, 0 to 1; none is a straight line."
)
_POINTS_DOC = "The friction's course over two widths, 0 to 1, in place of the shape's."
_ALIASES_DOC = "Other kinds of event that feel like this one, unless they are named."


def _field(known: Parameter) -> tuple[Any, Any]:
    default: Any = ... if known.default is None else known.default
    if known.choices:
        kind: Any = bool if isinstance(known.choices[0], bool) else Literal[known.choices]
        return Annotated[kind, Allowed(known.allowed)], Field(default, description=known.doc)
    kind = Annotated[float, Field(ge=known.low, le=known.high), Allowed(known.allowed)]
    if known.key.startswith("width_"):
        kind, default = kind | None, None
    unit: Any = {"unit": known.unit}
    return kind, Field(default, description=known.doc, json_schema_extra=unit)


def _model(name: str, parameters: Iterable[Parameter], **more: Any) -> Any:
    """The model of a table of parameters, and of `more`."""
    fields: dict[str, Any] = {known.key: _field(known) for known in parameters}
    return pydantic.create_model(name, __base__=Strict, **fields, **more)


def _many(kind: Any, most: int | None = None, doc: str | None = None) -> tuple[Any, Any]:
    return list[kind], Field(default_factory=list, max_length=most, description=doc)


@cache
def preset_model() -> type[pydantic.BaseModel]:
    """The pydantic model of a preset file, made from the parameter table."""
    part = Annotated[float, Field(ge=0.0, le=1.0)]
    more = {"surface": {"points": _many(part, MAX_POINTS, MAP_DOC)}}
    sections: dict[str, Any] = {
        section: _model(section.capitalize(), members.values(), **more.get(section, {}))
        for section, members in SECTIONS.items()
    }
    scale: Any = (Annotated[float, Field(ge=1.0, le=5.0), Allowed("1 to 5")] | None, None)
    sections["tags"] = _model("Tags", (), **dict.fromkeys(TAG_SCALES, scale), usage=_many(str))
    kind = _model(
        "Kind",
        KIND_PARAMETERS.values(),
        modes=_many(_model("Mode", MODE_PARAMETERS.values()), MAX_MODES),
        points=_many(float, MAX_POINTS, _POINTS_DOC),
        aliases=_many(str, MAX_ALIASES, _ALIASES_DOC),
    )
    found: type[pydantic.BaseModel] = _model(
        "Preset",
        (),
        # an alias: pydantic has a method of the file's name for it
        schema_version=(int, Field(..., alias="schema", ge=SCHEMA, le=SCHEMA)),
        title=(str, Field(..., description="What the preset is called.")),
        description=(str, Field(..., description="What it feels like, in a line.")),
        authors=_many(str),
        variables=(dict[str, float], Field(default_factory=dict)),
        kinds=(dict[str, kind], Field(max_length=MAX_KINDS)),  # type: ignore[valid-type]
        **{name: (model, Field(default_factory=model)) for name, model in sections.items()},
    )
    return found


def _is_number(value: object) -> bool:
    # an int of thousands of digits isn't one here: the check will say so
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _no_base(base: str, source: str) -> tuple[str, str]:
    raise InputError(f"{base!r} can't be looked up here")


def parse_preset(text: str, name: str, source: str, find: Find = _no_base) -> Preset:
    """A preset from a file's text.

    Parameters
    ----------
    text
        TOML.
    name
        Of the preset.
    source
        The file, for errors.
    find
        Looks up what `extends` names.

    Raises
    ------
    InputError
        Not TOML, an unknown key, a wrong type or a value out of range: names file, line, key and
        range, and how many further faults there are.
    """
    layers = read_layers(source, text, find)
    data = merged(layers)
    variables = data.get("variables", {})
    if not isinstance(variables, dict):
        place = _place(layers, ("variables",))
        raise InputError(f"{place}: variables = {shown(variables)}; it is a table of numbers")
    numbers = {key: float(number) for key, number in variables.items() if _is_number(number)}
    found: Any
    try:
        found = checked(preset_model(), evaluate_expressions(data, numbers))
    except ExpressionError as error:
        found = [Fault(error.path, f"{named(error.path)}: {error}")]
    if isinstance(found, list):
        path, words = found[0]
        if path == ("schema",) and "schema" in data:
            given = shown(data["schema"])
            words = f"schema = {given} is not known; this version reads schema = 1 to {SCHEMA}"
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        raise InputError(f"{_place(layers, path)}: {words}{more}")
    dumped = found.model_dump()
    kinds: dict[str, EventKind] = {}
    for kind_name, members in dumped["kinds"].items():
        modes = tuple(ClickMode(**mode) for mode in members.pop("modes"))
        try:
            kinds[kind_name] = EventKind(modes=modes, **members)
        except InputError as error:
            place = _place(layers, ("kinds", kind_name))
            raise InputError(f"{place}: kinds.{kind_name}: {error}") from None
    if DEFAULT_KIND not in kinds:
        raise InputError(
            f"{source}: kinds.{DEFAULT_KIND} is missing; "
            "add it, for events of a kind the preset doesn't name"
        )
    points = dumped["surface"].pop("points")
    values = {f"{name}.{key}": value for name in SECTIONS for key, value in dumped[name].items()}
    title, description, authors = (dumped[key] for key in ("title", "description", "authors"))
    try:
        return Preset(
            name, title, description, values, kinds, Tags(**dumped["tags"]), authors, points
        )
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _place(layers: list[Layer], path: Path) -> str:
    layer = layer_of(layers, path)
    line = line_of(layer.text, path)
    return f"{layer.source}:{line}" if line else layer.source
