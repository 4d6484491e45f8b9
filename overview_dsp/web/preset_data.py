"""Presets and vibration patterns of the page.

A preset is sent as the JSON object of `preset_to_dict`. Requests name presets and never paths, so
they can't reach other files of the machine.

Each event kind has a vibration pattern: on and off times (ms) for a motor without strength control.
The first pulse represents the weight of the kind (80 ms: a goal; 35 ms: a card; 14 ms: a foul).
Further pulses distinguish kinds of equal weight. 14 ms is the shortest pulse that starts a phone's
motor; two pulses need a pause of at least 40 ms.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from overview_dsp.design.presets import library
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.reference import reference_json
from overview_dsp.design.presets.serialization import preset_from_dict, preset_to_dict
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import make_folder, write_file
from overview_dsp.files.toml import SUFFIX, load_toml

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", re.ASCII)
WINDOWS_DEVICES = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")


def preset_data(preset: Preset) -> dict[str, Any]:
    """Return a preset with the table of all parameters."""
    return {"preset": preset_to_dict(preset), "parameters": reference_json()}


def preset_names() -> dict[str, list[str]]:
    """Return the names that `named_preset` accepts."""
    return {"bundled": list(library.bundled_presets()), "own": list(library.user_presets())}


def named_preset(name: str) -> Preset:
    """Load a bundled preset or one of the user's; raise InputError for other names."""
    if name not in (*library.bundled_presets(), *library.user_presets()):
        raise InputError(f"unknown preset {name[:70]!r}; /data/presets lists the names")
    return library.load_preset(name)


def parse_preset(value: Any) -> Preset:
    """Return a preset from its name or JSON object; raise InputError for other values."""
    return named_preset(value) if isinstance(value, str) else preset_from_dict(value)


def save_preset(name: str, text: str, replace: bool) -> Path:
    """Save a preset file in the user's folder if it is valid.

    InputError for an invalid name or text, and for an existing preset unless `replace` is true;
    OutputError if the disk is full.
    """
    if not NAME.fullmatch(name) or WINDOWS_DEVICES.fullmatch(name):
        raise InputError(f"preset name is {name[:70]!r}; must be letters, digits, - and _")
    if name in library.bundled_presets():
        raise InputError(f"{name!r} is the name of a bundled preset; choose another one")
    path = library.LIBRARY.user_folder / (name + SUFFIX)
    if path.exists() and not replace:
        raise InputError(f"preset {name!r} already exists; replace=1 replaces it")
    _check_parent(text, name)
    library.parse_user_preset(text, path)
    make_folder(path.parent)
    write_file(path, text)
    return path


def _check_parent(text: str, name: str) -> None:
    try:
        parent = tomllib.loads(text).get("extends")
    except tomllib.TOMLDecodeError:
        return  # the parser reports the error in detail
    others = {*library.bundled_presets(), *library.user_presets()} - {name}
    if isinstance(parent, str) and parent not in others:
        raise InputError(
            f"extends is {parent[:70]!r}; must be another preset of yours or a bundled one"
        )


Pattern = tuple[int, ...]

KINDS = load_toml(__file__, "kinds.toml")
LONG, SHORT, TICK = 80, 35, 14

# heights of an event profile from which a pulse is long or short
_HEAVY, _MIDDLE = 100.0, 25.0


def vibration_pattern(kind: str, preset: Preset) -> Pattern:
    """Return the pattern of a kind; unknown kinds depend on the height of their friction."""
    pattern = KINDS["known"].get(kind, {}).get("pattern")
    if pattern is not None:
        return tuple(pattern)
    profile = preset.kinds.get(kind, preset.kinds["default"])
    if profile.height >= _HEAVY:
        return (LONG,)
    return (SHORT,) if profile.height >= _MIDDLE else (TICK,)
