"""The options that say how a file becomes a timeline, the same on every command that takes one."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import keep_input, part_of, progress_bar

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline

# name of the option: (name in load_timeline, type, what stands for the value, help)
_OPTIONS: dict[str, tuple[str, type, str, str]] = {
    "--value": (
        "value",
        str,
        "COLUMN",
        "The column of values; COLUMN:share, :price or :plain says what.",
    ),
    "--time": ("time", str, "COLUMN", "The column of times; COLUMN:dmy, :hhmm, :s ... says how."),
    "--kind": ("kind", str, "COLUMN", "The column of kinds, in an event list."),
    "--label": ("label", str, "COLUMN", "The column of labels, in an event list."),
    "--map": (
        "map",
        str,
        "WHAT",
        "Felt: level, change, activity, volatility, count, a column (--follow: whole, so-far).",
    ),
    "--rate": ("rate", float, "HZ", "Samples a second, for a file without times."),
    "--match": ("match", str, "WORDS", "Which match of a file: its number, or 'France Croatia'."),
    "--duration": ("duration_s", float, "S", "Length, for an event list that doesn't give it."),
    "--max-mb": ("max_mb", float, "MB", "Read files up to so large."),
    "--max-depth": ("max_depth", int, "LEVELS", "Read JSON nested so deep."),
}


def timeline_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options to a command, which gets what was given as the one argument `load`.

    It opens its file with `open_timeline(path, load)`.
    """

    @functools.wraps(function)
    def collected(*arguments: Any, **named: Any) -> Any:
        load = {name: named.pop(name) for name, *_ in _OPTIONS.values()}
        given = {name: value for name, value in load.items() if value is not None}
        return function(*arguments, load=given, **named)

    for option, (name, kind, metavar, text) in reversed(_OPTIONS.items()):
        collected = click.option(option, name, type=kind, metavar=metavar, help=text)(collected)
    return collected


def preset_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """The option --preset, for `preset_for`."""
    return click.option(
        "--preset", help="A name or a .toml file.  [default: the one that fits the data]"
    )(function)


def linear_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """The option --linear, which leaves a preset's angle map out."""
    return click.option(
        "--linear", is_flag=True, help="Keep positions proportional to time: no angle map."
    )(function)


def preset_for(timeline: Timeline, preset: str | None) -> str:
    """The preset that was asked for, or the bundled one that fits the data."""
    from overview_dsp.design.presets.library import fitting_preset

    return preset if preset is not None else fitting_preset(timeline)


def open_part(
    path: str, load: dict[str, Any], window: tuple[str, str] | None, zoom_to: str | None
) -> Timeline:
    """The part of a timeline that --window or --zoom-to names, or the whole; errors as they."""
    whole = open_timeline(path, load)
    part = part_of(whole, window, zoom_to)
    return whole if part is None else whole.window(*part)


def open_timeline(path: str, load: dict[str, Any]) -> Timeline:
    """Load a timeline with the given options, with a progress bar where that takes long.

    Raises
    ------
    InputError
        As `load_timeline`.
    """
    from overview_dsp.data.readers import load_timeline

    keep_input(path)
    with progress_bar(f"reading {path}") as progress:
        return load_timeline(path, progress=progress, **load)
