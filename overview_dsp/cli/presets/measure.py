"""`overview presets`: audition, feel, tune: what a preset is like."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import (
    announce_compile,
    print_json,
    progress_bar,
    window_options,
)
from overview_dsp.cli.options.timeline import open_part, timeline_options
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.presets.model import EventKind


@click.command(epilog="Example: overview presets audition heart -o heart.wav")
@click.argument("preset")
@click.option("-o", "--out", help="The sound file.  [default: PRESET-audition.wav here]")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def audition(preset: str, out: str | None, seed: int, as_json: bool) -> None:
    """Sweep over every kind of event of PRESET, a sound file, and a picture beside it.

    Left is what is heard, right what is felt.
    """
    from overview_dsp.plots.presets import plot_gallery
    from overview_dsp.plots.saving import save_figure
    from overview_dsp.presets.library import load_preset
    from overview_dsp.rendering.audition import audition as sound

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
    click.echo(f"{path}: {', '.join(loaded.kinds)}, out and back")
    click.echo(pictures[0])


@click.command(epilog="Example: overview presets feel football match.json --plot feel.png")
@click.argument("preset")
@click.argument("timeline", required=False)
@click.option("--plot", help="Also draw it, to a .png, .svg or .pdf file.")
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def feel(
    preset: str,
    timeline: str | None,
    plot: str | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Measure what a finger gets of each kind of PRESET: slow, medium, fast, a tap, the recoils.

    On TIMELINE, or on a made-up one with every kind of the preset. Says which kinds could not be
    distinguished, which are masked or merged, and what to change.
    """
    from overview_dsp.measure.report import feel_report
    from overview_dsp.plots.presets import plot_feel
    from overview_dsp.plots.saving import require_picture, save_picture
    from overview_dsp.presets.library import load_preset
    from overview_dsp.rendering.audition import pages

    loaded = load_preset(preset)
    timelines = pages(loaded)
    if timeline is not None:
        data = open_part(timeline, load, window, zoom_to)
        if not data.events:
            raise InputError(f"{timeline}: has no events; there is nothing to distinguish")
        timelines = (data,)
    if plot is not None:
        require_picture(plot)
    announce_compile()
    report = feel_report(loaded, timelines)
    if plot is not None:
        save_picture(plot_feel(report), plot)
    if as_json:
        print_json({**report.to_json(), "warnings": report.warnings()})
        return
    click.echo(report.table())
    for line in report.warnings():
        click.echo(f"note: {line}")


@click.command(epilog="Example: overview presets tune my-match --target 'goal>red_card>foul'")
@click.argument("preset")
@click.option("--target", help="Kinds from the strongest down, joined by >.")
@click.option("--apart", is_flag=True, help="Set all kinds apart, a step in any way they are felt.")
@click.option("--seed", default=0, show_default=True, help="Of the search.")
@click.option("-o", "--out", help="The file.  [default: PRESET-tuned.toml here]")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def tune(
    preset: str, target: str | None, apart: bool, seed: int, out: str | None, as_json: bool
) -> None:
    """Move heights and widths until each kind of the target is two steps above the next.

    With --apart until no two kinds of PRESET feel alike; a target's kinds are then a step above the
    next.
    """
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.measure.tuning import separated, tuned
    from overview_dsp.presets.library import load_preset
    from overview_dsp.presets.writing import save_preset

    if target is None and not apart:
        raise InputError("give --target KIND>KIND, --apart, or both")
    loaded = load_preset(preset)
    order = [] if target is None else [name.strip() for name in target.split(">")]
    announce_compile()
    with progress_bar(f"tuning {loaded.name}") as progress:
        found = (separated if apart else tuned)(loaded, order, seed, progress)
    names = list(loaded.kinds) if apart else order
    path = Path(out) if out is not None else Path(f"{loaded.name}-tuned{SUFFIX}")
    save_preset(found.preset, path)
    if as_json:
        print_json(
            {
                "file": str(path),
                "least_steps": round(found.least_steps, 2),
                "reached": found.reached,
                "kinds": {
                    name: {
                        "height": found.preset.kinds[name].height,
                        "width_percent": found.preset.kinds[name].width_percent,
                        "width_ms": found.preset.kinds[name].width_ms,
                    }
                    for name in names
                },
            }
        )
        return
    for name in names:
        before, after = loaded.kinds[name], found.preset.kinds[name]
        click.echo(
            f"{name}: height {before.height:g} to {after.height:.4g}, {_widths(before, after)}"
        )
    reached = "reached" if found.reached else "not reached: use fewer kinds, or allow more height"
    wanted = "from any other at every speed; one" if apart else "above the next at every speed; two"
    click.echo(f"{path}: each at least {found.least_steps:.1f} steps {wanted} {reached}")


def _widths(before: EventKind, after: EventKind) -> str:
    if before.width_percent is not None and after.width_percent is not None:
        return f"width {before.width_percent:g} to {after.width_percent:.3g} %"
    return f"width {before.width_ms:g} to {after.width_ms:.4g} ms"
