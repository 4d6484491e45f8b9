"""A jobs file: TOML that names a study's timelines, presets, gestures, parameters and seeds.

::

    out = "study"                       a folder beside this file, or an address; required
    timelines = ["world-cup-final-2018", "data/*.json",
                 {file = "AAPL.csv", value = "Close", window = ["end-6w", "end"]}]    required
    presets = ["football", "mine.toml"] the one that fits the first timeline if left out
    gestures = ["sweep:0.5", "tap:0.8:0.5", "takes/one.csv"]      required
    seeds = 100                         0 to 99; or a list
    sample_rate = 48000
    tail = "none"                       rest, none, or seconds
    format = "wav"                      what a sound file's name ends with
    subtype = "PCM_16"                  as `overview render --subtype`

    [parameters]                        each combined with all others
    "tactor.gain_db" = [-12.0, -6.0, 0.0]
    "kinds.goal.height" = {from = 2.0, to = 32.0, steps = 5, scale = "log"}

A timeline's table takes `window` or `zoom_to`, and the options of `load_timeline`. Paths and
addresses are relative to the file.
"""

from __future__ import annotations

import glob
import math
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from typing import Any, TypeVar

from overview_dsp.batch.extra import library
from overview_dsp.batch.grid import Settings, Study
from overview_dsp.batch.storage import is_address, local_copy, read_text
from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.registry import BUNDLED
from overview_dsp.data.readers.source import LoadOptions
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.moments import window_of, zoom_window
from overview_dsp.design.gestures import Gesture, load_gesture, parse_gesture
from overview_dsp.design.presets.library import best_preset_for, load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.sound import check_sound
from overview_dsp.files.toml import SUFFIX, line_of, parse_toml
from overview_dsp.offline.rendering.schedule import Tail, checked_tail, tail_of

KEYS = (
    "out", "timelines", "presets", "gestures", "seeds",
    "sample_rate", "tail", "format", "subtype", "parameters",
)  # fmt: skip
MOST_CASES = 100_000_000
MOST_STEPS = 100_000
_LOAD_KEYS = tuple(part.name for part in fields(LoadOptions) if part.name != "progress")
_TAKE = ".csv"

T = TypeVar("T")


class JobsTable:
    """A jobs file's data; what is wrong names the file, the line and the key.

    Parameters
    ----------
    where
        The file, a path or an address.
    text
        All of it.
    data
        The table with the jobs' keys, and `within` where it stands in the file.
    keys
        Those it may have.
    """

    def __init__(
        self,
        where: str,
        text: str,
        data: dict[str, Any],
        within: tuple[str, ...] = (),
        keys: tuple[str, ...] = KEYS,
    ) -> None:
        self.where, self.data = where, data
        self._text, self._within = text, within
        for key in data:
            if key not in keys:
                raise self.wrong(key, f"no such key{did_you_mean(key, keys)}")

    def wrong(self, key: str, what: object, *path: str | int) -> InputError:
        """The error about a key."""
        line = line_of(self._text, (*self._within, key, *path))
        at = f"{self.where}, line {line}" if line is not None else self.where
        return InputError(f"{at}: {'.'.join((*self._within, key))}: {what}")

    def resolved(self, text: str) -> str:
        """A path or address, relative to where the file is."""
        if is_address(text) or os.path.isabs(text):
            return text
        if is_address(self.where):
            return f"{self.where.rpartition('/')[0]}/{text}"
        return os.path.join(os.path.dirname(self.where), text)

    def entries(self, key: str, kinds: tuple[type, ...], allowed: str) -> list[Any]:
        """A list that must not be empty."""
        found = self.data.get(key)
        if not isinstance(found, list) or not found:
            raise self.wrong(key, f"is a list of {allowed}")
        for entry in found:
            if not isinstance(entry, kinds) or isinstance(entry, bool):
                raise self.wrong(key, f"{shown(entry)}: is a list of {allowed}")
        return found

    def collected(self, key: str, named: Iterable[tuple[str, Callable[[], T]]]) -> dict[str, T]:
        """What a list names, by names; each may be there once."""
        found: dict[str, T] = {}
        for name, load in named:
            if name in found:
                raise self.wrong(key, f"{name!r} is there twice; leave it in once")
            try:
                found[name] = load()
            except InputError as error:
                raise self.wrong(key, error) from None
        return found


def load_study(where: str | os.PathLike[str], out: str | None = None) -> Study:
    """The study of a jobs file (a path or an address), its inputs loaded.

    `out` is taken in place of the file's.

    Raises
    ------
    InputError
        What is wrong, with file, line and key.
    """
    name = os.fspath(where)
    text = read_text(name)
    file = JobsTable(name, text, parse_toml(text, name))
    if out is None:
        out = file.data.get("out")
        if not isinstance(out, str) or not out:
            raise file.wrong("out", "is a folder or an address (s3://bucket/study)")
        out = file.resolved(out)
    return read_grid(file, out)


