"""`overview study`: from a question to results."""

from __future__ import annotations

import click

from overview_studies.cli import making, results, serve


@click.group(name="study", epilog="Example: overview study check study.toml")
def command() -> None:
    """Studies with people: lists, a page, answers, statistics, exports."""


for _one in (
    making.check,
    making.lists,
    making.build,
    serve.serve,
    results.simulate,
    results.analyse,
    results.export,
):
    command.add_command(_one)
