"""Commands declared by their signature, and groups of options under a heading of their own.

Of a command's function, a parameter without a default is an argument, one whose default is
`option(...)` is an option, and one annotated with a dataclass is a group: each field of the
dataclass is an option, and the function gets the group as an object.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import Field, field, fields, is_dataclass
from typing import Any

import click

from overview_dsp.errors import InputError, did_you_mean

GENERAL = "Options"

_BY_ANNOTATION: dict[str, dict[str, Any]] = {
    "bool": {"is_flag": True},
    "int": {"type": int},
    "float": {"type": float},
    "tuple[str, ...]": {"multiple": True},
    "tuple[str, str]": {"nargs": 2},
}


def option(help: str, *names: str, heading: str = GENERAL, **settings: Any) -> Any:
    """Declare an option, as the default of a command's parameter or of a group's field.

    Without `names` it is named as the parameter is (`output` is `-o`, too); its type is that of the
    annotation. `settings` are those of `click.Option`, and a default is shown in the help.
    """
    declared = {"help": help, "names": names, "heading": heading, **settings}
    return field(default=settings.get("default"), metadata=declared)


def argument(**settings: Any) -> Any:
    """Declare an argument that needs settings of `click.Argument`."""
    return field(default=None, metadata=settings)


JSON = option("Report as JSON.", "--json")


class GroupOption(click.Option):
    """Option with the heading that it is listed under."""

    def __init__(self, declared: Field[Any], name: str, annotation: str, heading: str) -> None:
        settings = {**_BY_ANNOTATION.get(annotation.removesuffix(" | None"), {})}
        settings |= {"show_default": "default" in declared.metadata, **declared.metadata}
        short = ["-o"] if name == "output" else []
        names = settings.pop("names") or (*short, f"--{name.replace('_', '-')}")
        self.heading = settings.pop("heading") if heading == GENERAL else heading
        settings.pop("heading", None)
        super().__init__([*names, name], **settings)


class GroupedCommand(click.Command):
    """Command whose help lists options by heading."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one section for each heading, in the order of the options."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                sections.setdefault(getattr(parameter, "heading", GENERAL), []).append(record)
        for heading, records in sections.items():
            with formatter.section(heading):
                formatter.write_dl(records)


def _argument(name: str, annotation: str, settings: Mapping[str, Any]) -> click.Argument:
    many = {"nargs": -1} if annotation == "tuple[str, ...]" else {}
    required = {"required": False} if annotation.endswith("| None") or many else {}
    return click.Argument([name], **{**many, **required, **settings})


def cli_command(
    example: str, name: str | None = None, group: click.Group | None = None
) -> Callable[[Callable[..., Any]], click.Command]:
    """Make a function a command, which is added to `group`; `example` is one of its calls."""

    def decorate(function: Callable[..., Any]) -> click.Command:
        parameters: list[click.Parameter] = []
        groups: dict[str, type] = {}
        for one in inspect.signature(function).parameters.values():
            kind = function.__globals__.get(one.annotation)
            if isinstance(kind, type) and is_dataclass(kind):
                groups[one.name] = kind
                heading = kind.heading  # type: ignore[attr-defined]
                parameters += [GroupOption(f, f.name, str(f.type), heading) for f in fields(kind)]
            elif not isinstance(one.default, Field):
                parameters.append(_argument(one.name, one.annotation, {}))
            elif "names" in one.default.metadata:
                parameters.append(GroupOption(one.default, one.name, one.annotation, GENERAL))
            else:
                parameters.append(_argument(one.name, one.annotation, one.default.metadata))

        @functools.wraps(function)
        def call(**values: Any) -> Any:
            for name, kind in groups.items():
                values[name] = kind(**{one.name: values.pop(one.name) for one in fields(kind)})
            return function(**values)

        command = GroupedCommand(
            name or function.__name__.rstrip("_"),
            callback=call,
            params=parameters,
            help=function.__doc__,
            epilog=f"Example: overview {example}",
        )
        if group is not None:
            group.add_command(command)
        return command

    return decorate


def refuse_options(why: str, *refused: str | type) -> None:
    """InputError if one of these options, or of these groups', was given; it ends with `why`."""
    from click.core import ParameterSource

    context = click.get_current_context()
    names = {
        name
        for one in refused
        for name in ([one] if isinstance(one, str) else [option.name for option in fields(one)])
    }
    for parameter in context.command.params:
        given = context.get_parameter_source(parameter.name or "") is ParameterSource.COMMANDLINE
        if given and parameter.name in names:
            raise InputError(f"{parameter.opts[0]} {why}")


def parse_pairs(
    option: str, texts: tuple[str, ...], known: Mapping[str, Callable[[str], Any]]
) -> dict[str, Any]:
    """Return the values of KEY=VALUE texts; `known` converts each key's.

    Raises
    ------
    InputError
        A text without `=`, a key that is not known or given twice, a value that can't be converted.
    """
    values: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or key not in known:
            what = f"unknown key {key!r}" if equals else "no KEY=VALUE"
            raise InputError(
                f"{option} {text}: {what}{did_you_mean(key, known)}; keys: {', '.join(known)}"
            )
        if key in values:
            raise InputError(f"{option} {text}: {key} is given twice; give it once")
        try:
            values[key] = known[key](value)
        except InputError as error:
            raise InputError(f"{option} {text}: {error}") from None
        except ValueError:
            kind = "a whole number" if known[key] is int else "a number"
            raise InputError(f"{option} {text}: {value!r} is not {kind}") from None
    return values
