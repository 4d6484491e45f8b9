"""Public names for commands in other distributions, beside `ov`.

A distribution adds a command to `overview` by the entry-point group `overview_dsp.commands`. The
name of the entry point is that of the command, and its value is a `click.Command`. The summary of
the distribution stands in the list of commands. The entry point is imported when the command runs:

    [project.entry-points."overview_dsp.commands"]
    study = "overview_studies.cli:command"

Such a command uses `ov`, `overview_dsp.errors` and these names; everything else is private. The
names change between versions, so the distribution must require `overview-dsp` of its own version.
Each name is imported when it is first used.

=========  ==========================================================================
commands   `cli_command`, `option`, `SECONDS`: a command with the options in its
           signature; `announce_compile`, `note`, `progress_bar`, `show`;
           `ended_by_signals`, `wait_for_end`, `exit_if_stopped`: handling of
           signals; `Server`, `require_server`, `open_server`: a server with a token
files      `atomic_folder`, `sound_bytes`; `read_text`, `parse_toml`,
           `faults_at_their_line`: TOML, with errors that name the line
grids      `RenderGrid`, `Keys`, `KEYS`, `JobsTable`, `read_grid`, `PROGRAM`: the cases of
           a jobs file, and the cache key of each
signal     `CLICK`, `TACTOR`, `SOURCES`, `Value`, `AngleMap`, `stroke_feel`
pictures   `save_figure`, `plot_style`
page       `other_page_files`, `START`, `TYPES`, `RATES`, `kind_styles`, `window_json`,
           `whole_bytes`, `make_patch`; `threaded_endpoint`, `json_object`: requests with limits
=========  ==========================================================================
"""

# mypy: implicit-reexport
# ruff: noqa: F401
from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from overview_dsp.batch.cache_keys import PROGRAM, Keys
    from overview_dsp.batch.grid import RenderGrid
    from overview_dsp.batch.jobs_file import KEYS, JobsTable, read_grid
    from overview_dsp.cli.common import announce_compile, note, progress_bar, show
    from overview_dsp.cli.live_session import SECONDS
    from overview_dsp.cli.options.declaring import cli_command, option
    from overview_dsp.cli.options.server import Server, open_server, require_server
    from overview_dsp.cli.signals import ended_by_signals, exit_if_stopped, wait_for_end
    from overview_dsp.design.gestures.model import SOURCES
    from overview_dsp.design.presets.parameter import Value
    from overview_dsp.files.atomic import atomic_folder
    from overview_dsp.files.sound import sound_bytes
    from overview_dsp.files.toml import faults_at_their_line, parse_toml, read_text
    from overview_dsp.kernels.layout import CLICK, TACTOR
    from overview_dsp.measure.perceived_level import stroke_feel
    from overview_dsp.offline.plots import style as plot_style
    from overview_dsp.offline.plots.saving import save_figure
    from overview_dsp.signal.surface.angle_map import AngleMap
    from overview_dsp.web.assets import START, TYPES, other_page_files
    from overview_dsp.web.messages import json_object
    from overview_dsp.web.security.threaded_endpoint import threaded_endpoint
    from overview_dsp.web.site_content import RATES
    from overview_dsp.web.site_data import kind_styles, window_json
    from overview_dsp.web.sound_data import make_patch, whole_bytes

_MODULES = {
    "batch.cache_keys": "PROGRAM Keys",
    "batch.grid": "RenderGrid",
    "batch.jobs_file": "KEYS JobsTable read_grid",
    "cli.common": "announce_compile note progress_bar show",
    "cli.live_session": "SECONDS",
    "cli.options.declaring": "cli_command option",
    "cli.options.server": "Server open_server require_server",
    "cli.signals": "ended_by_signals exit_if_stopped wait_for_end",
    "design.gestures.model": "SOURCES",
    "design.presets.parameter": "Value",
    "files.atomic": "atomic_folder",
    "files.sound": "sound_bytes",
    "files.toml": "faults_at_their_line parse_toml read_text",
    "kernels.layout": "CLICK TACTOR",
    "measure.perceived_level": "stroke_feel",
    "offline.plots.saving": "save_figure",
    "signal.surface.angle_map": "AngleMap",
    "web.assets": "START TYPES other_page_files",
    "web.messages": "json_object",
    "web.security.threaded_endpoint": "threaded_endpoint",
    "web.site_content": "RATES",
    "web.site_data": "kind_styles window_json",
    "web.sound_data": "make_patch whole_bytes",
}


def __getattr__(name: str) -> object:
    """Import a name when it is first used."""
    if name == "plot_style":
        return import_module("overview_dsp.offline.plots.style")
    for module, names in _MODULES.items():
        if name in names.split():
            value: object = getattr(import_module(f"overview_dsp.{module}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
