"""The command `overview figures`."""

from __future__ import annotations

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.reading import PRESET_OPTION, Reading, open_timeline, preset_for


@cli_command("figures -o pictures", name="figures")
def command(
    *,
    output: str = option(default="."),
    timeline: str = option(default="world-cup-final-2018"),
    preset: str | None = PRESET_OPTION,
    as_json: bool = JSON,
    reading: Reading,
) -> None:
    """Draw figures 4 (timeline), 5 (sweeps) and 6 (tap) of the paper, as PNG and SVG."""
    from overview_dsp.offline.plots.paper import draw, renders

    data = open_timeline(timeline, reading)
    chosen = ov.load_preset(preset_for(data, preset))
    announce_compile()
    files = draw(data, renders(data, chosen), output)
    show(as_json, {"files": [str(path) for path in files]}, *files)
