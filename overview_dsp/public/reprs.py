"""What an object looks like in a console, a debugger or a failed test: a line."""

from __future__ import annotations

import reprlib
from dataclasses import MISSING, fields
from typing import Any

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxtuple = 3


def short(value: object) -> str:
    """Write a value's repr with at most some 60 characters."""
    return _SHORT.repr(value)


def counted(count: int, what: str) -> str:
    """Write how many there are: `1 event`, `2 events`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def changed_fields(instance: Any, **shown: str) -> str:
    """Write a dataclass as it is made, without the fields that have their default.

    Parameters
    ----------
    instance : dataclass
        What is written.
    **shown : str
        What is written for a field in place of its value.
    """
    given = []
    for field in fields(instance):
        value = getattr(instance, field.name)
        if field.default is MISSING or value != field.default:
            given.append(f"{field.name}={shown.get(field.name) or short(value)}")
    return f"{type(instance).__name__}({', '.join(given)})"
