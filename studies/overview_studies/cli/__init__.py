"""Command `overview study`."""

from __future__ import annotations

import click

from overview_studies.cli import preparation, results, serve


@click.group(name="study", epilog="Example: overview study check study.toml")
def command() -> None:
    """Run studies with participants: lists, a page, answers, statistics and exports."""


for _one in (
    preparation.check,
    preparation.lists,
    preparation.build,
    serve.serve,
    results.simulate,
    results.analyse,
    results.export,
):
    command.add_command(_one)
