"""Presets for a page: read by name, checked, kept in the person's own folder.

A preset travels as a JSON object, the one of `saved_state.preset_to_dict`. Only names are taken,
never paths, and what a file extends is a name as well: nothing else of the disk can be reached.

A pulse code for each kind of event: on and off times (ms) for a motor that knows no strength.

The first pulse says how much an event weighs (80 ms: a goal; 35 ms: a card; 14 ms: a foul), those
after it tell kinds of one weight apart. 14 ms is the least that starts a phone's eccentric motor,
40 ms of rest the least that is felt between two pulses.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from overview_dsp.design.presets.dicts import preset_from_dict, preset_to_dict
from overview_dsp.design.presets.library import (
    LIBRARY,
    bundled_presets,
    load_preset,
    own_names,
    parse_own,
)
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.reference import reference_json
from overview_dsp.design.presets.writing import preset_toml
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, make_folder
from overview_dsp.files.toml import SUFFIX

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", re.ASCII)
WINDOWS_DEVICES = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")


def preset_data(preset: Preset) -> dict[str, Any]:
    """A preset with the table that says what each of its parameters may be."""
    return {"preset": preset_to_dict(preset), "parameters": reference_json()}


def preset_names() -> dict[str, list[str]]:
    """The names that `preset_named` takes."""
    return {"bundled": list(bundled_presets()), "own": list(own_names())}


def preset_named(name: str) -> Preset:
    """A bundled or own preset; InputError for anything that isn't such a name."""
    if name not in (*bundled_presets(), *own_names()):
        raise InputError(f"no preset is called {name[:70]!r}; /data/presets lists them")
    return load_preset(name)


def preset_given(given: Any) -> Preset:
    """A preset by its name or as the object of `preset_data`; InputError if it isn't one."""
    return preset_named(given) if isinstance(given, str) else preset_from_dict(given)


def save_own(name: str, text: str, replace: bool) -> Path:
    """Keep the text of a preset file in the person's folder, valid and whole or not at all.

    Raises
    ------
    InputError
        No such name can be, it is taken (and `replace` is false), or the text isn't valid.
    OutputError
        The disk is full.
    """
    if not NAME.fullmatch(name) or WINDOWS_DEVICES.fullmatch(name):
        raise InputError(f"{name[:70]!r} is no name for a preset: letters, digits, - and _")
    if name in bundled_presets():
        raise InputError(f"{name!r} is a bundled preset's name; choose another one")
    path = LIBRARY.user_folder / (name + SUFFIX)
    if path.exists() and not replace:
        raise InputError(f"a preset {name!r} is there already; replace=1 replaces it")
    _require_named_base(text, name)
    parse_own(text, path)
    make_folder(path.parent)
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return path


def as_toml(given: Any) -> str:
    """The preset file of a page's preset."""
    return preset_toml(preset_given(given))


def _require_named_base(text: str, name: str) -> None:
    try:
        base = tomllib.loads(text).get("extends")
    except tomllib.TOMLDecodeError:
        return  # its reader reports the error with more detail
    if isinstance(base, str) and (base == name or base not in (*bundled_presets(), *own_names())):
        raise InputError(f"extends = {base[:70]!r}: name one of your presets or of the bundled")


Pulse = tuple[int, ...]

LONG, SHORT, TICK, REST = 80, 35, 14, 40

_CODES: dict[str, Pulse] = {
    "goal": (LONG, REST, SHORT),
    "own_goal": (LONG, REST, SHORT, REST, SHORT),
    "red_card": (SHORT, REST, SHORT),
    "yellow_card": (SHORT,),
    "near_miss": (TICK, REST, TICK),
    "foul": (TICK,),
    "period": (SHORT, REST, TICK),
    "highest": (LONG, REST, SHORT),
    "lowest": (LONG, REST, TICK, REST, TICK),
    "largest_rise": (SHORT, REST, SHORT),
    "largest_fall": (SHORT, REST, TICK, REST, TICK),
    "record_high": (SHORT,),
    "record_low": (SHORT, REST, TICK),
}
# of a preset's heights: above the first it is a long pulse, above the second a short one
_HEAVY, _MIDDLE = 100.0, 25.0


def pulse_of(kind: str, preset: Preset) -> Pulse:
    """The code of a kind; one that isn't known has the pulse of its friction's height."""
    if kind in _CODES:
        return _CODES[kind]
    profile = preset.kinds.get(kind, preset.kinds["default"])
    if profile.height >= _HEAVY:
        return (LONG,)
    return (SHORT,) if profile.height >= _MIDDLE else (TICK,)
