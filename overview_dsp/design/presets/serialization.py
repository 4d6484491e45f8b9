"""Conversion of presets to and from plain data for JSON."""

from __future__ import annotations

from typing import Any

from overview_dsp.design.presets.model import ClickMode, EventKind, Preset, Tags
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS
from overview_dsp.design.presets.validation import migrate_kind, migrate_values
from overview_dsp.errors import InputError
from overview_dsp.validation import only_input_errors, prefix_errors


def preset_to_dict(preset: Preset) -> dict[str, Any]:
    """Return a preset as plain dicts, lists, texts and numbers."""
    return {
        "name": preset.name,
        "title": preset.title,
        "description": preset.description,
        "values": dict(preset.values),
        "kinds": {
            name: {**_lists(kind), "modes": [vars(mode) for mode in kind.modes]}
            for name, kind in preset.kinds.items()
        },
        "tags": _lists(preset.tags),
        "authors": list(preset.authors),
        "points": list(preset.points),
    }


def _lists(one: EventKind | Tags) -> dict[str, Any]:
    fields = vars(one).items()
    return {key: list(value) if isinstance(value, tuple) else value for key, value in fields}


def preset_from_dict(data: Any) -> Preset:
    """Return the preset of `preset_to_dict` data; InputError if they are not valid."""
    with only_input_errors("not a saved preset"):
        name, title, description = (data[key] for key in ("name", "title", "description"))
        if not all(isinstance(text, str) for text in (name, title, description)):
            raise InputError("not a saved state: name, title and description must be texts")
        return Preset(
            name,
            title,
            description,
            migrate_values(data["values"]),
            {name: _kind_of(name, kind) for name, kind in data["kinds"].items()},
            # earlier states have none of these
            Tags(**data.get("tags", {})),
            tuple(data.get("authors", ())),
            tuple(data.get("points", ())),
        )


def _kind_of(name: str, data: dict[str, Any]) -> EventKind:
    data = migrate_kind(data)
    # keys of other versions are ignored
    known = (*KIND_PARAMETERS, "points", "aliases")
    with prefix_errors(f"kinds.{name}: "):
        modes: Any = [
            {key: known.check(mode[key]) for key, known in MODE_PARAMETERS.items()}
            for mode in data["modes"]
        ]
        return EventKind(
            modes=tuple(ClickMode(**mode) for mode in modes),
            **{key: data[key] for key in known if key in data},
        )
