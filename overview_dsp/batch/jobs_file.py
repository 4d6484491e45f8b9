"""Jobs file: the TOML description of a render grid.

::

    out = "study"                       folder beside this file, or a URL; required
    timelines = ["world-cup-final-2018", "data/*.json",
                 {file = "AAPL.csv", value = "Close", window = ["end-6w", "end"]}]    required
    presets = ["football", "mine.toml"] default: the preset that fits the first timeline
    gestures = ["sweep:0.5", "tap:0.8:0.5", "takes/one.csv"]      required
    seeds = 100                         0 to 99; or a list
    sample_rate = 48000                 Hz
    tail = "none"                       rest, none, or seconds
    format = "wav"                      suffix of the sound files
    subtype = "PCM_16"                  as `overview render --subtype`

    [parameters]                        each combined with all others
    "tactor.gain_db" = [-12.0, -6.0, 0.0]
    "kinds.goal.height" = {from = 2.0, to = 32.0, steps = 5, scale = "log"}

The table of a timeline takes `window` or `zoom_to`, and the options of `load_timeline`. Paths and
URLs are relative to the file.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from overview_dsp.batch.grid import RenderGrid, Settings
from overview_dsp.batch.storage import fsspec, is_url, local_copy, read_text
from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.registry import BUNDLED
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.time_expressions import window_of, zoom_window
from overview_dsp.design.gestures import Gesture, load_gesture, parse_gesture
from overview_dsp.design.presets.library import fitting_preset_for, load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.errors import InputError, did_you_mean, quoted
from overview_dsp.files.schema import Allowed, Path, Strict, checked
from overview_dsp.files.sound import check_sound
from overview_dsp.files.toml import SUFFIX, line_of, parse_toml
from overview_dsp.offline.rendering.schedule import Tail, checked_tail, tail_of

MAX_CASES = 100_000_000
MAX_STEPS = 100_000
_LOAD_KEYS = tuple(part.name for part in fields(LoadOptions) if part.name != "progress")
_TAKE = ".csv"
_RANGE = 'a range {from = 1.0, to = 8.0, steps = 4, scale = "linear"}, where "log" is above 0'

T = TypeVar("T")
_Names = Annotated[list[str], Field(min_length=1)]
_Seed = Annotated[int, Field(ge=-(2**63), lt=2**63)]


class Jobs(Strict):
    """Keys of a jobs file."""

    out: (
        Annotated[str, Field(min_length=1), Allowed("a folder or a URL (s3://bucket/study)")] | None
    ) = None
    timelines: Annotated[
        list[str | dict[str, Any]],
        Field(min_length=1),
        Allowed("a list of names, files (with * too), URLs, or tables with a file"),
    ] = Field(default_factory=list)
    presets: Annotated[_Names, Allowed("a list of names or .toml files")] | None = None
    gestures: Annotated[
        _Names, Allowed("a list of gestures (sweep:0.5, tap:0.8:0.5, or the file of a take)")
    ] = Field(default_factory=list)
    seeds: Annotated[
        Annotated[int, Field(ge=1, le=MAX_CASES)] | Annotated[list[_Seed], Field(min_length=1)],
        Allowed("a number of seeds (100: 0 to 99), or a list of whole numbers"),
    ] = 1
    sample_rate: float = 48_000.0
    tail: Annotated[str | float, Allowed("rest, none or seconds")] = "rest"
    format: Annotated[
        str, Field(pattern="^[A-Za-z0-9]{1,8}$"), Allowed("the suffix of a sound file: wav, flac")
    ] = "wav"
    subtype: str | None = None
    parameters: Annotated[dict[str, Any], Allowed('a table: "tactor.gain_db" = [-6.0, 0.0]')] = (
        Field(default_factory=dict)
    )


class Range(Strict):
    """Values of a parameter between two ends."""

    first: float = Field(alias="from")
    last: float = Field(alias="to")
    steps: int = Field(ge=2, le=MAX_STEPS)
    scale: Literal["linear", "log"] = "linear"

    def values(self) -> list[float]:
        """Return the values; the ends are those that the file holds."""
        first, last = self.first, self.last
        parts = [i / (self.steps - 1) for i in range(1, self.steps - 1)]
        if self.scale == "log":
            return [first, *(first * (last / first) ** part for part in parts), last]
        return [first, *(first + (last - first) * part for part in parts), last]


KEYS = tuple(Jobs.model_fields)


class JobsTable:
    """Data of a jobs file, whose errors name file, line and key.

    `where`: path or URL of the file.
    `data`: table with the keys of the jobs, of the file's `text`.
    `within`: keys that lead to that table.
    `keys`: allowed keys.
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
                raise self.error(f"{self._name((key,))}: no such key{did_you_mean(key, keys)}", key)

    def error(self, message: str, *path: str | int) -> InputError:
        """Return an error with the file and the line of a key."""
        line = line_of(self._text, (*self._within, *path))
        return InputError(f"{self.where}:{line}: {message}" if line else f"{self.where}: {message}")

    @contextmanager
    def errors_at(self, name: str, *path: str | int) -> Iterator[None]:
        """Prefix an InputError with the file and line of a key, and with the key's name."""
        try:
            yield
        except InputError as error:
            raise self.error(f"{name}: {error}", *path) from None

    def _name(self, path: Path) -> str:
        return ".".join(map(str, (*self._within, *path)))

    def jobs(self) -> Jobs:
        """Return the checked data; InputError for the first value that isn't allowed."""
        found = checked(Jobs, self.data, self._name)
        if isinstance(found, Jobs):
            return found
        raise self.error(found[0].message, *found[0].path)

    def resolve(self, text: str) -> str:
        """Return a path or URL that is relative to the folder of the file."""
        if is_url(text) or os.path.isabs(text):
            return text
        if is_url(self.where):
            return f"{self.where.rpartition('/')[0]}/{text}"
        return os.path.join(os.path.dirname(self.where), text)

    def load_all(self, key: str, loaders: Iterable[tuple[str, Callable[[], T]]]) -> dict[str, T]:
        """Return the loaded entries of a list by name; each name may occur once."""
        found: dict[str, T] = {}
        name = self._name((key,))
        with self.errors_at(name, key):
            for entry, load in loaders:
                if entry in found:
                    raise InputError(f"{entry!r} occurs twice; remove one")
                found[entry] = load()
        if not found:
            metadata = Jobs.model_fields[key].metadata
            allowed = next(one.text for one in metadata if isinstance(one, Allowed))
            raise self.error(f"{name} is missing; must be {allowed}", key)
        return found


