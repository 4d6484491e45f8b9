"""`overview presets`: list, show, check, diff, docs, schema."""

from __future__ import annotations

import click

from overview_dsp.cli.common import list_profiles, print_json


@click.command(name="list", epilog="Example: overview presets list --for football --tag energy=1")
@click.option(
    "--tag",
    "tags",
    multiple=True,
    metavar="TAG",
    help="Only those with it: a use (discreet listening: 'in company') or a scale, energy=4, "
    "tempo<3, roughness>2. May be given several times.",
)
@click.option(
    "--for", "use", metavar="USE", help="Only those for it: football, stocks, weather, ..."
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def list_(tags: tuple[str, ...], use: str | None, as_json: bool) -> None:
    """The bundled presets and your own, and what each is for."""
    from overview_dsp.design.presets.library import (
        LIBRARY,
        load_preset,
        preset_path,
        require_tag,
        serves,
        tagged,
    )

    for tag in tags:
        require_tag(tag)

    def wanted(name: str) -> bool:
        preset = load_preset(name)
        return all(tagged(preset, tag) for tag in tags) and (use is None or serves(preset, use))

    names = [*LIBRARY.bundled, *LIBRARY.own]
    if tags or use is not None:
        names = [name for name in names if wanted(name)]
    list_profiles(
        names,
        load_preset,
        lambda preset: {
            "name": preset.name,
            "title": preset.title,
            "description": preset.description,
            "tags": vars(preset.tags),
            "file": str(preset_path(preset.name)),
        },
        as_json,
    )
    if not names and not as_json:
        click.echo("no preset is like that; overview presets list has all, with --json their tags")


@click.command(epilog="Example: overview presets show football")
@click.argument("preset")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def show(preset: str, as_json: bool) -> None:
    """Every parameter of PRESET with its value, range and meaning, and its event kinds."""
    from overview_dsp.design.presets.describe import describe, describe_json
    from overview_dsp.design.presets.library import load_preset

    loaded = load_preset(preset)
    if as_json:
        print_json(describe_json(loaded))
    else:
        click.echo(describe(loaded))


@click.command(epilog="Example: overview presets check my-preset.toml")
@click.argument("presets", nargs=-1, required=True)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def check(presets: tuple[str, ...], as_json: bool) -> None:
    """Check PRESETS (names or .toml files): file, line, key and range of the first fault."""
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.errors import InputError

    faults = []
    report = []
    for name in presets:
        try:
            preset = load_preset(name)
        except InputError as error:
            faults.append(str(error))
            report.append({"preset": name, "valid": False, "error": str(error)})
            continue
        report.append({"preset": name, "valid": True, "kinds": list(preset.kinds)})
        if not as_json:
            click.echo(f"{name}: valid, {len(preset.kinds)} event kinds")
    if as_json:
        print_json(report)
    for fault in faults[:-1]:
        click.echo(f"error: {fault}", err=True)
    if faults:
        raise InputError(faults[-1])


@click.command(epilog="Example: overview presets diff football my-preset.toml")
@click.argument("first")
@click.argument("second")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def diff(first: str, second: str, as_json: bool) -> None:
    """What differs between two presets, value by value."""
    from overview_dsp.design.presets.comparing import differences
    from overview_dsp.design.presets.library import load_preset

    found = differences(load_preset(first), load_preset(second))
    if as_json:
        print_json([vars(one) for one in found])
        return
    if not found:
        click.echo("no difference")
        return
    rows = [(one.id, _shown(one.first), _shown(one.second), one.unit) for one in found]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    for id, before, after, unit in rows:
        line = f"{id:<{widths[0]}}  {before:>{widths[1]}}  {after:>{widths[2]}}  {unit}"
        click.echo(line.rstrip())


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else "-" if value is None else str(value)


@click.command(epilog="Example: overview presets docs > parameters.md")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def docs(as_json: bool) -> None:
    """The parameter reference, as Markdown."""
    from overview_dsp.design.presets.reference import reference, reference_json

    if as_json:
        print_json(reference_json())
    else:
        click.echo(reference(), nl=False)


@click.command(epilog="Example: overview presets schema > preset.schema.json")
@click.option("--json", "as_json", is_flag=True, help="It is JSON already.")
def schema(as_json: bool) -> None:
    """The JSON Schema of preset files, for completion in TOML editors.

    With it beside a preset, the preset's first line "#:schema ./preset.schema.json" is all that
    editors with Taplo need; `overview presets new` writes both.
    """
    from overview_dsp.design.presets.reference import json_schema

    print_json(json_schema())
