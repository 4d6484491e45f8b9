"""The commands `overview presets` list, show, check, diff, reference and schema."""

from __future__ import annotations

import click

import overview_dsp as ov
from overview_dsp.cli.common import list_profiles, print_json
from overview_dsp.cli.common import show as show_report
from overview_dsp.cli.options.declaring import JSON, argument, cli_command, option
from overview_dsp.errors import InputError


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """List, make, compare and measure presets."""


@cli_command("presets list --for football --tag energy=1", group=command)
def list_(
    *,
    tags: tuple[str, ...] = option("--tag", metavar="TAG"),
    use: str | None = option("--for", metavar="USE"),
    as_json: bool = JSON,
) -> None:
    """List the bundled presets and yours, with their purpose."""
    from overview_dsp.design.presets import library

    for tag in tags:
        library.check_tag(tag)

    def matches(name: str) -> bool:
        preset = library.load_preset(name)
        return all(library.has_tag(preset, tag) for tag in tags) and (
            use is None or library.is_for_use(preset, use)
        )

    names = [*library.LIBRARY.bundled, *library.LIBRARY.user]
    if tags or use is not None:
        names = [name for name in names if matches(name)]
    list_profiles(
        names,
        library.load_preset,
        lambda preset: {"tags": vars(preset.tags), "file": str(library.preset_path(preset.name))},
        as_json,
    )
    if not names and not as_json:
        click.echo("no preset matches; overview presets list --json lists all with their tags")


@cli_command("presets show football", group=command)
def show(preset: str, *, as_json: bool = JSON) -> None:
    """Show all parameters of PRESET with values, ranges and meanings, and its event kinds."""
    from overview_dsp.design.presets.describe import describe, describe_json

    loaded = ov.load_preset(preset)
    show_report(as_json, describe_json(loaded), describe(loaded))


@cli_command("presets check my-preset.toml", group=command)
def check(presets: tuple[str, ...] = argument(required=True), *, as_json: bool = JSON) -> None:
    """Check PRESETS (names or .toml files); errors name file, line, key and range."""
    faults, report, lines = [], [], []
    for name in presets:
        try:
            kinds = list(ov.load_preset(name).kinds)
        except InputError as error:
            faults.append(str(error))
            report.append({"preset": name, "valid": False, "error": str(error)})
        else:
            report.append({"preset": name, "valid": True, "kinds": kinds})
            lines.append(f"{name}: valid, {len(kinds)} event kinds")
    show_report(as_json, report, *lines)
    for fault in faults[:-1]:
        click.echo(f"error: {fault}", err=True)
    if faults:
        raise InputError(faults[-1])


@cli_command("presets diff football my-preset.toml", group=command)
def diff(first: str, second: str, *, as_json: bool = JSON) -> None:
    """Compare two presets, value by value."""
    found = ov.presets.differences(ov.load_preset(first), ov.load_preset(second))
    rows = [(one.id, _format(one.first), _format(one.second), one.unit) for one in found]
    widths = [max((len(row[i]) for row in rows), default=0) for i in range(3)]
    lines = [
        f"{id:<{widths[0]}}  {before:>{widths[1]}}  {after:>{widths[2]}}  {unit}".rstrip()
        for id, before, after, unit in rows
    ]
    show_report(as_json, [vars(one) for one in found], *(lines or ["no difference"]))


def _format(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else "-" if value is None else str(value)


@cli_command("presets reference > parameters.md", group=command)
def reference_(*, as_json: bool = JSON) -> None:
    """Print the parameter reference, as Markdown."""
    from overview_dsp.design.presets.reference import reference, reference_json

    if as_json:
        print_json(reference_json())
    else:
        click.echo(reference(), nl=False)


@cli_command("presets schema > preset.schema.json", group=command)
def schema() -> None:
    """Print the JSON Schema of preset files, for completion in TOML editors.

    Editors with Taplo read it if the first line of the preset is "#:schema ./preset.schema.json".
    overview presets new writes both.
    """
    from overview_dsp.design.presets.reference import json_schema

    print_json(json_schema())