def load_jobs(where: str | os.PathLike[str], out: str | None = None) -> RenderGrid:
    """Load the render grid of a jobs file (a path or a URL) with all of its inputs; InputError.

    `out` replaces that of the file.
    """
    name = os.fspath(where)
    text = read_text(name)
    file = JobsTable(name, text, parse_toml(text, name))
    if out is None:
        given = file.jobs().out
        if given is None:
            raise file.error("out is missing; must be a folder or a URL (s3://bucket/study)")
        out = file.resolve(given)
    return read_grid(file, out)


def read_grid(
    file: JobsTable,
    out: str,
    timelines: Mapping[str, Timeline] | None = None,
    gestures: Mapping[str, Gesture] | None = None,
) -> RenderGrid:
    """Load the render grid of a table; InputError.

    `timelines` and `gestures` come before those of the table.
    """
    jobs = file.jobs()
    timelines, gestures = dict(timelines or {}), dict(gestures or {})
    if jobs.timelines or not timelines:
        timelines |= file.load_all("timelines", _timelines(file, jobs.timelines))
    names = jobs.presets
    if names is None:
        names = [fitting_preset_for(next(iter(timelines.values()))).preset]
    presets = file.load_all("presets", ((name, lambda n=name: _preset(file, n)) for name in names))  # type: ignore[misc]
    if jobs.gestures or not gestures:
        loaders = ((spec, lambda s=spec: _gesture(file, s)) for spec in jobs.gestures)
        gestures |= file.load_all("gestures", loaders)
    parameters = _parameters(file, jobs.parameters, presets)
    seeds = tuple(range(jobs.seeds) if isinstance(jobs.seeds, int) else jobs.seeds)
    if len(set(seeds)) < len(seeds):
        raise file.error("seeds: a seed occurs twice; remove one", "seeds")
    settings = _settings(file, jobs)
    grid = RenderGrid(out, timelines, presets, gestures, parameters, seeds, settings)
    if len(grid) > MAX_CASES:
        raise InputError(
            f"{file.where}: {len(grid):,} renders; a grid must have {MAX_CASES:,} or fewer"
        )
    return grid


def _timelines(
    file: JobsTable, entries: list[str | dict[str, Any]]
) -> Iterator[tuple[str, Callable[[], Timeline]]]:
    for entry in entries:
        options = dict(entry) if isinstance(entry, dict) else {}
        name = options.pop("file", None) if isinstance(entry, dict) else entry
        if not isinstance(name, str):
            raise InputError(f"{quoted(entry)} has no file; add file = ...")
        texts = (
            f"{key}={' to '.join(map(str, value)) if isinstance(value, list) else value}"
            for key, value in options.items()
        )
        label = f" ({', '.join(texts)})" if options else ""
        for one in [name] if name in BUNDLED else _expand(file, name):
            yield one + label, lambda one=one, options=options: _timeline(file, one, options)  # type: ignore[misc]


