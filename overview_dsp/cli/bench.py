"""`overview bench`: how fast the engine runs here."""

from __future__ import annotations

import click

from overview_dsp.cli.common import announce_compile, print_json, progress_bar


@click.command(name="bench", epilog="Example: overview bench --rounds 9 --json")
@click.option(
    "--rounds", default=7, show_default=True, type=click.IntRange(1, 1000), help="Of each row."
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(rounds: int, as_json: bool) -> None:
    """Seconds of sound made in one second, on one core, beside other ways to do the same work."""
    from overview_dsp.bench import measure

    announce_compile()
    with progress_bar("measuring") as tell:
        rows = measure(rounds, tell)
    if as_json:
        print_json([vars(row) for row in rows])
        return
    width = max(len(row.name) for row in rows)
    base = rows[0].median
    click.echo(f"{'':<{width}}  x realtime (lowest to highest)      of the first row")
    for row in rows:
        spread = f"({row.low:.3g} to {row.high:.3g})"
        click.echo(f"{row.name:<{width}}  {row.median:10.4g}  {spread:<22} {row.median / base:.3g}")
