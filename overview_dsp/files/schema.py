"""What the data of a file may be, as pydantic models; what is wrong with it, a sentence a fault."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import NoneType
from typing import Any, NamedTuple, TypeVar, get_args

import pydantic
from pydantic_core import PydanticCustomError, core_schema

from overview_dsp.errors import did_you_mean, shown

Path = tuple[str | int, ...]
"""The keys that lead to a value."""

_HOW = {
    **dict.fromkeys(("float_type", "int_type"), "is no number"),
    **dict.fromkeys(("model_type", "dict_type"), "is no table"),
    **{"string_type": "is no text", "list_type": "is no list", "literal_error": "is not allowed"},
    **dict.fromkeys(
        ("greater_than", "greater_than_equal", "less_than_equal", "finite_number"),
        "is out of range",
    ),
}
"""By pydantic's type of an error."""


class Strict(pydantic.BaseModel):
    """A table with these keys and no others, each value of its own type."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Allowed:
    """What a value may be, in the words of an error; stands behind a type in `Annotated`."""

    words: str

    def __get_pydantic_core_schema__(self, kind: Any, handler: Any) -> Any:
        return core_schema.no_info_wrap_validator_function(self._checked, handler(kind))

    def _checked(self, value: Any, inner: Any) -> Any:
        try:
            return inner(value)
        except pydantic.ValidationError as error:
            kind: Any = error.errors()[0]["type"]
            kind = kind if kind in _HOW else "literal_error"
            raise PydanticCustomError(kind, self.words) from None


class Fault(NamedTuple):
    """What is wrong with a value, and where it is."""

    path: Path
    words: str


def named(path: Path) -> str:
    """A key as an error names it, with the tables it is in; quoted where it may hold anything."""
    return ".".join(text if (text := str(part)).isprintable() else repr(text) for part in path)


Model = TypeVar("Model", bound=pydantic.BaseModel)


def checked(
    model: type[Model], data: Any, name: Callable[[Path], str] = named, context: Any = None
) -> Model | list[Fault]:
    """The data as a model, or all that is wrong with it; validators may ask for the context."""
    try:
        return model.model_validate(data, context=context)
    except pydantic.ValidationError as error:
        found = error.errors(include_url=False, include_context=False)
    faults = []
    # what is unknown first: it is what is missing, misspelt
    for one in sorted(found, key=lambda one: one["type"] != "extra_forbidden"):
        path = _path(data, one["loc"])
        faults.append(Fault(path, _words(model, path, one, name(path))))
    return faults


def _words(model: Any, path: Path, error: Mapping[str, Any], name: str) -> str:
    how = _HOW.get(error["type"])
    if how is not None:
        said = f"{name} = {shown(error['input'])} {how}"
        allowed = error["msg"].removeprefix("Input should be ")
        # pydantic's own words for a type name its classes
        return said if allowed.startswith("a valid ") else f"{said}; it is {allowed}"
    known = _fields(model, path[:-1])
    if error["type"] == "extra_forbidden":
        return f"unknown key {name}{did_you_mean(str(path[-1]), map(str, known))}"
    if error["type"] == "missing":
        words = [one.words for one in known[path[-1]].metadata if isinstance(one, Allowed)]
        return f"{name} is missing" + "".join(f"; it is {one}" for one in words)
    return f"{name}: {error['msg'].removeprefix('Value error, ')}"


def _path(data: Any, place: Path) -> Path:
    """A place without the branches that pydantic names beside the keys of the data."""
    path: Path = ()
    for part in place:
        is_list = isinstance(data, list) and isinstance(part, int)
        inside = is_list or (isinstance(data, dict) and part in data)
        if inside:
            data = data[part]
        if inside or part == place[-1]:
            path = (*path, part)
    return path


def _fields(kind: Any, path: Path) -> dict[str | int, Any]:
    """The fields of the model that a path leads to within a model, by their keys in the data."""
    if NoneType in (choices := get_args(kind)):
        (kind,) = set(choices) - {NoneType}
    fields = {one.alias or key: one for key, one in getattr(kind, "model_fields", {}).items()}
    if not path:
        return fields
    inner = [fields[path[0]].annotation] if fields else get_args(kind)[-1:]
    return _fields(inner[0], path[1:])
