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

In version 2 a tap took `unfold_s / catch_up`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal

import pydantic

from overview_dsp.design.presets.expressions import FaultyValueError, work_out
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
    MAX_ALSO,
    MAX_POINTS,
    MODE_PARAMETERS,
    PARAMETERS,
)
from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.toml import line_of
from overview_dsp.kernels.layout import MAX_KINDS, MAX_MODES

SCHEMA = 3


def _one_to_two(data: dict[str, Any]) -> dict[str, Any]:
    # nothing was renamed: what is new has defaults
    return {**data, "schema": 2}


def _two_to_three(data: dict[str, Any]) -> dict[str, Any]:
    disk = data.get("disk")
    if not isinstance(disk, dict):
        return {**data, "schema": 3}
    values = migrated_values({f"disk.{key}": value for key, value in disk.items()})
    found = {**data, "schema": 3, "disk": {}}
    for id, value in values.items():
        section, _, key = id.partition(".")
        found[section] = {**found.get(section, {}), key: value}
    return found


def migrated_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values by parameter id, with the ids and meanings of the present schema."""
    found = dict(values)
    ratio = found.pop("disk.catch_up", None)
    tap_s = found.pop("disk.unfold_s", None)
    if ratio is not None:
        found["clutch.max_speed_ratio"] = ratio
    if tap_s is not None:
        known = all(isinstance(value, int | float) for value in (ratio, tap_s))
        found["clutch.tap_duration_s"] = min(tap_s / ratio, 10.0) if known and ratio else tap_s
    return found


_STEPS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {1: _one_to_two, 2: _two_to_three}


def migrated(data: dict[str, Any]) -> dict[str, Any]:
    """A file's data in the present schema; what has no known version is left for the check."""
    version = data.get("schema")
    while type(version) is int and version in _STEPS:
        data = _STEPS[version](data)
        version = data["schema"]
    return data


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
    try:
        data = tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None
    return Layer(source, text, migrated(data))


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


def layer_of(layers: list[Layer], path: tuple[str | int, ...]) -> Layer:
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


HEADER_KEYS = ("schema", "extends", "title", "description", "authors", "tags", "variables")
MAP_DOC = (
    "The intensity map: of even steps of the timeline's curve, the part of the ambience that is "
    "felt there, 0 to 1; none is a straight line."
)
_STRICT = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


def _field(known: Parameter) -> tuple[Any, Any]:
    if known.choices:
        kind: Any = bool if isinstance(known.choices[0], bool) else Literal[known.choices]
        return kind, pydantic.Field(known.default, description=known.doc)
    limits: Any = {
        "ge": known.low,
        "le": known.high,
        "description": known.doc,
        "json_schema_extra": {"unit": known.unit},
    }
    if known.id.startswith("width_"):
        return float | None, pydantic.Field(None, **limits)
    return float, pydantic.Field(... if known.default is None else known.default, **limits)


@cache
def preset_model() -> type[pydantic.BaseModel]:
    """The pydantic model of a preset file, made from the parameter table."""
    sections: dict[str, Any] = {}
    for id, known in PARAMETERS.items():
        section, key = id.split(".")
        sections.setdefault(section, {})[key] = _field(known)
    fields: dict[str, Any] = {
        # an alias: pydantic has a method of the file's name for it
        "schema_version": (int, pydantic.Field(..., alias="schema", ge=SCHEMA, le=SCHEMA)),
        "title": (str, pydantic.Field(..., description="What the preset is called.")),
        "description": (str, pydantic.Field(..., description="What it feels like, in a line.")),
        "authors": (list[str], pydantic.Field(default_factory=list)),
        "tags": (_tags_model(), pydantic.Field(default_factory=_tags_model())),
        "variables": (dict[str, float], pydantic.Field(default_factory=dict)),
    }
    drawn: Any = pydantic.Field(default_factory=list, max_length=MAX_POINTS, description=MAP_DOC)
    part = Annotated[float, pydantic.Field(ge=0.0, le=1.0)]
    sections["surface"]["points"] = (list[part], drawn)
    for section, members in sections.items():
        # any: the fields come from the table
        model: Any = pydantic.create_model(section.capitalize(), __config__=_STRICT, **members)
        fields[section] = (model, pydantic.Field(default_factory=model))
    mode_fields: dict[str, Any] = {key: _field(known) for key, known in MODE_PARAMETERS.items()}
    mode = pydantic.create_model("Mode", __config__=_STRICT, **mode_fields)
    kind_fields: dict[str, Any] = {key: _field(known) for key, known in KIND_PARAMETERS.items()}
    kind_fields["modes"] = (
        list[mode],  # type: ignore[valid-type]
        pydantic.Field(default_factory=list, max_length=MAX_MODES),
    )
    kind_fields["points"] = (
        list[float],
        pydantic.Field(
            default_factory=list,
            max_length=MAX_POINTS,
            description="The friction's course over two widths, 0 to 1, in place of the shape's.",
        ),
    )
    kind_fields["also"] = (
        list[str],
        pydantic.Field(
            default_factory=list,
            max_length=MAX_ALSO,
            description="Other kinds of event that feel like this one, unless they are named.",
        ),
    )
    kind = pydantic.create_model("Kind", __config__=_STRICT, **kind_fields)
    fields["kinds"] = (
        dict[str, kind],  # type: ignore[valid-type]
        pydantic.Field(max_length=MAX_KINDS),
    )
    return pydantic.create_model("Preset", __config__=_STRICT, **fields)


