"""`overview presets`: list, show, check."""

from __future__ import annotations

import click

from overview_dsp.cli.common import print_json


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """Read and check presets."""


@command.command(name="list", epilog="Example: overview presets list")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def list_(as_json: bool) -> None:
    """The bundled presets and what each is for."""
    from overview_dsp.presets import bundled_names, load_preset

    found = [load_preset(name) for name in bundled_names()]
    if as_json:
        print_json(
            [{"name": p.name, "title": p.title, "description": p.description} for p in found]
        )
        return
    width = max(len(preset.name) for preset in found)
    for preset in found:
        click.echo(f"{preset.name:<{width}}  {preset.title}: {preset.description}")


@command.command(epilog="Example: overview presets show football")
@click.argument("preset")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def show(preset: str, as_json: bool) -> None:
    """Every parameter of PRESET with its value, range and meaning, and its event kinds."""
    from overview_dsp.presets import load_preset
    from overview_dsp.presets.describe import describe, describe_json

    loaded = load_preset(preset)
    if as_json:
        print_json(describe_json(loaded))
    else:
        click.echo(describe(loaded))


@command.command(epilog="Example: overview presets check my-preset.toml")
@click.argument("presets", nargs=-1, required=True)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def check(presets: tuple[str, ...], as_json: bool) -> None:
    """Check PRESETS (names or .toml files): file, line, key and range of the first fault."""
    from overview_dsp.errors import InputError
    from overview_dsp.presets import load_preset

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