def read_grid(
    file: JobsTable,
    out: str,
    timelines: Mapping[str, Timeline] | None = None,
    gestures: Mapping[str, Gesture] | None = None,
) -> Study:
    """The study of a table, its inputs loaded; given timelines and gestures come before its own.

    Raises
    ------
    InputError
        What is wrong, with file, line and key.
    """
    timelines = dict(timelines or {})
    if "timelines" in file.data or not timelines:
        timelines |= file.collected("timelines", _timelines(file))
    presets = file.collected("presets", _presets(file, timelines))
    gestures = dict(gestures or {})
    if "gestures" in file.data or not gestures:
        gestures |= file.collected("gestures", _gestures(file))
    parameters = _parameters(file, presets)
    study = Study(out, timelines, presets, gestures, parameters, _seeds(file), _settings(file))
    if len(study) > MOST_CASES:
        raise InputError(f"{file.where}: {len(study):,} renders; a study has up to {MOST_CASES:,}")
    return study


# --- what is combined -----------------------------------------------------------------------------


def _timelines(file: JobsTable) -> Iterable[tuple[str, Callable[[], Timeline]]]:
    allowed = "names, files (with * too), addresses, or tables with a file"
    for entry in file.entries("timelines", (str, dict), allowed):
        options: dict[str, Any] = {}
        name = entry
        if isinstance(entry, dict):
            options = dict(entry)
            name = options.pop("file", None)
            if not isinstance(name, str):
                raise file.wrong("timelines", "a table has a file = ...")
        for one in _matching(file, name) if name not in BUNDLED else [name]:
            label = one
            if options:
                pairs = (f"{key}={_plain(value)}" for key, value in options.items())
                label = f"{label} ({', '.join(pairs)})"
            yield label, lambda one=one, options=options: _timeline(file, one, options)  # type: ignore[misc]


def _plain(value: Any) -> str:
    return " to ".join(map(str, value)) if isinstance(value, list) else str(value)


def _matching(file: JobsTable, name: str) -> list[str]:
    """The files of a name with wildcards, sorted; a name without them as it is."""
    path = file.resolved(name)
    if not glob.has_magic(name):
        return [name]
    if is_address(path):
        fs, root = library("fsspec").core.url_to_fs(path)
        found = [fs.unstrip_protocol(one) for one in fs.glob(root)]
    else:
        found = glob.glob(name, root_dir=os.path.dirname(file.where) or ".")
    if not found:
        raise file.wrong("timelines", f"no file is like {name!r}")
    return sorted(found)


def _timeline(file: JobsTable, name: str, options: Mapping[str, Any]) -> Timeline:
    load = {key: value for key, value in options.items() if key not in ("window", "zoom_to")}
    for key in load:
        if key not in _LOAD_KEYS:
            raise InputError(
                f"{name}: no option {key!r}; there are window, zoom_to, {', '.join(_LOAD_KEYS)}"
            )
    if name in BUNDLED:
        timeline = load_timeline(name, **load)
    else:
        with local_copy(file.resolved(name)) as path:
            timeline = load_timeline(path, **load)
    window, zoom_to = options.get("window"), options.get("zoom_to")
    if window is not None and zoom_to is not None:
        raise InputError(f"{name}: window and zoom_to both name a part; give one of them")
    if window is not None:
        if not isinstance(window, list) or len(window) != 2:
            raise InputError(f"{name}: window = {shown(window)}; it is a list: start and end")
        return timeline.window(*window_of(timeline, str(window[0]), str(window[1])))
    if zoom_to is not None:
        return timeline.window(*zoom_window(timeline, str(zoom_to)))
    return timeline


def _presets(
    file: JobsTable, timelines: Mapping[str, Timeline]
) -> Iterable[tuple[str, Callable[[], Preset]]]:
    if "presets" not in file.data:
        name = best_preset_for(next(iter(timelines.values())))
        return [(name, lambda: load_preset(name))]
    allowed = "names or .toml files"
    return [
        (name, lambda name=name: _preset(file, name))  # type: ignore[misc]
        for name in file.entries("presets", (str,), allowed)
    ]


def _preset(file: JobsTable, name: str) -> Preset:
    if not name.endswith(SUFFIX):
        return load_preset(name)
    with local_copy(file.resolved(name)) as path:
        return load_preset(path)


def _gestures(file: JobsTable) -> Iterable[tuple[str, Callable[[], Gesture]]]:
    allowed = "gestures (sweep:0.5, tap:0.8:0.5, a take's file)"
    return [
        (spec, lambda spec=spec: _gesture(file, spec))  # type: ignore[misc]
        for spec in file.entries("gestures", (str,), allowed)
    ]


