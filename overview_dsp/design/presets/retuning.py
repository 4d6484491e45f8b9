"""A preset's own text with other numbers: what it extends, its variables and comments stay."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from overview_dsp.design.presets.expressions import is_expression
from overview_dsp.design.presets.library import load_preset, parse_own, preset_path
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.validation import SCHEMA, migrated
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file
from overview_dsp.files.toml import SUFFIX, read_text

DIGITS = 4
"""Significant digits of a tuned value: a hundredth of what is felt."""

Changes = Mapping[str, Mapping[str, float]]
"""Of each kind, its keys (`height`, `width_percent`, `width_ms`) and their values."""


def retuned_text(source: Path, changes: Changes, before: Preset) -> str:
    """The text of a preset's file with some kinds' values changed.

    A value that is worked out from variables is multiplied, so that it still follows them; one that
    comes from what the file extends is written into it. A file of an older schema gets the present
    one's number.

    Parameters
    ----------
    source
        The file.
    changes
        What is to be.
    before
        The preset as loaded from it.

    Raises
    ------
    InputError
        It has keys that are called otherwise in the present schema.
    """
    import tomlkit
    from tomlkit.items import Table

    document = tomlkit.parse(read_text(source))
    written_in = document.unwrap()
    if migrated(written_in) != {**written_in, "schema": SCHEMA}:
        raise InputError(
            f"{source}: has keys of an older schema; save it anew first: overview presets new NAME "
            f"--from {source}"
        )
    document["schema"] = SCHEMA
    base = document.get("extends")
    if isinstance(base, str) and base.endswith(SUFFIX):
        # another folder's file still extends the same one
        document["extends"] = str((source.parent / base).resolve())
    if "kinds" not in document:
        document["kinds"] = tomlkit.table(is_super_table=True)
    kinds = document["kinds"]
    assert isinstance(kinds, Table)
    for name, values in changes.items():
        if name not in kinds:
            kinds[name] = tomlkit.table()
        kind: Any = kinds[name]
        for key, value in values.items():
            written = kind.get(key)
            if is_expression(written):
                ratio = value / getattr(before.kinds[name], key)
                kind[key] = f"({written}) * {_rounded(ratio):g}"
            else:
                kind[key] = _rounded(value)
    return tomlkit.dumps(document)


def save_retuned(
    name: str | Path, changes: Changes, path: str | os.PathLike[str]
) -> tuple[Path, Preset]:
    """Write a preset's own text with some kinds' values changed, checked before.

    Returns
    -------
    path, preset
        The file, and what it holds.

    Raises
    ------
    InputError
        A place that can't be written, or a text that would not be valid.
    """
    before, place = load_preset(name), Path(path)
    text = retuned_text(preset_path(name), changes, before)
    made = parse_own(text, place)
    with atomic_file(place) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return place, made


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
