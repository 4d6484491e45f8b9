"""TOML text to Preset: pydantic models made from the parameter table, errors that name the line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, Literal

import pydantic

from overview_dsp.errors import InputError
from overview_dsp.presets.model import DEFAULT_KIND, Kind, Mode, Preset
from overview_dsp.presets.parameters import (
    KIND_PARAMETERS,
    MAX_KINDS,
    MAX_MODES,
    MODE_PARAMETERS,
    PARAMETERS,
    Parameter,
    did_you_mean,
    shown,
)

SCHEMA = 1
HEADER_KEYS = ("schema", "title", "description")
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
        "title": (str, ...),
        "description": (str, ...),
    }
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
    kind = pydantic.create_model("Kind", __config__=_STRICT, **kind_fields)
    fields["kinds"] = (
        dict[str, kind],  # type: ignore[valid-type]
        pydantic.Field(max_length=MAX_KINDS),
    )
    return pydantic.create_model("Preset", __config__=_STRICT, **fields)


def line_of(text: str, path: Iterable[str | int]) -> int | None:
    """The line (from 1) that sets a key of a TOML text, or its nearest enclosing table."""
    parts = list(path)
    best: tuple[int, int] | None = None
    table: list[str | int] = []
    counts: dict[tuple[str | int, ...], int] = {}
    for number, line in enumerate(text.split("\n"), 1):
        bare = line.strip()
        header = re.match(r"(\[\[?)\s*([^\]]+?)\s*\]", bare)
        assigned = re.match(r"([A-Za-z0-9_\-.\"']+)\s*=", bare)
        if header:
            table = [part.strip().strip("\"'") for part in header[2].split(".")]
            if header[1] == "[[":
                index = counts.get(tuple(table), -1) + 1
                counts[tuple(table)] = index
                table = [*table, index]
            here = table
        elif assigned:
            here = [*table, *(part.strip("\"'") for part in assigned[1].split("."))]
        else:
            continue
        same = 0
        while same < min(len(here), len(parts)) and here[same] == parts[same]:
            same += 1
        if same == len(here) and same and (best is None or same > best[0]):
            best = (same, number)
    return best[1] if best else None


def _known_keys(path: tuple[str | int, ...]) -> tuple[str, ...]:
    if not path:
        return (*HEADER_KEYS, *dict.fromkeys(id.split(".")[0] for id in PARAMETERS), "kinds")
    if path[0] == "kinds":
        keys = MODE_PARAMETERS if "modes" in path[1:] else KIND_PARAMETERS
        return (*keys, "modes") if "modes" not in path[1:] else tuple(keys)
    return tuple(id.split(".")[1] for id in PARAMETERS if id.split(".")[0] == path[0])


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
        return f"schema = {shown(given)} is not known; this version reads schema = {SCHEMA}"
    return f"{name}: {error['msg']}"


def parse_preset(text: str, name: str, source: str) -> Preset:
    """A preset from TOML text; `source` names the file in errors.

    Raises
    ------
    InputError
        Not TOML, an unknown key, a wrong type or a value out of range: names file, line, key and
        range, and how many further faults there are.
    """
    try:
        data = tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None
    try:
        checked = preset_model().model_validate(data)
    except pydantic.ValidationError as error:
        faults = error.errors(include_url=False, include_context=False)
        line = line_of(text, faults[0]["loc"])
        place = f"{source}:{line}" if line else source
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        raise InputError(f"{place}: {_explain(faults[0])}{more}") from None
    dumped = checked.model_dump()
    kinds: dict[str, Kind] = {}
    for kind_name, members in dumped["kinds"].items():
        modes = tuple(Mode(**mode) for mode in members.pop("modes"))
        try:
            kinds[kind_name] = Kind(modes=modes, **members)
        except InputError as error:
            line = line_of(text, ("kinds", kind_name))
            raise InputError(f"{source}:{line}: kinds.{kind_name}: {error}") from None
    if DEFAULT_KIND not in kinds:
        raise InputError(
            f"{source}: kinds.{DEFAULT_KIND} is missing; "
            "add it, for events of a kind the preset doesn't name"
        )
    values = {id: dumped[id.split(".")[0]][id.split(".")[1]] for id in PARAMETERS}
    return Preset(name, dumped["title"], dumped["description"], values, kinds)
