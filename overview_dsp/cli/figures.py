"""`overview figures`: the paper's figures from this program."""

from __future__ import annotations

from typing import Any

import click

from overview_dsp.cli.common import announce_compile, show
from overview_dsp.cli.options.timeline import (
    open_timeline,
    preset_for,
    preset_option,
    timeline_options,
)


@click.command(name="figures", epilog="Example: overview figures --out pictures")
@click.option("--out", default=".", show_default=True, help="Folder for the pictures.")
@click.option("--timeline", default="world-cup-final-2018", show_default=True, help="Any file.")
@preset_option
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def command(
    out: str, timeline: str, preset: str | None, load: dict[str, Any], as_json: bool
) -> None:
    """Draw the paper's figures 4 (timeline), 5 (sweeps) and 6 (tap), as PNG and SVG."""
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.offline.plots.paper import draw, renders

    data = open_timeline(timeline, load)
    chosen = load_preset(preset_for(data, preset))
    announce_compile()
    files = draw(data, renders(data, chosen), out)
    show(as_json, {"files": [str(path) for path in files]}, *files)
