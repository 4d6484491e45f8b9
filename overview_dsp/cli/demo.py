"""`overview demo`: the main job on the bundled match."""

from __future__ import annotations

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, print_json
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.files.atomic import make_folder

LISTEN = {
    "fast sweep": "the whole match in a second: each goal is a knock that stands out of a strong, "
    "even hum; on release the match runs back under your finger",
    "slow sweep": "the same match in four seconds: the hum is weaker, the disk sticks at each goal "
    "and snaps free; fouls are soft bumps between",
    "tap": "one touch at the end: everything up to there unfolds in two seconds, then held still "
    "it is silent, and on release it all comes back, slower and last goal first",
}


@cli_command("demo -o my-demo", name="demo")
def command(
    *,
    output: str = option("Folder for the files.", default="overview-demo"),
    as_json: bool = JSON,
) -> None:
    """Play the bundled match (World Cup final 2018) three ways, and draw it.

    Writes a fast sweep, a slow sweep and a tap as WAV files (left = clicks for the ear, right =
    the vibration for a tactor; headphones held in the hand work too) and the paper's figures.
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
    if as_json:
        print_json(
            {
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
        )
        return
    click.echo("pictures: " + ", ".join(str(path) for path in pictures if path.suffix == ".png"))
    click.echo(
        f"{timeline.title}. Crowd curve and most fouls are made up; goals and cards are not."
    )
