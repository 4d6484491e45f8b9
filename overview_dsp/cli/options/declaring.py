"""Declaration of commands by function signatures, with options in groups.

A parameter without a default is an argument. A parameter with the default `option(...)` is an
option. A parameter whose type is a dataclass is a group: each field is an option, and the function
gets the group as an object.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import Field, field, fields, is_dataclass
from typing import Any

import click

from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.files.toml import load_toml

GENERAL = "Options"
MAX_OPTIONS = 12  # most options that --help shows; a command with more names those used first

_BY_ANNOTATION: dict[str, dict[str, Any]] = {
    "bool": {"is_flag": True},
    "int": {"type": int},
    "float": {"type": float},
    "tuple[str, ...]": {"multiple": True},
    "tuple[str, str]": {"nargs": 2},
}


HELP: dict[str, dict[str, str]] = load_toml(__file__, "help.toml")
"""Help by the long name of an option: of groups and commands, and shared by several."""


def option(*names: str, heading: str = GENERAL, **settings: Any) -> Any:
    """Declare an option, as the default of a parameter or of a field in a group.

    The default of `names` is the name of the parameter (`output` is `-o`, too). The annotation sets
    the type. `settings` are those of `click.Option`, with the help of `HELP` by default; the help
    shows a default among them.
    """
    declared = {"names": names, "heading": heading, **settings}
    return field(default=settings.get("default"), metadata=declared)


def argument(**settings: Any) -> Any:
    """Declare an argument with settings of `click.Argument`."""
    return field(default=None, metadata=settings)


_SHOWS_ALL = f"{__name__}.shows_all"
JSON = option("--json")


class GroupOption(click.Option):
    """Option with a heading in the help."""

    def __init__(
        self, declared: Field[Any], name: str, annotation: str, owner: str, heading: str
    ) -> None:
        settings = {**_BY_ANNOTATION.get(annotation.removesuffix(" | None"), {})}
        settings |= {"show_default": "default" in declared.metadata, **declared.metadata}
        short = ["-o"] if name == "output" else []
        names = settings.pop("names") or (*short, f"--{name.replace('_', '-')}")
        long = next(one for one in names if one.startswith("--")).partition("/")[0][2:]
        if "help" not in settings:
            settings["help"] = HELP.get(owner, {}).get(long) or HELP["shared"][long]
        self.heading = settings.pop("heading") if heading == GENERAL else heading
        settings.pop("heading", None)
        super().__init__([*names, name], **settings)


class GroupedCommand(click.Command):
    """Command whose help lists options by heading; --help-all lists more if `first` is not empty.

    `example` is a call without `overview`; `first` names the parameters that --help shows.
    """

    def __init__(self, name: str, example: str, first: tuple[str, ...], **settings: Any) -> None:
        super().__init__(name, **settings)
        self.example, self.first = example, first
        if first:
            self.params.append(
                click.Option(
                    ["--help-all"],
                    is_flag=True,
                    is_eager=True,
                    expose_value=False,
                    callback=self._show_all,
                    help="Show all options, with details, and exit.",
                )
            )

    def _show_all(self, ctx: click.Context, parameter: click.Parameter, value: bool) -> None:
        if value:
            ctx.meta[_SHOWS_ALL] = True
            click.echo(self.get_help(ctx), color=ctx.color)
            ctx.exit()

    def _hides(self, ctx: click.Context) -> bool:
        return bool(self.first) and _SHOWS_ALL not in ctx.meta

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the text (its first paragraph, if options are hidden) and the example."""
        text = inspect.cleandoc(self.help or "")
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(text.partition("\n\n")[0] if self._hides(ctx) else text)
            formatter.write_paragraph()
            formatter.write_text(f"Example: overview {self.example}")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one section for each heading, in the order of the options."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None or not isinstance(parameter, click.Option):
                continue
            heading = GENERAL
            if isinstance(parameter, GroupOption):
                if self._hides(ctx) and parameter.name not in self.first:
                    continue
                heading = parameter.heading
            sections.setdefault(heading, []).append(record)
        general = sections.pop(GENERAL)
        for heading, records in [*sections.items(), (GENERAL, general)]:
            with formatter.section(heading):
                formatter.write_dl(records)


