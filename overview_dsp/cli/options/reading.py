"""Options for how a file becomes a timeline, which window of it is shown, and by which preset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import overview_dsp as ov
from overview_dsp.cli.common import keep_input, progress_bar
from overview_dsp.cli.options.declaring import option, parse_pairs
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import Preset

DATA, PRESET = "Data", "Preset"

READ_KEYS: dict[str, tuple[str, Any]] = {
    "kind": ("kind", str),
    "label": ("label", str),
    "rate": ("rate", float),
    "duration": ("duration_s", float),
    "max-mb": ("max_mb", float),
    "max-depth": ("max_depth", int),
}
"""Each key of --read: the argument of `load_timeline`, and its type."""


@dataclass(frozen=True)
class Reading:
    """Options of `load_timeline`."""

    heading: ClassVar[str] = DATA

    value_column: str | None = option(
        "Column of values; COLUMN:share, :price or :plain sets what they are.", metavar="COLUMN"
    )
    time_column: str | None = option(
        "Column of times; COLUMN:dmy, :hhmm, :s ... sets their format.", metavar="COLUMN"
    )
    map: str | None = option(
        "Intensity: level, change, activity, volatility, count, or a column.", metavar="WHAT"
    )
    select: str | None = option(
        "One of several matches or series: its number, its words, or COLUMN=VALUE.", metavar="WHICH"
    )
    read: tuple[str, ...] = option(
        "kind=COLUMN, label=COLUMN (event lists), rate=HZ (files without times), duration=S "
        "(event lists), max-mb=MB, max-depth=LEVELS (limits). May be repeated.",
        metavar="KEY=VALUE",
    )

    def load_options(self) -> dict[str, Any]:
        """Return the arguments of `load_timeline` that were given."""
        keys = {key: convert for key, (_, convert) in READ_KEYS.items()}
        read = {
            READ_KEYS[key][0]: value
            for key, value in parse_pairs("--read", self.read, keys).items()
        }
        columns = {"value": self.value_column, "time": self.time_column}
        given = {**columns, "map": self.map, "match": self.select, **read}
        return {name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True)
class Window:
    """Options --window and --zoom-to."""

    heading: ClassVar[str] = DATA

    window: tuple[str, str] | None = option(
        "Only this window: seconds, m:ss, h:mm:ss, dates, goal:1-60, end-6w.", metavar="START END"
    )
    zoom_to: str | None = option(
        "Window about an event: goal:1, goal:1:90.", metavar="KIND:NUMBER[:LENGTH]"
    )

    def of(self, timeline: Timeline) -> tuple[float, float] | None:
        """Return the window (start_s, end_s); None for the whole timeline.

        Raises
        ------
        InputError
            Both are given, or one that names no window; the line begins with the option.
        """
        from overview_dsp.data.timeline.moments import window_of, zoom_window
        from overview_dsp.validation import located

        if self.window and self.zoom_to is not None:
            raise InputError("--window and --zoom-to both name a window; give one of them")
        if self.window:
            with located("--window: "):
                return window_of(timeline, *self.window)
        if self.zoom_to is not None:
            with located("--zoom-to: "):
                return zoom_window(timeline, self.zoom_to)
        return None


PRESET_OPTION = option("Name or .toml file.  [default: the one that fits the data]")


@dataclass(frozen=True)
class PresetChoice:
    """Options --preset and --linear."""

    heading: ClassVar[str] = PRESET

    preset: str | None = PRESET_OPTION
    linear: bool = option("Keep positions proportional to time: no angle map.")

    def load(self, name: str) -> Preset:
        """Load a preset, without its angle map where that is asked for."""
        from overview_dsp.signal.surface.angle_map import without_map

        preset = ov.load_preset(name)
        return without_map(preset) if self.linear else preset


def preset_for(timeline: Timeline, preset: str | None) -> str:
    """Return the preset that was given, or the bundled one that fits the data."""
    from overview_dsp.design.presets.library import best_preset_for

    return preset if preset is not None else best_preset_for(timeline)


def open_window(path: str, reading: Reading, window: Window) -> Timeline:
    """Load the window of a timeline that was given, or the whole; errors as they."""
    whole = open_timeline(path, reading)
    part = window.of(whole)
    return whole if part is None else whole.window(*part)


def open_timeline(path: str, reading: Reading) -> Timeline:
    """Load a timeline, with a progress bar where that takes long; errors as `load_timeline`."""
    keep_input(path)
    options = reading.load_options()
    with progress_bar(f"reading {path}") as progress:
        return ov.load_timeline(path, progress=progress, **options)