def _expand(file: JobsTable, name: str) -> list[str]:
    """Return the files that match a name with wildcards, sorted; or the name without wildcards."""
    if not glob.has_magic(name):
        return [name]
    path = file.resolve(name)
    if is_url(path):
        fs, root = fsspec().core.url_to_fs(path)
        found = [fs.unstrip_protocol(one) for one in fs.glob(root)]
    else:
        found = glob.glob(name, root_dir=os.path.dirname(file.where) or ".")
    if not found:
        raise InputError(f"no file matches {name!r}")
    return sorted(found)


def _timeline(file: JobsTable, name: str, options: Mapping[str, Any]) -> Timeline:
    load = {key: value for key, value in options.items() if key not in ("window", "zoom_to")}
    for key in load:
        if key not in _LOAD_KEYS:
            raise InputError(
                f"{name}: no option {key!r}; options are window, zoom_to, {', '.join(_LOAD_KEYS)}"
            )
    if name in BUNDLED:
        timeline = load_timeline(name, **load)
    else:
        with local_copy(file.resolve(name)) as path:
            timeline = load_timeline(path, **load)
    window, zoom_to = options.get("window"), options.get("zoom_to")
    if window is not None and zoom_to is not None:
        raise InputError(f"{name}: window and zoom_to both select a window; remove one of them")
    if zoom_to is not None:
        return timeline.window(*zoom_window(timeline, str(zoom_to)))
    if window is None:
        return timeline
    if not isinstance(window, list) or len(window) != 2:
        raise InputError(f"{name}: window = {quoted(window)}; must be a list of start and end")
    return timeline.window(*window_of(timeline, str(window[0]), str(window[1])))


def _preset(file: JobsTable, name: str) -> Preset:
    if not name.endswith(SUFFIX):
        return load_preset(name)
    with local_copy(file.resolve(name)) as path:
        return load_preset(path)


def _gesture(file: JobsTable, spec: str) -> Gesture:
    whole = file.resolve(spec)
    if spec.lower().endswith(_TAKE) and ("+" not in spec or os.path.exists(whole)):
        with local_copy(whole) as path:
            return load_gesture(path)
    parts = []
    for part in map(str.strip, spec.split("+")):
        is_take = part.lower().endswith(_TAKE)
        parts.append(_gesture(file, part) if is_take else parse_gesture(part))
    return sum(parts[1:], parts[0])


def _parameters(
    file: JobsTable, table: Mapping[str, Any], presets: Mapping[str, Preset]
) -> dict[str, tuple[Value, ...]]:
    found: dict[str, tuple[Value, ...]] = {}
    for id, given in _flatten(table):
        with file.errors_at(f"parameters: {id}", "parameters", id):
            values = _range(given) if isinstance(given, dict) else given
            if not isinstance(values, list) or not values:
                raise InputError(f"{quoted(given)}; must be a list of values, or {_RANGE}")
            for value in values:
                for preset in presets.values():
                    preset.with_value(id, value)
            found[id] = tuple(float(value) if type(value) is int else value for value in values)
            if len(set(found[id])) < len(values):
                raise InputError("a value occurs twice; remove one")
    return found


def _flatten(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield ids with their values, for quoted keys and for nested tables."""
    for key, value in table.items():
        if isinstance(value, dict) and not value.keys() & {"from", "to", "steps", "scale"}:
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _range(table: dict[str, Any]) -> list[float]:
    found = checked(Range, table)
    if not isinstance(found, Range):
        raise InputError(f"{found[0].message}; must be {_RANGE}, with 2 to {MAX_STEPS:,} steps")
    if found.scale == "log" and not (found.first > 0.0 and found.last > 0.0):
        raise InputError(f"{quoted(table)}; must be {_RANGE}")
    return found.values()


def _settings(file: JobsTable, jobs: Jobs) -> Settings:
    with file.errors_at("tail", "tail"):
        tail: Tail = tail_of(jobs.tail) if isinstance(jobs.tail, str) else checked_tail(jobs.tail)
    with file.errors_at("format", "format"):
        check_sound(f"sound.{jobs.format}", jobs.sample_rate, jobs.subtype)
    return Settings(jobs.sample_rate, tail, jobs.format, jobs.subtype)
