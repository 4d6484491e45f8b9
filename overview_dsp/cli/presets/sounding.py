"""`overview presets audition`: a preset to hear, feel and look at."""

from __future__ import annotations

from pathlib import Path

import click

from overview_dsp.cli.common import announce_compile, print_json


@click.command(epilog="Example: overview presets audition heart -o heart.wav")
@click.argument("preset")
@click.option("-o", "--out", help="The sound file.  [default: PRESET-audition.wav here]")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def audition(preset: str, out: str | None, seed: int, as_json: bool) -> None:
    """Sweep over every kind of event of PRESET, twice each: a sound file, and a picture beside it.

    Left is what is heard, right what is felt.
    """
    from overview_dsp.audition import audition as sound
    from overview_dsp.plots import plot_gallery, save_figure
    from overview_dsp.presets import load_preset

    loaded = load_preset(preset)
    path = Path(out) if out is not None else Path(f"{loaded.name}-audition.wav")
    announce_compile()
    result = sound(loaded, seed)
    result.save(path)
    pictures = save_figure(plot_gallery(result, loaded), path.with_suffix(""))
    if as_json:
        print_json(
            {
                "file": str(path),
                "pictures": [str(picture) for picture in pictures],
                "kinds": [
                    {"kind": event.kind, "time_s": round(event.time_s, 3)}
                    for event in result.engine.timeline.events
                ],
            }
        )
        return
    click.echo(f"{path}: {', '.join(loaded.kinds)}, twice each, out and back")
    click.echo(pictures[0])
