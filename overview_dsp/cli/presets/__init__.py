"""`overview presets`: read, make and hear presets."""

from __future__ import annotations

import click

from overview_dsp.cli.presets import create, inspect, measure


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """Read, make, compare and hear presets."""


for _one in (
    inspect.list_,
    inspect.show,
    inspect.check,
    inspect.diff,
    create.new,
    create.edit,
    create.morph,
    create.randomize,
    create.import_,
    measure.audition,
    measure.feel,
    measure.tune,
    inspect.docs,
    inspect.schema,
):
    command.add_command(_one)