def _argument(name: str, annotation: str, settings: Mapping[str, Any]) -> click.Argument:
    many = {"nargs": -1} if annotation == "tuple[str, ...]" else {}
    required = {"required": False} if annotation.endswith("| None") or many else {}
    return click.Argument([name], **{**many, **required, **settings})


def cli_command(
    example: str, name: str | None = None, group: click.Group | None = None, first: str = ""
) -> Callable[[Callable[..., Any]], click.Command]:
    """Make a function a command, and add it to `group`.

    `example`: call of the command, without `overview`.
    `name`: name of the command; None: that of the function.
    `first`: names of the parameters that --help shows, if there are more than `MAX_OPTIONS`.
    """

    def decorate(function: Callable[..., Any]) -> click.Command:
        own_name = name or function.__name__.rstrip("_")
        parameters: list[click.Parameter] = []
        groups: dict[str, type] = {}
        for one in inspect.signature(function).parameters.values():
            kind = function.__globals__.get(one.annotation)
            if isinstance(kind, type) and is_dataclass(kind):
                groups[one.name] = kind
                heading = kind.heading  # type: ignore[attr-defined]
                parameters += [
                    GroupOption(f, f.name, str(f.type), kind.__name__, heading)
                    for f in fields(kind)
                ]
            elif not isinstance(one.default, Field):
                parameters.append(_argument(one.name, one.annotation, {}))
            elif "names" in one.default.metadata:
                owner = own_name if group is None else f"{group.name} {own_name}"
                parameters.append(
                    GroupOption(one.default, one.name, one.annotation, owner, GENERAL)
                )
            else:
                parameters.append(_argument(one.name, one.annotation, one.default.metadata))

        @functools.wraps(function)
        def call(**values: Any) -> Any:
            for name, kind in groups.items():
                values[name] = kind(**{one.name: values.pop(one.name) for one in fields(kind)})
            return function(**values)

        command = GroupedCommand(
            own_name,
            example,
            tuple(first.split()),
            callback=call,
            params=parameters,
            help=function.__doc__,
        )
        if group is not None:
            group.add_command(command)
        return command

    return decorate


def require_none(problems: Mapping[str, object]) -> None:
    """Raise click.UsageError with the first of these problems that is true."""
    for problem, applies in problems.items():
        if applies:
            raise click.UsageError(problem)


def refuse_options(why: str, *refused: str | type) -> None:
    """Refuse options, or groups of options, with an InputError that ends with `why`."""
    from click.core import ParameterSource

    context = click.get_current_context()
    names = {
        name
        for one in refused
        for name in ([one] if isinstance(one, str) else [option.name for option in fields(one)])
    }
    for parameter in context.command.params:
        is_set = context.get_parameter_source(parameter.name or "") is ParameterSource.COMMANDLINE
        if is_set and parameter.name in names:
            raise InputError(f"{parameter.opts[0]} {why}")


def parse_pairs(
    option: str, texts: tuple[str, ...], known: Mapping[str, Callable[[str], Any]]
) -> dict[str, Any]:
    """Parse KEY=VALUE texts; `known` has the converter of each key; InputError."""
    values: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or key not in known:
            problem = f"unknown key {key!r}" if equals else "not KEY=VALUE"
            raise InputError(
                f"{option} {text}: {problem}{did_you_mean(key, known)}; keys: {', '.join(known)}"
            )
        if key in values:
            raise InputError(f"{option} {text}: {key} occurs twice; remove one")
        try:
            values[key] = known[key](value)
        except InputError as error:
            raise InputError(f"{option} {text}: {error}") from None
        except ValueError:
            kind = "a whole number" if known[key] is int else "a number"
            raise InputError(f"{option} {text}: {value!r} is not {kind}") from None
    return values
