"""Pydantic models of file formats, and their errors as sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import NoneType
from typing import Any, NamedTuple, TypeVar, get_args

import pydantic
from pydantic_core import PydanticCustomError, core_schema

from overview_dsp.errors import did_you_mean, quoted

Path = tuple[str | int, ...]  # keys and list indices that lead to a value

_HOW = {
    **dict.fromkeys(("float_type", "int_type"), "is not a number"),
    **dict.fromkeys(("model_type", "dict_type"), "is not a table"),
    **{"string_type": "is not text", "list_type": "is not a list"},
    "literal_error": "is not allowed",
    **dict.fromkeys(
        ("greater_than", "greater_than_equal", "less_than_equal", "finite_number"),
        "is out of range",
    ),
}
"""Predicate of the sentence, by the error type of pydantic."""


class Strict(pydantic.BaseModel):
    """Table without unknown keys, whose values must have the exact type."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Allowed:
    """Description of the allowed values for error messages, after a type in `Annotated`."""

    text: str

    def __get_pydantic_core_schema__(self, kind: Any, handler: Any) -> Any:
        return core_schema.no_info_wrap_validator_function(self._checked, handler(kind))

    def _checked(self, value: Any, inner: Any) -> Any:
        try:
            return inner(value)
        except pydantic.ValidationError as error:
            kind: Any = error.errors()[0]["type"]
            kind = kind if kind in _HOW else "literal_error"
            raise PydanticCustomError(kind, self.text) from None


class Fault(NamedTuple):
    """Error in a value, with the path to it."""

    path: Path
    message: str


def named(path: Path) -> str:
    """Return a dotted key with its tables for a message; unprintable parts are quoted."""
    return ".".join(text if (text := str(part)).isprintable() else repr(text) for part in path)


Model = TypeVar("Model", bound=pydantic.BaseModel)


def checked(
    model: type[Model], data: Any, name: Callable[[Path], str] = named, context: Any = None
) -> Model | list[Fault]:
    """Return the data as a model, or all of its faults; validators can read the context."""
    try:
        return model.model_validate(data, context=context)
    except pydantic.ValidationError as error:
        found = error.errors(include_url=False, include_context=False)
    faults = []
    # unknown keys first: often a missing key is misspelt
    for one in sorted(found, key=lambda one: one["type"] != "extra_forbidden"):
        path = _path(data, one["loc"])
        faults.append(Fault(path, _message(model, path, one, name(path))))
    return faults


def _message(model: Any, path: Path, error: Mapping[str, Any], name: str) -> str:
    how = _HOW.get(error["type"])
    if how is not None:
        message = f"{name} = {quoted(error['input'])} {how}"
        allowed = error["msg"].removeprefix("Input should be ")
        # pydantic's own text for a type names Python classes
        return message if allowed.startswith("a valid ") else f"{message}; must be {allowed}"
    known = _fields(model, path[:-1])
    if error["type"] == "extra_forbidden":
        return f"unknown key {name}{did_you_mean(str(path[-1]), map(str, known))}"
    if error["type"] == "missing":
        allowed = "".join(
            f"; must be {one.text}" for one in known[path[-1]].metadata if isinstance(one, Allowed)
        )
        return f"{name} is missing{allowed}"
    return f"{name}: {error['msg'].removeprefix('Value error, ')}"


def _path(data: Any, location: Path) -> Path:
    """Return the path of a pydantic location, without the names of union branches."""
    path: Path = ()
    for part in location:
        is_list = isinstance(data, list) and isinstance(part, int)
        inside = is_list or (isinstance(data, dict) and part in data)
        if inside:
            data = data[part]
        if inside or part == location[-1]:
            path = (*path, part)
    return path


def _fields(kind: Any, path: Path) -> dict[str | int, Any]:
    """Return the fields of the model at a path within a model, by their keys in the data."""
    if NoneType in (choices := get_args(kind)):
        (kind,) = set(choices) - {NoneType}
    fields = {one.alias or key: one for key, one in getattr(kind, "model_fields", {}).items()}
    if not path:
        return fields
    inner = [fields[path[0]].annotation] if fields else get_args(kind)[-1:]
    return _fields(inner[0], path[1:])
