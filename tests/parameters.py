"""Parameters of tests: the first of them are in each run, the rest in the long runs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def first_in_gate(values: Iterable[Any], count: int = 1) -> list[Any]:
    """Return the values as parameters; those after the first `count` are of `.ci/soak`."""
    listed = list(values)
    return [*listed[:count], *(pytest.param(one, marks=pytest.mark.soak) for one in listed[count:])]
