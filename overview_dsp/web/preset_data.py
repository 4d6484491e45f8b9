"""Presets for a page: read by name, checked, kept in the person's own folder.

A preset travels as a JSON object, the one of `saved_state.preset_to_dict`. Only names are taken,
never paths, and what a file extends is a name as well: nothing else of the disk can be reached.

A pulse code for each kind of event: on and off times (ms) for a motor that knows no strength.

The first pulse says how much an event weighs (80 ms: a goal; 35 ms: a card; 14 ms: a foul), those
after it tell kinds of one weight apart. 14 ms is the least that starts a phone's eccentric motor,
40 ms of rest the least that is felt between two pulses.

`GET /preset/changes`: the served preset's file, saved on the desk, is felt on every page.

Server-sent events: first the preset as it is, then each time its file has changed and is whole, as
`/data/preset` has it. A file that isn't valid is told as ``event: refused`` with the line that says
why; the last good one goes on.

Thread: the server's; files are read in a worker.
"""

from __future__ import annotations

import asyncio
import json
import re
import tomllib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

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
from overview_dsp.files.atomic import make_folder, whole_file
from overview_dsp.files.toml import SUFFIX
from overview_dsp.live.session.presets import PresetWatch

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
    path = LIBRARY.own_folder / (name + SUFFIX)
    if path.exists() and not replace:
        raise InputError(f"a preset {name!r} is there already; replace=1 replaces it")
    _require_named_base(text, name)
    parse_own(text, path)
    make_folder(path.parent)
    with whole_file(path) as temporary:
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


LOOK_EVERY_S = 0.1
ALIVE_EVERY = 50
"""Looks after which a line is sent in any case: a dead connection is noticed."""


def preset_link(name: str, linear: bool) -> Route:
    """The route for a preset, by name or path; `linear`: without its angle map."""

    async def changes(request: Request) -> Response:
        return StreamingResponse(
            _told(name, linear),
            headers={"cache-control": "no-store"},
            media_type="text/event-stream",
        )

    return Route("/preset/changes", changes)


async def _told(name: str, linear: bool) -> AsyncIterator[str]:
    watch = PresetWatch(name, linear)
    yield "retry: 1000\n\n" + _message(watch.preset)
    looks = 0
    while True:
        await asyncio.sleep(LOOK_EVERY_S)
        looks += 1
        try:
            changed = await asyncio.to_thread(watch.changed)
        except InputError as error:
            yield f"event: refused\ndata: {json.dumps(str(error))}\n\n"
            continue
        if changed is not None:
            yield _message(changed)
        elif looks % ALIVE_EVERY == 0:
            yield ": alive\n\n"


def _message(preset: Preset) -> str:
    return f"data: {json.dumps(preset_to_dict(preset))}\n\n"
