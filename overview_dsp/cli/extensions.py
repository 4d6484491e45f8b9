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
files      `atomic_folder`, `write_file`, `sound_bytes`; `read_text`, `parse_toml`,
           `faults_at_their_line`: TOML, with errors that name the line; `read_table`,
           `write_table`: JSON settings of the user
grids      `RenderGrid`, `Keys`, `KEYS`, `JobsTable`, `read_grid`, `PROGRAM`: the cases of
           a jobs file, and the cache key of each
signal     `CLICK`, `TACTOR`, `SOURCES`, `Value`, `AngleMap`, `stroke_feel`
output     `resolve_output`: the settings of an output device
pictures   `save_figure`, `plot_style`
page       `other_page_files`, `START`, `TYPES`, `RATES`, `kind_styles`, `window_json`,
           `whole_bytes`, `make_patch`; `threaded_endpoint`, `json_object`: requests with limits
=========  ==========================================================================
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