def _gesture(file: JobsTable, spec: str) -> Gesture:
    whole = file.resolved(spec)
    if spec.lower().endswith(_TAKE) and ("+" not in spec or os.path.exists(whole)):
        with local_copy(whole) as path:
            return load_gesture(path)
    parts = []
    for part in map(str.strip, spec.split("+")):
        is_take = part.lower().endswith(_TAKE)
        parts.append(_gesture(file, part) if is_take else parse_gesture(part))
    return sum(parts[1:], parts[0])


def _parameters(file: JobsTable, presets: Mapping[str, Preset]) -> dict[str, tuple[Value, ...]]:
    table = file.data.get("parameters", {})
    if not isinstance(table, dict):
        raise file.wrong("parameters", 'is a table: "tactor.gain_db" = [-6.0, 0.0]')
    found: dict[str, tuple[Value, ...]] = {}
    for id, given in _flat(table):
        try:
            values = _range(given) if isinstance(given, dict) else given
            if not isinstance(values, list) or not values:
                raise InputError(
                    "is a list of values, or {from = ..., to = ..., steps = ..., scale = ...}"
                )
            checked = []
            for value in values:
                for preset in presets.values():
                    preset.with_value(id, value)
                checked.append(float(value) if type(value) is int else value)
        except InputError as error:
            raise file.wrong("parameters", f"{id}: {error}", id) from None
        if len(set(checked)) < len(checked):
            raise file.wrong("parameters", f"{id}: a value is there twice", id)
        found[id] = tuple(checked)
    return found


_RANGE_KEYS = {"from", "to", "steps", "scale"}


def _flat(table: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, Any]]:
    """Ids with their values, whether written with quotes or as nested tables."""
    for key, value in table.items():
        if isinstance(value, dict) and not value.keys() & _RANGE_KEYS:
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _range(given: Mapping[str, Any]) -> list[float]:
    allowed = 'a range is {from = 1.0, to = 8.0, steps = 4, scale = "linear" or "log"}'
    if not {"from", "to", "steps"} <= given.keys() <= _RANGE_KEYS:
        raise InputError(f"{shown(dict(given))}; {allowed}")
    first, last, steps = given["from"], given["to"], given["steps"]
    scale = given.get("scale", "linear")
    numbers = all(type(value) in (int, float) and math.isfinite(value) for value in (first, last))
    if not numbers or type(steps) is not int or not 2 <= steps <= MOST_STEPS:
        raise InputError(f"{shown(dict(given))}; {allowed}, with 2 to {MOST_STEPS:,} steps")
    if scale not in ("linear", "log") or (scale == "log" and not (first > 0.0 and last > 0.0)):
        raise InputError(f"{shown(dict(given))}; {allowed}, and log above 0")
    part = [i / (steps - 1) for i in range(steps)]
    if scale == "log":
        inside = [first * (last / first) ** p for p in part]
    else:
        inside = [first + (last - first) * p for p in part]
    # the ends as they are written
    return [float(first), *inside[1:-1], float(last)]


def _seeds(file: JobsTable) -> tuple[int, ...]:
    given = file.data.get("seeds", [0])
    if type(given) is int and 1 <= given <= MOST_CASES:
        return tuple(range(given))
    if (
        isinstance(given, list)
        and given
        and all(type(seed) is int and -(2**63) <= seed < 2**63 for seed in given)
    ):
        if len(set(given)) == len(given):
            return tuple(given)
        raise file.wrong("seeds", "a seed is there twice")
    raise file.wrong("seeds", "is a number of seeds (100: 0 to 99), or a list of whole numbers")


# --- how it is rendered ---------------------------------------------------------------------------


def _settings(file: JobsTable) -> Settings:
    rate = file.data.get("sample_rate", 48_000)
    if type(rate) not in (int, float):
        raise file.wrong("sample_rate", f"{shown(rate)} is not a number of Hz")
    given = file.data.get("tail", "rest")
    form, subtype = file.data.get("format", "wav"), file.data.get("subtype")
    if not isinstance(form, str) or not re.fullmatch(r"[A-Za-z0-9]{1,8}", form):
        raise file.wrong("format", f"{shown(form)} is no format; it is wav, flac, ...")
    if subtype is not None and not isinstance(subtype, str):
        raise file.wrong("subtype", f"{shown(subtype)} is not a text")
    try:
        tail: Tail = tail_of(given) if isinstance(given, str) else checked_tail(given)
    except (InputError, TypeError) as error:
        raise file.wrong("tail", error) from None
    try:
        check_sound(f"sound.{form}", float(rate), subtype)
    except InputError as error:
        raise file.wrong("format", error) from None
    return Settings(float(rate), tail, form, subtype)
