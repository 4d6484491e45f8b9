"""Options of reading a timeline, of its window, and of the preset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import overview_dsp as ov
from overview_dsp.cli.common import note, progress_bar, protect_inputs
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
"""Argument of `load_timeline` and type of each key of --read."""


@dataclass(frozen=True)
class Reading:
    """Options of `load_timeline`."""

    heading: ClassVar[str] = DATA

    value_column: str | None = option(metavar="COLUMN")
    time_column: str | None = option(metavar="COLUMN")
    map: str | None = option(metavar="WHAT")
    select: str | None = option(metavar="WHICH")
    read: tuple[str, ...] = option(metavar="KEY=VALUE")

    def load_options(self) -> dict[str, Any]:
        """Return the arguments of `load_timeline`, without unset ones."""
        keys = {key: convert for key, (_, convert) in READ_KEYS.items()}
        read = {
            READ_KEYS[key][0]: value
            for key, value in parse_pairs("--read", self.read, keys).items()
        }
        columns = {"value": self.value_column, "time": self.time_column}
        options = {**columns, "map": self.map, "match": self.select, **read}
        return {name: value for name, value in options.items() if value is not None}


@dataclass(frozen=True)
class Window:
    """Options --window and --zoom-to."""

    heading: ClassVar[str] = DATA

    window: tuple[str, str] | None = option(metavar="START END")
    zoom_to: str | None = option(metavar="KIND:NUMBER[:LENGTH]")

    def of(self, timeline: Timeline) -> tuple[float, float] | None:
        """Return the window (start_s, end_s); None for the whole timeline.

        InputError: there are both options, or an invalid one, which the message names.
        """
        from overview_dsp.data.timeline.time_expressions import window_of, zoom_window
        from overview_dsp.validation import prefix_errors

        if self.window and self.zoom_to is not None:
            raise InputError("--window and --zoom-to exclude each other; remove one")
        if self.window:
            with prefix_errors("--window: "):
                return window_of(timeline, *self.window)
        if self.zoom_to is not None:
            with prefix_errors("--zoom-to: "):
                return zoom_window(timeline, self.zoom_to)
        return None


PRESET_OPTION = option()


@dataclass(frozen=True)
class PresetChoice:
    """Options --preset and --linear."""

    heading: ClassVar[str] = PRESET

    preset: str | None = PRESET_OPTION
    linear: bool = option()

    def load(self, name: str) -> Preset:
        """Load a preset, without its angle map if --linear is set."""
        from overview_dsp.signal.surface.angle_map import without_map

        preset = ov.load_preset(name)
        return without_map(preset) if self.linear else preset


def preset_for(timeline: Timeline, preset: str | None) -> str:
    """Return `preset`, or the one that fits the data, with a note on the reason."""
    from overview_dsp.design.presets.library import fitting_preset_for

    if preset is not None:
        return preset
    chosen = fitting_preset_for(timeline)
    note(str(chosen))
    return chosen.preset


def open_window(path: str, reading: Reading, window: Window) -> Timeline:
    """Load a timeline, and return its selected window or all of it; InputError."""
    whole = open_timeline(path, reading)
    limits = window.of(whole)
    return whole if limits is None else whole.window(*limits)


def open_timelines(path: str, group: str, reading: Reading) -> dict[str, Timeline]:
    """Load one timeline for each text of a column; errors as `load_timelines`."""
    protect_inputs(path)
    if reading.select is not None:
        raise InputError("--group and --select exclude each other; remove one")
    return ov.load_timelines(path, group, **reading.load_options())


def open_timeline(path: str, reading: Reading, lists_notes: bool = False) -> Timeline:
    """Load a timeline, with a progress bar; errors as `load_timeline`.

    Events that the reader left out are noted, unless the caller lists all notes.
    """
    protect_inputs(path)
    options = reading.load_options()
    with progress_bar(f"reading {path}") as progress:
        timeline = ov.load_timeline(path, progress=progress, **options)
    for line in () if lists_notes else timeline.notes:
        if "omitted" in line:
            note(line)
    return timeline
