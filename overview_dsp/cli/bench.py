"""`overview bench`: how fast the engine runs here."""

from __future__ import annotations

import click

from overview_dsp.cli.common import announce_compile, print_json, progress_bar

SPEED_ROUNDS = 7
LIVE_ROUNDS = 5
LIVE_SECONDS = 60.0


@click.command(name="bench", epilog="Example: overview bench --live --seconds 10 --rounds 3")
@click.option(
    "--rounds",
    type=click.IntRange(1, 1000),
    help=f"Of each row.  [default: {SPEED_ROUNDS}; with --live {LIVE_ROUNDS}]",
)
@click.option("--live", is_flag=True, help="Play: callback times, frames lost, control latency.")
@click.option("--device", help="Output for --live, by name or number.  [default: the system's]")
@click.option(
    "--seconds",
    type=click.FloatRange(1.0, 3600.0),
    help=f"Of each run of --live.  [default: {LIVE_SECONDS:g}]",
)
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    rounds: int | None, live: bool, device: str | None, seconds: float | None, as_json: bool
) -> None:
    """Seconds of sound made in one second, on one core, beside other ways to do the same work.

    With --live: how the native and the Python callback hold, idle and under load, and how soon a
    tap is answered. That takes four runs a round and one more, 21 minutes by default, and sounds.
    """
    if live:
        _live(rounds or LIVE_ROUNDS, device, seconds or LIVE_SECONDS, as_json)
        return
    if device is not None or seconds is not None:
        raise click.UsageError("--device and --seconds belong to --live; add --live")
    _speed(rounds or SPEED_ROUNDS, as_json)


def _speed(rounds: int, as_json: bool) -> None:
    from overview_dsp.bench.speed import measure

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


def _live(rounds: int, device: str | None, seconds: float, as_json: bool) -> None:
    from dataclasses import asdict

    from overview_dsp.live.live_bench import latency_table, load_table, measure_live

    announce_compile()
    where = int(device) if device is not None and device.isdecimal() else device
    with progress_bar("playing") as tell:
        report = measure_live(where, seconds, rounds, tell)
    if as_json:
        print_json(asdict(report))
        return
    for line in [*load_table(report), "", *latency_table(report)]:
        click.echo(line)
