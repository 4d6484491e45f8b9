"""Reader of preset files: migration, extension, expressions and a check by a pydantic model.

The model is made from the parameter table. Errors name file and line, also in an extended file.

`extends = "football"` takes all values of that preset (a name, or a path from the file's folder).
The file changes single keys, kinds and variables. A list of modes is replaced as a whole.
Expressions of the base follow changed variables. `drop = ["goal"]` removes kinds of the base.
`tags.data` is not inherited, so that a variation is not chosen in place of its base.

| schema | change |
|---|---|
| 1 | first version |
| 2 | added `extends`, `authors`, `[tags]`, `[variables]`, `kinds.*.spacing_percent` |
| 3 | `[clutch]`: `max_speed_ratio` was `disk.catch_up`, `tap_duration_s` was `disk.unfold_s` |
| 4 | new names (`renamed.toml`), such as `intensity_gain` for `ambience` |

In schema 2 a tap took `unfold_s / catch_up`.
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
    DATA_TYPES,
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
from overview_dsp.errors import InputError, did_you_mean, quoted
from overview_dsp.files.schema import Allowed, Fault, Path, Strict, checked, named
from overview_dsp.files.toml import line_of, load_toml, parse_toml
from overview_dsp.kernels.layout import MAX_KINDS, MAX_MODES
from overview_dsp.validation import prefix_errors

SCHEMA = 4

_RENAMED: dict[str, dict[str, str]] = load_toml(__file__, "renamed.toml")
"""Parameter ids, and keys of event kinds, of schema 3 that have another name in schema 4."""


def migrate_values(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by parameter id, with the ids and meanings of the present schema."""
    found = {_RENAMED["ids"].get(id, id): value for id, value in values.items()}
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
    return {_RENAMED["kinds"].get(key, key): value for key, value in kind.items()}


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
"""Function from (value of `extends`, its file) to (file of the base, its text)."""


@dataclass(frozen=True)
class Layer:
    """One file: path, text, and data in the present schema."""

    source: str
    text: str
    data: dict[str, Any]


def read_layers(source: str, text: str, find: Find) -> list[Layer]:
    """Return the file and its bases, the file first.

    InputError for a file that is not TOML, or a base that is missing, not a name, or part of a
    circle.
    """
    layers = [_layer(source, text)]
    while (base := layers[-1].data.get("extends")) is not None:
        here = layers[-1]
        if not isinstance(base, str):
            raise InputError(f"{here.source}: extends = {quoted(base)}; must be a preset's name")
        if len(layers) == MAX_LAYERS:
            raise InputError(f"{source}: more than {MAX_LAYERS} presets extend each other")
        with prefix_errors(f"{here.source}: extends: "):
            found = find(base, here.source)
        if any(found[0] == layer.source for layer in layers):
            raise InputError(f"{here.source}: extends {base!r}, which extends it in turn")
        layers.append(_layer(*found))
    return layers


def _layer(source: str, text: str) -> Layer:
    return Layer(source, text, migrate(parse_toml(text, source)))


def merged(layers: list[Layer]) -> dict[str, Any]:
    """Return the merged data of all layers; the first layer has priority."""
    found: dict[str, Any] = {}
    for layer in reversed(layers):
        own = {key: value for key, value in layer.data.items() if key not in ("extends", "drop")}
        base = _without(found, layer)
        if isinstance(tags := base.get("tags"), dict):
            base = {**base, "tags": {key: tags[key] for key in tags if key != "data"}}
        found = _over(base, own)
    return found


def _without(base: dict[str, Any], layer: Layer) -> dict[str, Any]:
    """Return the data of a base without the kinds that a layer drops; InputError."""
    names, kinds = layer.data.get("drop", []), base.get("kinds", {})
    unknown = (
        [name for name in names if name not in [*kinds]] if isinstance(names, list) else [names]
    )
    if unknown:
        raise InputError(
            f"{_location([layer], ('drop',))}: drop has {quoted(unknown[0])}; must be a list "
            f"of kinds of the extended preset{did_you_mean(str(unknown[0]), [*kinds])}"
        )
    return (
        {**base, "kinds": {key: kinds[key] for key in kinds if key not in names}} if names else base
    )


