"""JSON documents of clips: types of values, and validation with one line per fault.

Each format is a pydantic model for writing and validating files. A reader
uses the same model but is more lenient (`READING`): it drops unknown keys and uses defaults for
keys that players do not need.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Any, ClassVar, TypeVar

import pydantic
from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from overview_dsp.errors import InputError
from overview_dsp.files.schema import Allowed, Path, Strict, checked, named
from overview_dsp.offline.export.clip import MAX_CLIP_S

CHECKING, READING = "checking", "reading"  # contexts of a validation; writing a document has none
MAX_ENTRIES = 100_000


class Part(Strict):
    """Object of a document, with exactly the keys of its format."""

    defaults: ClassVar[Mapping[str, Any]] = {}
    """Defaults of a reader for missing keys."""

    ignored: ClassVar[Collection[str]] = ()
    """Keys whose values a reader ignores."""

    @pydantic.model_validator(mode="before")
    @classmethod
    def _lenient(cls, data: Any, info: pydantic.ValidationInfo) -> Any:
        if info.context is None or not isinstance(data, dict):
            return data
        if info.context == READING:
            read = [key for key in data if key in cls.model_fields and key not in cls.ignored]
            data = {**cls.defaults, **{key: data[key] for key in read}}
        for key, value in data.items():
            if value is None:
                raise ValueError(f"{named((key,))} is null; give a value or leave the key out")
        return data

    def faults(self) -> Iterator[str]:
        """Yield contradictions between values that are valid individually, one line each."""
        yield from ()


Document = TypeVar("Document", bound=Part)


def _readable(seconds: float, info: pydantic.ValidationInfo) -> float:
    if info.context == READING and seconds > MAX_CLIP_S:
        raise PydanticCustomError("less_than_equal", f"0 to {MAX_CLIP_S:g} s")
    return seconds


Unit = Annotated[float, Field(ge=0.0, le=1.0), Allowed("0 to 1")]
Signed = Annotated[float, Field(ge=-1.0, le=1.0), Allowed("-1 to 1")]
Seconds = Annotated[
    float, Field(ge=0.0), Allowed("a number of seconds, 0 or more"), AfterValidator(_readable)
]
Positive = Annotated[float, Field(gt=0.0), Allowed("a number above 0")]
Count = Annotated[int, Field(ge=0), Allowed("a whole number, 0 or more")]


def located(path: Path) -> str:
    """Return the location of a value as text: `Pattern[0].Event.Time`."""
    parts = (f"[{one}]" if isinstance(one, int) else f".{named((one,))}" for one in path)
    return "".join(parts).removeprefix(".") or "the document"


def _validated(model: type[Document], data: Any, context: str) -> Document | list[str]:
    found = checked(model, data, located, context)
    if not isinstance(found, list):
        return found
    # tables of TOML are objects in JSON
    return [re.sub("a table$", "an object", fault.message) for fault in found]


def validate(model: type[Part], data: Any) -> list[str]:
    """Return all faults of a document, one line each."""
    found = _validated(model, data, CHECKING)
    return found if isinstance(found, list) else list(found.faults())


def read(model: type[Document], data: Any) -> Document:
    """Return a leniently validated document; raise InputError with its first fault."""
    found = _validated(model, data, READING)
    if isinstance(found, list):
        raise InputError(found[0])
    return found


def descending(values: Collection[float], name: str) -> Iterator[str]:
    """Yield a fault for each number below the previous one."""
    before = -math.inf
    for k, value in enumerate(values):
        if value < before:
            yield f"{name}[{k}] = {value:g} comes after {before:g}; times must ascend"
        before = value


def encoded(document: Part) -> bytes:
    """Return the document as UTF-8 JSON."""
    data = document.model_dump(exclude_none=True)
    return (json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()
