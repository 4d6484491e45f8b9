"""`overview presets`: read, make and hear presets."""

from __future__ import annotations

import click

from overview_dsp.cli.presets import making, reading, sounding, taking


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """Read, make, compare and hear presets."""


for _one in (
    reading.list_,
    reading.show,
    reading.check,
    reading.diff,
    making.new,
    making.edit,
    making.morph,
    making.randomize,
    taking.import_,
    sounding.audition,
    sounding.feel,
    sounding.tune,
    reading.docs,
    reading.schema,
):
    command.add_command(_one)
