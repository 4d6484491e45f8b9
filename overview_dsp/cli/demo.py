"""The command `overview demo`."""

from __future__ import annotations

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.files.atomic import make_folder
from overview_dsp.files.toml import load_toml

LISTEN = load_toml(__file__, "demo.toml")


@cli_command("demo -o my-demo", name="demo")
def command(*, output: str = option(default="overview-demo"), as_json: bool = JSON) -> None:
    """Render the bundled match (World Cup final 2018) in three ways, and draw the figures.

    The command writes a fast sweep, a slow sweep and a tap as WAV files, and the figures of the
    paper. Left has the clicks for the ear, right the vibration for a tactor (or for headphones that
    you hold).
    """
    from overview_dsp.data.readers import bundled_timeline
    from overview_dsp.offline.plots.paper import draw, renders

    folder = make_folder(output)
    timeline, preset = bundled_timeline(), ov.load_preset("football")
    announce_compile()
    sounds = []
    for name, result in renders(timeline, preset).items():
        path = folder / f"{name.replace(' ', '-')}.wav"
        result.save(path)
        sounds.append((path, name, result))
        if not as_json:
            click.echo(f"{path}  ({len(result.samples) / result.sample_rate:.1f} s)")
            click.echo(f"    {LISTEN[name]}")
    pictures = draw(timeline, {name: result for _, name, result in sounds}, folder)
    report = {
        "sounds": [
            {
                "file": str(path),
                "gesture": name,
                "duration_s": len(result.samples) / result.sample_rate,
                "listen_for": LISTEN[name],
            }
            for path, name, result in sounds
        ],
        "pictures": [str(path) for path in pictures],
    }
    show(
        as_json,
        report,
        "pictures: " + ", ".join(str(path) for path in pictures if path.suffix == ".png"),
        f"{timeline.title}. Goals and cards are real; the crowd curve and most fouls are invented.",
    )