def _over(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    found = dict(base)
    for key, value in own.items():
        below = found.get(key)
        if not (isinstance(below, dict) and isinstance(value, dict)):
            found[key] = value
            continue
        found[key] = _over(below, value)
        # an event has one of two widths; the one of the file has priority
        for width, other in (("width_percent", "width_ms"), ("width_ms", "width_percent")):
            if width in value and other not in value:
                found[key].pop(other, None)
    return found


def layer_of(layers: list[Layer], path: Path) -> Layer:
    """Return the first layer with a value, or else the file itself."""
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


LIST_DOCS: dict[str, str] = load_toml(__file__, "list_docs.toml")
"""Descriptions of the lists in a preset file, from `list_docs.toml`."""


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


def _model(name: str, parameters: Iterable[Parameter], **more: Any) -> type[Strict]:
    """Return the model of a table of parameters, and of `more`."""
    fields: dict[str, Any] = {known.key: _field(known) for known in parameters}
    return pydantic.create_model(name, __base__=Strict, **fields, **more)


def _many(kind: Any, most: int | None = None, doc: str | None = None) -> tuple[Any, Any]:
    return list[kind], Field(default_factory=list, max_length=most, description=doc)


@cache
def preset_model() -> type[pydantic.BaseModel]:
    """Return the pydantic model of a preset file, made from the parameter table."""
    part = Annotated[float, Field(ge=0.0, le=1.0)]
    more = {"surface": {"points": _many(part, MAX_POINTS, LIST_DOCS["map"])}}
    sections: dict[str, Any] = {
        section: _model(section.capitalize(), members.values(), **more.get(section, {}))
        for section, members in SECTIONS.items()
    }
    scale: Any = (Annotated[float, Field(ge=1.0, le=5.0), Allowed("1 to 5")] | None, None)
    sections["tags"] = _model(
        "Tags",
        (),
        **dict.fromkeys(TAG_SCALES, scale),
        usage=_many(str),
        data=_many(Literal[DATA_TYPES], doc=LIST_DOCS["data"]),
    )
    kind = _model(
        "Kind",
        KIND_PARAMETERS.values(),
        modes=_many(_model("Mode", MODE_PARAMETERS.values()), MAX_MODES, LIST_DOCS["modes"]),
        points=_many(float, MAX_POINTS, LIST_DOCS["points"]),
        aliases=_many(str, MAX_ALIASES, LIST_DOCS["aliases"]),
    )
    return _model(
        "Preset",
        (),
        # an alias: pydantic has a method of the file's name for it
        schema_version=(int, Field(..., alias="schema", ge=SCHEMA, le=SCHEMA)),
        title=(str, Field(..., description="Title of the preset.")),
        description=(str, Field(..., description="Feel of the preset, in one sentence.")),
        authors=_many(str),
        variables=(dict[str, float], Field(default_factory=dict)),
        kinds=(dict[str, kind], Field(max_length=MAX_KINDS)),  # type: ignore[valid-type]
        **{name: (model, Field(default_factory=model)) for name, model in sections.items()},
    )


def _is_number(value: object) -> bool:
    # a very large int is not a number here; the check reports it
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _no_base(base: str, source: str) -> tuple[str, str]:
    raise InputError(f"{base!r} cannot be looked up here")


def parse_preset(text: str, name: str, source: str, find: Find = _no_base) -> Preset:
    """Return the preset of a file's TOML text; `find` finds an extended preset.

    InputError names file, line, key and range of the first error, and the number of others.
    """
    layers = read_layers(source, text, find)
    data = merged(layers)
    variables = data.get("variables", {})
    if not isinstance(variables, dict):
        location = _location(layers, ("variables",))
        raise InputError(f"{location}: variables = {quoted(variables)}; must be a table of numbers")
    numbers = {key: float(number) for key, number in variables.items() if _is_number(number)}
    found: Any
    try:
        found = checked(preset_model(), evaluate_expressions(data, numbers))
    except ExpressionError as error:
        found = [Fault(error.path, f"{named(error.path)}: {error}")]
    if isinstance(found, list):
        path, words = found[0]
        if path == ("schema",) and "schema" in data:
            version = quoted(data["schema"])
            words = f"schema = {version} is not known; this version reads schema = 1 to {SCHEMA}"
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        raise InputError(f"{_location(layers, path)}: {words}{more}")
    dumped = found.model_dump()
    kinds: dict[str, EventKind] = {}
    for kind_name, members in dumped["kinds"].items():
        modes = tuple(ClickMode(**mode) for mode in members.pop("modes"))
        try:
            kinds[kind_name] = EventKind(modes=modes, **members)
        except InputError as error:
            location = _location(layers, ("kinds", kind_name))
            similar = did_you_mean(kind_name, [one for one in dumped["kinds"] if one != kind_name])
            raise InputError(f"{location}: kinds.{kind_name}: {error}{similar}") from None
    if DEFAULT_KIND not in kinds:
        raise InputError(
            f"{source}: kinds.{DEFAULT_KIND} is missing; add it for events of other kinds"
        )
    points = dumped["surface"].pop("points")
    values = {f"{name}.{key}": value for name in SECTIONS for key, value in dumped[name].items()}
    title, description, authors = (dumped[key] for key in ("title", "description", "authors"))
    with prefix_errors(f"{source}: "):
        return Preset(
            name, title, description, values, kinds, Tags(**dumped["tags"]), authors, points
        )


def _location(layers: list[Layer], path: Path) -> str:
    layer = layer_of(layers, path)
    line = line_of(layer.text, path)
    return f"{layer.source}:{line}" if line else layer.source
