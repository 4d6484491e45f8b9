"""Hypothesis strategies for presets, drawn from the parameter tables' own ranges, and TOML out."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameter import Parameter
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MODE_PARAMETERS,
    PARAMETERS,
)
from overview_dsp.kernels.layout import MAX_KINDS, MAX_MODES

TEXT = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=20)
KIND_NAMES = st.from_regex(r"[a-z0-9_]{1,12}", fullmatch=True)


def values(known: Parameter) -> st.SearchStrategy[Any]:
    """Anything the parameter allows."""
    if known.choices:
        return st.sampled_from(known.choices)
    return st.floats(known.low, known.high)


MODES = st.builds(ov.ClickMode, **{key: values(known) for key, known in MODE_PARAMETERS.items()})


@st.composite
def kinds(draw: st.DrawFn) -> ov.EventKind:
    given = {key: draw(values(known)) for key, known in KIND_PARAMETERS.items()}
    del given[draw(st.sampled_from(["width_percent", "width_ms"]))]
    points = draw(st.just([]) | st.lists(st.floats(0.0, 1.0), min_size=2, max_size=9).filter(any))
    return ov.EventKind(
        modes=tuple(draw(st.lists(MODES, max_size=MAX_MODES))), points=tuple(points), **given
    )


@st.composite
def presets(draw: st.DrawFn, max_kinds: int = 5) -> ov.Preset:
    """Any valid preset."""
    named = draw(st.dictionaries(KIND_NAMES, kinds(), max_size=min(max_kinds, MAX_KINDS) - 1))
    named["default"] = draw(kinds())
    for other in draw(st.lists(KIND_NAMES, unique=True, max_size=4)):
        like = draw(st.sampled_from(sorted(named)))
        named[like] = replace(named[like], aliases=(*named[like].aliases, other))
    given = {id: draw(values(known)) for id, known in PARAMETERS.items()}
    points = draw(st.just([]) | st.lists(st.floats(0.0, 1.0), min_size=2, max_size=9))
    return ov.Preset("drawn", draw(TEXT), draw(TEXT), given, named, points=tuple(points))


def toml_value(value: float | bool | str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    # JSON's strings are TOML's too (but for DEL, which TOML wants escaped)
    return (
        json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        if isinstance(value, str)
        else repr(value)
    )


def toml_of(preset: ov.Preset) -> str:
    """A preset as a TOML file that names every parameter."""
    lines = [
        "schema = 1",
        f"title = {toml_value(preset.title)}",
        f"description = {toml_value(preset.description)}",
    ]
    for section in dict.fromkeys(id.split(".")[0] for id in PARAMETERS):
        lines.append(f"[{section}]")
        lines += [
            f"{known.key} = {toml_value(preset.values[id])}"
            for id, known in PARAMETERS.items()
            if id.split(".")[0] == section
        ]
        if section == "surface" and preset.points:
            lines.append(f"points = {list(preset.points)}")
    for name, kind in preset.kinds.items():
        lines.append(f"[kinds.{name}]")
        lines += [
            f"{key} = {toml_value(value)}"
            for key in KIND_PARAMETERS
            if (value := getattr(kind, key)) is not None
        ]
        if kind.aliases:
            lines.append(f"aliases = {json.dumps(kind.aliases)}")
        if kind.points:
            lines.append(f"points = {list(kind.points)}")
        for mode in kind.modes:
            lines.append(f"[[kinds.{name}.modes]]")
            lines += [f"{key} = {toml_value(getattr(mode, key))}" for key in MODE_PARAMETERS]
    return "\n".join(lines) + "\n"
