"""`overview plugin`: a timeline as an instrument of a digital audio workstation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from overview_dsp.cli.common import print_json, window_options
from overview_dsp.cli.options.timeline import open_part, preset_for, timeline_options


@click.group(name="plugin", epilog="Example: overview plugin build match.json --to clap -o plugins")
def command() -> None:
    """Build audio plugins that play a timeline without Python."""


@command.command(
    name="build", epilog="Example: overview plugin build match.json --to clap -o ~/.clap"
)
@click.argument("timeline")
@click.option(
    "--preset",
    "presets",
    multiple=True,
    help="A name or a .toml file; of several, one is chosen in the host.  "
    "[default: the one that fits the data]",
)
@click.option(
    "--to", "to", required=True, type=click.Choice(("clap", "lv2")), help="The plugin's format."
)
@click.option("-o", "--out", default=".", show_default=True, help="The folder it is put into.")
@click.option("--name", help="What it is called.  [default: TIMELINE's name]")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def build(
    timeline: str,
    presets: tuple[str, ...],
    to: str,
    out: str,
    name: str | None,
    seed: int,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Compile TIMELINE to a plugin, with the samples of `render`; it needs a C compiler."""
    from overview_dsp.export.plugins import build_plugin
    from overview_dsp.presets.library import load_preset

    data = open_part(timeline, load, window, zoom_to)
    chosen = [load_preset(preset) for preset in presets or (preset_for(data, None),)]
    made = build_plugin(data, chosen, to, out, name=name or Path(timeline).stem, seed=seed)
    names = [preset.name for preset in chosen]
    if as_json:
        print_json({"format": to, "file": str(made), "presets": names})
        return
    click.echo(f"{made}: {', '.join(names)}; clicks on output 1, the tactor on output 2")
