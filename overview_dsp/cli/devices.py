"""`overview devices`: what can play here, and what is missing."""

from __future__ import annotations

import click

from overview_dsp.cli.common import print_json


@click.command(name="devices", epilog="Example: overview devices --json")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(as_json: bool) -> None:
    """List audio outputs with their channels and latency."""
    from overview_dsp.live.portaudio import no_output_hint, outputs

    found = outputs()
    if as_json:
        print_json([vars(output) for output in found])
        return
    if not found:
        click.echo(f"PortAudio sees no output: {no_output_hint()}; rendering to files needs none")
    for output in found:
        star = "*" if output.default else " "
        click.echo(
            f"{star}{output.index:>3}  {output.name} ({output.host}): {output.channels} channels, "
            f"{output.sample_rate:g} Hz, latency {output.latency_s * 1e3:.1f} ms"
        )
