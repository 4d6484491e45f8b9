"""Command line: one module per command, imported when the command runs.

Other distributions add commands by the entry-point group `overview_dsp.commands` (`extensions`).
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
from overview_dsp.errors import InputError, OverviewError, OverviewWarning, did_you_mean, printable
from overview_dsp.files.atomic import remove_temporaries
from overview_dsp.files.toml import load_toml

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "overview_dsp.commands"  # entry-point group of commands in other distributions

COMMANDS: dict[str, str] = load_toml(__file__, "commands.toml")
"""Summaries of the commands by the names of their modules, from `commands.toml`."""

SEPARATE_COMMANDS = dict.fromkeys(
    ("learn", "study"), "not installed; install it in a clone of the project: pip install ./studies"
)
"""Commands in other distributions of this project, with the way to install each."""


def added_commands() -> dict[str, EntryPoint]:
    """Return the entry points of commands in other distributions, by name."""
    from importlib.metadata import entry_points  # late: it is slow

    return {point.name: point for point in entry_points(group=GROUP)}


class Commands(click.Group):
    """Group of all commands, which imports a command when it runs."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of `COMMANDS`, then those of other distributions."""
        return list(dict.fromkeys([*COMMANDS, *added_commands()]))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return the command, None for an unknown one; InputError without it."""
        if cmd_name in COMMANDS:
            command = import_module(f"overview_dsp.cli.{cmd_name}").command
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
        elif cmd_name in SEPARATE_COMMANDS:
            raise InputError(f"overview {cmd_name}: {SEPARATE_COMMANDS[cmd_name]}")
        else:
            return None
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Resolve a command; the error for an unknown name lists the nearest names."""
        # the hint of click would need all commands
        name = args[0]
        if name not in COMMANDS and not ctx.resilient_parsing:
            known = {**COMMANDS, **added_commands(), **SEPARATE_COMMANDS}
            near = did_you_mean(name, known) if name not in known else ""
            if near:
                ctx.fail(f"No such command {name!r}{near}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        rows = dict(COMMANDS)
        for name, point in added_commands().items():
            summary = point.dist.metadata["Summary"] if point.dist is not None else None
            rows.setdefault(name, summary or f"of {point.value}")
        for name in SEPARATE_COMMANDS:
            rows.setdefault(name, f"Not installed: overview {name} shows how to install it.")
        with formatter.section("Commands"):
            formatter.write_dl([*rows.items()])


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
    """Feel a timeline: any temporal data become friction, which is heard and felt."""


def _fail(message: str, code: int) -> NoReturn:
    words = sys.argv[1:]
    if "--json" in words or "--screen=json" in words or ("--screen", "json") in pairwise(words):
        line = " ".join(message.split())
        text = json.dumps({"error": line, "exit_code": code}, ensure_ascii=False)
    else:
        text = f"error: {message}"
    click.echo("\n".join(map(printable, text.split("\n"))), err=True)
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
        from overview_dsp.cli.common import note  # late: it is slow

        note(str(message))


def main() -> NoReturn:
    """Run the command line; a wrong input is one line and exit code 2, without a traceback."""
    try:
        _run()
    except KeyboardInterrupt:  # a signal while another error is reported
        _stop()


def _stop() -> NoReturn:
    remove_temporaries()
    # an interrupt of code in a string (of a dataclass) would end `python -m` with SIGINT's code
    exec("")
    _fail("stopped; no partial output is left", stop_code())


def _run() -> NoReturn:
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
        # a group without a command
        click.echo(error.format_message(), err=True)
        sys.exit(2)
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else "overview"
        message = " ".join(error.format_message().split())
        files = [word for word in sys.argv[1:] if word.startswith("-") and os.path.exists(word)]
        if files and isinstance(error, click.exceptions.NoSuchOption):
            message += f" For the file, use ./{files[0]}"
        _fail(f"{message} (see {path} --help)", 2)
    except click.ClickException as error:
        _fail(" ".join(error.format_message().split()), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        _stop()
    except BrokenPipeError:
        sys.exit(0)
    except OSError as error:
        if debug:
            raise
        what = error.filename if error.filename is not None else "the output"
        _fail(" ".join(f"{what}: {error.strerror or error}".split()), 1)
    except Exception as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # while a class was made
            _stop()
        if debug:
            raise
        _fail(
            f"{type(error).__name__}: {error} (a bug of this program; please report it with the "
            "traceback of overview --debug ...)",
            1,
        )
    sys.exit(code if isinstance(code, int) else 0)
