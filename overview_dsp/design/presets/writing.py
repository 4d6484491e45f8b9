"""Writer of preset files; equal presets give equal bytes."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from overview_dsp import validation
from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS,
    MODE_PARAMETERS,
    PARAMETERS,
    SECTIONS,
)
from overview_dsp.design.presets.validation import LIST_DOCS, SCHEMA
from overview_dsp.files.atomic import write_file


def preset_toml(preset: Preset) -> str:
    """Return the text of a preset file with the values other than defaults."""
    import tomli_w

    data: dict[str, Any] = {
        "schema": SCHEMA,
        "title": preset.title,
        "description": preset.description,
    }
    if preset.authors:
        data["authors"] = list(preset.authors)
    tags = {name: tag for name, tag in vars(preset.tags).items() if tag not in (None, ())}
    if tags:
        data["tags"] = tags
    for id, known in PARAMETERS.items():
        section, key = id.split(".")
        if preset.values[id] != known.default:
            data.setdefault(section, {})[key] = preset.values[id]
    if preset.points:
        data.setdefault("surface", {})["points"] = list(preset.points)
    data["kinds"] = {name: _kind(kind) for name, kind in preset.kinds.items()}
    return tomli_w.dumps(data)


def _kind(kind: EventKind) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, known in KIND_PARAMETERS.items():
        value = getattr(kind, key)
        if value is not None and (key == "height" or value != known.default):
            found[key] = value
    if kind.aliases:
        found["aliases"] = list(kind.aliases)
    if kind.points:
        found["points"] = list(kind.points)
    found["modes"] = [{key: getattr(mode, key) for key in MODE_PARAMETERS} for mode in kind.modes]
    return found


def save_preset(preset: Preset, path: str | os.PathLike[str]) -> Path:
    """Write a preset file with the values other than defaults, completely or not at all.

    Parameters
    ----------
    preset : Preset
        Preset to write.
    path : str or path
        The TOML file.

    Returns
    -------
    path
        The file.

    Raises
    ------
    InputError
        The file cannot be written.
    OutputError
        The disk is full.

    Examples
    --------
    >>> loud = ov.load_preset("football").with_changes({"surface.friction": 6e-4})
    >>> path = ov.presets.save(loud, "loud.toml")
    >>> ov.presets.load(path).values == loud.values
    True
    """
    target = validation.path(path, "a preset's file")
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    write_file(target, preset_toml(preset))
    return target


def preset_template(extended: str, base: Preset, title: str) -> str:
    """Return the text of a new preset with all values of its base in comments."""
    lines = [
        f"# {title}",
        "#",
        "# Feels like:",
        "# Sounds like:",
        "# For:",
        f"schema = {SCHEMA}",
        f"extends = {_plain(extended)}",
        f"title = {_plain(title)}",
        f"description = {_plain(f'made from {base.name}')}",
        "# drop = []  # Kinds of the extended preset that are removed.",
        "",
        "# [tags]",
        f"# data = {_plain(base.tags.data)}  # {LIST_DOCS['data']}",
        "",
        f"# These are the values of {base.name}. To change one, remove the # before it and its",
        "# heading.",
    ]
    for section, members in SECTIONS.items():
        lines += ["", f"# [{section}]"]
        lines += [
            f"# {key} = {_plain(base.values[known.id])}  # {known.allowed}. {known.doc}"
            for key, known in members.items()
        ]
        if section == "surface":
            lines.append(f"# points = {_plain(base.points)}  # {LIST_DOCS['map']}")
    for name, kind in base.kinds.items():
        lines += ["", f"# [kinds.{_key(name)}]"]
        lines += [
            f"# {known.key} = {_plain(getattr(kind, key))}  # {known.allowed}. {known.doc}"
            for key, known in KIND_PARAMETERS.items()
            if getattr(kind, key) is not None
        ]
        modes = (
            ", ".join(f"{key} = {_plain(getattr(mode, key))}" for key in MODE_PARAMETERS)
            for mode in kind.modes
        )
        lines += [
            f"# aliases = {_plain(kind.aliases)}  # {LIST_DOCS['aliases']}",
            f"# points = {_plain(kind.points)}  # {LIST_DOCS['points']}",
            f"# modes = [{', '.join(f'{{ {mode} }}' for mode in modes)}]  # {LIST_DOCS['modes']}",
        ]
    return "\n".join([*lines, ""])


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _plain(name)


def _plain(value: object) -> str:
    import json

    short = f"{value:g}" if isinstance(value, float) else ""
    return short if short and float(short) == value else json.dumps(value, ensure_ascii=False)