@cache
def _tags_model() -> Any:
    scale: Any = (float | None, pydantic.Field(None, ge=1.0, le=5.0, description="1 low, 5 high"))
    fields: dict[str, Any] = dict.fromkeys(TAG_SCALES, scale)
    fields["usage"] = (list[str], pydantic.Field(default_factory=list))
    return pydantic.create_model("Tags", __config__=_STRICT, **fields)


def _known_keys(path: tuple[str | int, ...]) -> tuple[str, ...]:
    if not path:
        return (*HEADER_KEYS, *dict.fromkeys(id.split(".")[0] for id in PARAMETERS), "kinds")
    if path[0] == "tags":
        return (*TAG_SCALES, "usage")
    if path[0] == "kinds":
        keys = MODE_PARAMETERS if "modes" in path[1:] else KIND_PARAMETERS
        return (*keys, "also", "points", "modes") if "modes" not in path[1:] else tuple(keys)
    drawn = ("points",) if path[0] == "surface" else ()
    return (*(id.split(".")[1] for id in PARAMETERS if id.split(".")[0] == path[0]), *drawn)


def _parameter_at(path: tuple[str | int, ...]) -> Parameter | None:
    if len(path) == 2:
        found = PARAMETERS.get(f"{path[0]}.{path[1]}")
        if found:
            return found
    if path and path[0] == "kinds" and isinstance(path[-1], str):
        return (MODE_PARAMETERS if "modes" in path else KIND_PARAMETERS).get(path[-1])
    return None


def _explain(error: Mapping[str, Any]) -> str:
    path = tuple(part for part in error["loc"] if part != "function-plain")
    # a quoted key may hold anything
    name = ".".join(t if (t := str(part)).isprintable() else repr(t) for part in path)
    given = error.get("input")
    if error["type"] == "extra_forbidden":
        hint = did_you_mean(str(path[-1]), _known_keys(path[:-1]))
        return f"unknown key {name}{hint}"
    known = _parameter_at(path)
    if error["type"] == "missing":
        return f"{name} is missing" + (f"; it is {known.allowed}" if known else "")
    if known:
        if error["type"] in ("greater_than_equal", "less_than_equal", "finite_number"):
            return f"{name} = {shown(given)} is out of range; it is {known.allowed}"
        return f"{name} = {shown(given)} is not allowed; it is {known.allowed}"
    if error["type"] == "too_long":
        return f"{name}: {error['msg']}"
    if name == "schema":
        return f"schema = {shown(given)} is not known; this version reads schema = 1 to {SCHEMA}"
    return f"{name}: {error['msg']}"


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
    try:
        checked = preset_model().model_validate(work_out(data, numbers))
    except FaultyValueError as error:
        name_of = ".".join(str(part) for part in error.path)
        raise InputError(f"{_place(layers, error.path)}: {name_of}: {error}") from None
    except pydantic.ValidationError as error:
        faults = error.errors(include_url=False, include_context=False)
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        place = _place(layers, faults[0]["loc"])
        raise InputError(f"{place}: {_explain(faults[0])}{more}") from None
    dumped = checked.model_dump()
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
    values = {id: dumped[id.split(".")[0]][id.split(".")[1]] for id in PARAMETERS}
    tags = Tags(**dumped["tags"])
    authors = tuple(dumped["authors"])
    try:
        return Preset(
            *(name, dumped["title"], dumped["description"], values, kinds, tags, authors),
            points=tuple(dumped["surface"]["points"]),
        )
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _place(layers: list[Layer], path: tuple[str | int, ...]) -> str:
    layer = layer_of(layers, tuple(part for part in path if part != "function-plain"))
    line = line_of(layer.text, path)
    return f"{layer.source}:{line}" if line else layer.source
