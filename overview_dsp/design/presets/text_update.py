"""Update of values in a preset file's text, which keeps `extends`, variables and comments."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from overview_dsp.design.presets.expressions import is_expression
from overview_dsp.design.presets.library import load_preset, parse_user_preset, preset_path
from overview_dsp.design.presets.model import ClickMode, Preset
from overview_dsp.design.presets.validation import SCHEMA, migrate
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import write_file
from overview_dsp.files.toml import SUFFIX, read_text

DIGITS = 4  # significant digits of a tuned value; a hundredth of a JND

Changes = Mapping[str, Mapping[str, Any]]
"""New values by kind and key: numbers, texts, `aliases`, `points` and `modes`."""


def changes_between(before: Preset, after: Preset) -> Changes:
    """Return the changed values of the kinds; a kind that is new has all its values."""
    found: dict[str, dict[str, Any]] = {}
    for name, kind in after.kinds.items():
        old = vars(before.kinds[name]) if name in before.kinds else {}
        new = {key: value for key, value in vars(kind).items() if value is not None}
        found[name] = {key: new[key] for key in new if key not in old or old[key] != new[key]}
    return {name: values for name, values in found.items() if values}


def updated_text(source: Path, changes: Changes, before: Preset) -> str:
    """Return the text of a preset file (of the preset `before`) with changed values of some kinds.

    An expression is multiplied, so that it still follows its variables. A value of an extended
    preset is written into the file. A file of an older schema gets the present schema number.
    InputError for a file whose keys have other names in the present schema.
    """
    import tomlkit
    from tomlkit.items import Table

    document = tomlkit.parse(read_text(source))
    written_in = document.unwrap()
    if migrate(written_in) != {**written_in, "schema": SCHEMA}:
        raise InputError(
            f"{source}: has keys of an older schema; save it again first: "
            f"overview presets new NAME --base {source}"
        )
    document["schema"] = SCHEMA
    base = document.get("extends")
    if isinstance(base, str) and base.endswith(SUFFIX):
        # the path also holds in another folder
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
            if isinstance(value, tuple):
                kind[key] = tomlkit.array()
                kind[key].extend(vars(one) if isinstance(one, ClickMode) else one for one in value)
            elif isinstance(value, str):
                kind[key] = value
            elif is_expression(written):
                ratio = value / getattr(before.kinds[name], key)
                kind[key] = f"({written}) * {_rounded(ratio):g}"
            else:
                kind[key] = _rounded(value)
    return tomlkit.dumps(document)


def save_updated(
    name: str | Path, changes: Changes, path: str | os.PathLike[str]
) -> tuple[Path, Preset]:
    """Write a preset's text with changed values of some kinds, after a check.

    Returns the file and its preset. InputError if it cannot be written, or would not be valid.
    """
    before, target = load_preset(name), Path(path)
    text = updated_text(preset_path(name), changes, before)
    made = parse_user_preset(text, target)
    write_file(target, text)
    return target, made


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
