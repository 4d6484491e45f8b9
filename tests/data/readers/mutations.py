"""Changes of parsed documents, for tests of what readers do with broken files."""

from __future__ import annotations

import copy
from typing import Any

from hypothesis import strategies as st

VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 150),
    st.floats(),
    st.just(10**400),
    st.text(st.characters(), max_size=6),
    st.sampled_from(["1H", "P", "45+2", "90+99", "France", "2020-01-01", "own goal"]),
    st.just([]),
    st.just({}),
    st.just([[1, 2], None, "x"]),
    st.just({"name": "A", "minute": 3}),
)


def mutated(data: st.DataObject, document: Any) -> Any:
    """The document with one to four values, anywhere in it, removed or replaced."""
    for _ in range(data.draw(st.integers(1, 4))):
        inside: Any = document
        while True:
            keys = list(inside) if isinstance(inside, dict) else list(range(len(inside)))
            if not keys:
                break
            key = data.draw(st.sampled_from(keys))
            deeper = isinstance(inside[key], dict | list) and inside[key]
            if deeper and data.draw(st.integers(0, 9)):
                inside = inside[key]
                continue
            if data.draw(st.booleans()):
                inside[key] = copy.deepcopy(data.draw(VALUES))
            else:
                del inside[key]
            break
    return document
