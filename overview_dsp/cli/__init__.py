"""The command line: one command a file, each imported only when it is called.

Other distributions add theirs by the entry-point group `overview_dsp.commands` (`extensions`).
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from importlib import import_module
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NoReturn

import click

from overview_dsp import __version__
from overview_dsp.cli.signals import stop_code, stopped_by_signals
from overview_dsp.errors import InputError, OverviewError, OverviewWarning, did_you_mean
from overview_dsp.files.atomic import remove_temporaries

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "overview_dsp.commands"
"""The entry points that name commands of other distributions."""

# name: (module, the line in the list of commands)
COMMANDS = {
    "demo": ("demo", "The bundled match: sounds, pictures, and what to listen for."),
    "render": ("render", "Play a gesture over a timeline into a sound file."),
    "play": ("play", "Play a timeline live, with the mouse, the keys or a recorded hand."),
    "serve": ("serve", "The page: a phone or a browser as the hand."),
    "feed": ("feed", "Tell a recorded match as a feed, at any speed, for --follow."),
    "timeline": ("timeline", "Show what was understood from a file, and convert it."),
    "export": ("export", "Bake a gesture to the haptic clips of phones and controllers."),
    "plugin": ("plugin", "Build an audio plugin that plays a timeline in a DAW."),
    "batch": ("batch", "Render a study: a grid of many, here or on a cluster."),
    "presets": ("presets", "List, show and check presets."),
    "actuators": ("actuators", "Show, measure and calibrate what the tactor's signal drives."),
    "osc": ("osc", "Learn what the messages of other programs and apps do."),
    "midi": ("midi", "Learn what the controls of a MIDI controller do."),
    "sensor": ("sensor", "Learn what a sensor sends, by turning it."),
    "figures": ("figures", "Draw the paper's figures 4, 5 and 6 from this program."),
    "devices": ("devices", "List audio outputs, serial and MIDI ports, pads, and what is missing."),
    "bench": ("bench", "Measure how fast the engine runs here."),
}

INSTALLED_APART = {
    "study": "studies with people are a distribution of their own, overview-dsp-studies; "
    "install it from a clone of the project: pip install ./studies"
}
"""Commands of this project's other distributions, and how to install each."""


def added_commands() -> dict[str, EntryPoint]:
    """Return the entry points of other distributions' commands, by the command's name."""
    from importlib.metadata import entry_points  # not before a command of another is meant

    return {point.name: point for point in entry_points(group=GROUP)}


class Commands(click.Group):
    """The group of all commands, which imports one only when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the table's, the main job first; then those of other distributions."""
        return list(dict.fromkeys([*COMMANDS, *added_commands()]))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return the command; None if there is none of that name.

        Raises
        ------
        InputError
            It belongs to a distribution that isn't installed, or that fails to give it.
        """
        if cmd_name in COMMANDS:
            command = import_module(f"overview_dsp.cli.{COMMANDS[cmd_name][0]}").command
        elif point := added_commands().get(cmd_name):
            try:
                command = point.load()
            except (ImportError, AttributeError) as error:
                raise InputError(f"{_added_by(point)} can't be loaded: {error}") from error
            if not isinstance(command, click.Command):
                raise InputError(
                    f"{_added_by(point)} is a {type(command).__name__}, not a click.Command; "
                    "report it to its authors"
                )
        elif cmd_name in INSTALLED_APART:
            raise InputError(f"overview {cmd_name}: {INSTALLED_APART[cmd_name]}")
        else:
            return None
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As click does, with the nearest name where there is none of that name."""
        # click's own hint knows only commands that are imported
        name = args[0]
        if name not in COMMANDS and not ctx.resilient_parsing:
            known = {**COMMANDS, **added_commands(), **INSTALLED_APART}
            near = did_you_mean(name, known) if name not in known else ""
            if near:
                ctx.fail(f"No such command {name!r}{near}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        rows = {name: text for name, (_, text) in COMMANDS.items()}
        for name, point in added_commands().items():
            rows.setdefault(name, _summary(point))
        for name in INSTALLED_APART:
            rows.setdefault(name, f"Not installed; overview {name} prints how to install it.")
        with formatter.section("Commands"):
            formatter.write_dl([*rows.items()])


def _summary(point: EntryPoint) -> str:
    found = point.dist.metadata["Summary"] if point.dist is not None else None
    return found or f"of {point.value}"


def _added_by(point: EntryPoint) -> str:
    package = point.value if point.dist is None else point.dist.name
    return f"the command {point.name} of {package}"


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Start with: overview demo",
)
@click.version_option(__version__, message="overview %(version)s")
@click.option("--debug", is_flag=True, help="Show a traceback when something fails.")
def app(debug: bool) -> None:
    """Feel a timeline: any temporal data as friction, heard as clicks and felt as vibration."""


def _file_meant(error: click.UsageError) -> str:
    """How a file is named whose name begins as an option does, if there is one."""
    if not isinstance(error, click.exceptions.NoSuchOption):
        return ""
    files = [one for one in sys.argv[1:] if one.startswith("-") and os.path.exists(one)]
    return f" Or, for the file: ./{files[0]}" if files else ""


def _fail(message: str, code: int) -> NoReturn:
    words = sys.argv[1:]
    if "--json" in words or "--screen=json" in words or ("--screen", "json") in pairwise(words):
        line = " ".join(message.split())
        said = json.dumps({"error": line, "exit_code": code}, ensure_ascii=False)
    else:
        said = f"error: {message}"
    click.echo(said, err=True)
    sys.exit(code)


def _note(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: Any = None,
    line: str | None = None,
) -> None:
    if issubclass(category, OverviewWarning):
        from overview_dsp.cli.common import note  # not before there is something to say

        note(str(message))


def main() -> NoReturn:
    """Run the command line; a person's mistake is one line and exit code 2, never a traceback."""
    debug = "--debug" in sys.argv[1:2]
    warnings.simplefilter("always", OverviewWarning)
    warnings.showwarning = _note
    try:
        with stopped_by_signals():
            code = app.main(prog_name="overview", standalone_mode=False)
    except OverviewError as error:
        if debug:
            raise
        _fail(str(error), error.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        # a group without a command: its help, as it is
        click.echo(error.format_message(), err=True)
        sys.exit(2)
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else "overview"
        _fail(
            f"{' '.join(error.format_message().split())}{_file_meant(error)} (see {path} --help)", 2
        )
    except click.ClickException as error:
        _fail(" ".join(error.format_message().split()), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        remove_temporaries()
        _fail("stopped; nothing was left behind", stop_code())
    except BrokenPipeError:
        sys.exit(0)
    except OSError as error:
        if debug:
            raise
        what = error.filename if error.filename is not None else "the output"
        _fail(" ".join(f"{what}: {error.strerror or error}".split()), 1)
    except Exception as error:
        if debug:
            raise
        _fail(
            f"{type(error).__name__}: {error} (a fault of this program, please report it; "
            "overview --debug ... shows where)",
            1,
        )
    sys.exit(code if isinstance(code, int) else 0)
