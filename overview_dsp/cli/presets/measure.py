"""`overview presets`: audition, feel, tune: what a preset is like.

The options of an observer: what it gets, whose hands move, which random numbers.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import announce_compile, print_json, progress_bar, window_options
from overview_dsp.cli.options.timeline import open_part, timeline_options
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import EventKind, Preset
    from overview_dsp.measure.arm import ArmReport
    from overview_dsp.measure.observer.report import ObserverReport
    from overview_dsp.measure.report import FeelReport


MODALITIES = ("touch", "sound", "both")
HANDS = ("all", "steady", "arm", "mixed")


def observer_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options to a command, which gets those that were given as the argument `asked`.

    They are arguments of `measure.observe`.
    """

    @functools.wraps(function)
    def collected(
        *arguments: Any,
        modality: tuple[str, ...],
        hands: str | None,
        seed: int | None,
        **named: Any,
    ) -> Any:
        given = {"modalities": modality or None, "hands": hands, "seed": seed}
        asked = {name: value for name, value in given.items() if value is not None}
        return function(*arguments, asked=asked, **named)

    for decorate in (
        click.option("--seed", type=click.IntRange(min=0), help="Of the observer.  [default: 0]"),
        click.option(
            "--hands",
            type=click.Choice(HANDS),
            help="An observer's strokes: steady (sweeps, a tap, the recoil), arm (releases early), "
            "all of these, or mixed (speeds up, hesitates, turns back).  [default: all]",
        ),
        click.option(
            "--modality",
            multiple=True,
            type=click.Choice(MODALITIES),
            help="What an observer gets; may be repeated.  [default: all three]",
        ),
    ):
        collected = decorate(collected)
    return collected


@click.command(epilog="Example: overview presets audition heart -o heart.wav")
@click.argument("preset")
@click.option("-o", "--out", help="The sound file.  [default: PRESET-audition.wav here]")
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def audition(preset: str, out: str | None, seed: int, as_json: bool) -> None:
    """Sweep over every kind of event of PRESET, a sound file, and a picture beside it.

    Left is what is heard, right what is felt.
    """
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.measure.pictures import plot_gallery
    from overview_dsp.offline.plots.saving import save_figure
    from overview_dsp.offline.rendering.audition import audition as sound

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
@click.argument("timelines", metavar="[TIMELINE]...", nargs=-1)
@click.option("--plot", "--picture", "plot", help="Also draw it, to a .png, .svg or .pdf file.")
@click.option(
    "--observer",
    is_flag=True,
    help="Which kinds an observer with human limits tells apart, and takes for another.",
)
@observer_options
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def feel(
    preset: str,
    timelines: tuple[str, ...],
    plot: str | None,
    observer: bool,
    asked: dict[str, Any],
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Measure what a finger gets of each kind of PRESET: slow, medium, fast, a tap, the recoils.

    On a made-up timeline with every kind of the preset. Says which kinds could not be
    distinguished, which are masked or merged, and what to change.

    On TIMELINEs, each event where it lies, in its crowd: medians and spreads by kind, whether the
    order of importance is kept, what is missed, masked, and lost beside which other kind.

    A human arm beside the sweeps: how far the disk lags, which events it never reaches, what
    scrubbing and a tap give. An arm speeds up, slows down and releases without waiting.

    With --observer: what can be told apart in sweeps of 1 to 30 s, a recoil, a tap and an arm's
    movements, by touch, by sound and by both. It learns on random timelines like real ones, and is
    asked about others and about every TIMELINE given.
    """
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.offline.plots.saving import require_picture

    loaded = load_preset(preset)
    given = []
    for path in timelines:
        given.append(open_part(path, load, window, zoom_to))
        if not given[-1].events:
            raise InputError(f"{path}: has no events; there is nothing to distinguish")
    if plot is not None:
        require_picture(plot)
    if asked and not observer:
        option = "--modality" if "modalities" in asked else f"--{next(iter(asked))}"
        raise InputError(f"{option} is for --observer; add that, or leave it out")
    report, figure = (_observed if observer else _measured)(loaded, given, **asked)
    if plot is not None:
        from overview_dsp.offline.plots.saving import save_picture

        save_picture(figure(), plot)
    if as_json:
        print_json({**report.to_json(), "warnings": report.warnings()})
        return
    click.echo(report.table())
    for line in report.warnings():
        click.echo(f"note: {line}")


def _measured(preset: Preset, timelines: list[Timeline]) -> tuple[Felt, Callable[[], Figure]]:
    from overview_dsp.measure.arm import arm_report
    from overview_dsp.measure.pictures import plot_feel
    from overview_dsp.measure.report import feel_report
    from overview_dsp.offline.rendering.audition import pages

    announce_compile()
    measured = timelines or pages(preset)
    with progress_bar(f"measuring {preset.name}") as progress:
        first = feel_report(
            preset,
            measured,
            order=() if timelines else None,
            progress=lambda part: progress(part / 2),
        )
        arm = arm_report(preset, measured, progress=lambda part: progress(0.5 + part / 2))
    return Felt(first, arm), lambda: plot_feel(first)


class Felt:
    """How a preset feels: its kinds of events, and an arm beside a sweep."""

    def __init__(self, kinds: FeelReport, arm: ArmReport) -> None:
        """Both reports are of the same timelines."""
        self._kinds, self._arm = kinds, arm

    def to_json(self) -> dict[str, Any]:
        """Return the kinds, with the arm under a key of its own."""
        return {**self._kinds.to_json(), "arm": self._arm.to_json()}

    def table(self) -> str:
        """Return the kinds, then the arm beside the sweep."""
        return f"{self._kinds.table()}\n\n{self._arm.table()}"

    def warnings(self) -> list[str]:
        """Return which kinds are alike, where the order isn't kept, and what an arm misses."""
        return [*self._kinds.warnings(), *self._arm.warnings()]


def _observed(
    preset: Preset, timelines: list[Timeline], **asked: Any
) -> tuple[ObserverReport, Callable[[], Figure]]:
    from overview_dsp.measure.observer.observing import observe
    from overview_dsp.measure.pictures import plot_observer

    announce_compile("process_lanes")
    with progress_bar(f"observing {preset.name}") as progress:
        report = observe(preset, timelines, progress=progress, **asked)
    return report, lambda: plot_observer(report)


@click.command(
    epilog="Example: overview presets tune my-match match.json --target 'goal>red_card>foul'"
)
@click.argument("preset")
@click.argument("timelines", metavar="[TIMELINE]...", nargs=-1)
@click.option("--target", help="Kinds from the strongest down, joined by >.")
@click.option("--apart", is_flag=True, help="Set all kinds apart, a step in any way they are felt.")
@click.option("--seed", default=0, show_default=True, help="Of the search.")
@click.option("-o", "--out", help="The file.  [default: PRESET-tuned.toml here]")
@window_options
@timeline_options
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def tune(
    preset: str,
    timelines: tuple[str, ...],
    target: str | None,
    apart: bool,
    seed: int,
    out: str | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    load: dict[str, Any],
    as_json: bool,
) -> None:
    """Move heights and widths until each kind of the target is two steps above the next.

    On TIMELINEs, measured where the events lie; it says what can't be reached there.
    Without, on a made-up timeline of the target's kinds alone.

    With --apart until no two kinds of PRESET feel alike; a target's kinds are then a step above the
    next. The file keeps what PRESET's says besides: what it extends, its variables and comments.
    """
    from overview_dsp.design.presets.library import load_preset
    from overview_dsp.design.presets.retuning import save_retuned
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.measure.tuning import tune as tune_kinds

    if target is None and not apart:
        raise InputError("give --target KIND>KIND, --apart, or both")
    if timelines and (apart or target is None):
        raise InputError("--apart is for a preset's kinds alone; leave it or the timelines out")
    loaded = load_preset(preset)
    order = [] if target is None else [name.strip() for name in target.split(">")]
    given = [open_part(path, load, window, zoom_to) for path in timelines]
    announce_compile()
    with progress_bar(f"tuning {loaded.name}") as progress:
        found = tune_kinds(loaded, order, given or None, apart, seed, progress)
    names = list(loaded.kinds) if apart else order
    path = Path(out) if out is not None else Path(f"{loaded.name}-tuned{SUFFIX}")
    moved = {name: _moved(loaded.kinds[name], found.preset.kinds[name]) for name in names}
    _, made = save_retuned(preset, {name: keys for name, keys in moved.items() if keys}, path)
    if as_json:
        print_json(
            {
                "file": str(path),
                "least_steps": round(found.least_steps, 2),
                "reached": found.reached,
                "unreached": list(found.unreached),
                "kinds": {
                    name: {
                        "height": made.kinds[name].height,
                        "width_percent": made.kinds[name].width_percent,
                        "width_ms": made.kinds[name].width_ms,
                    }
                    for name in names
                },
            }
        )
        return
    for name in names:
        before, after = loaded.kinds[name], made.kinds[name]
        click.echo(
            f"{name}: height {before.height:g} to {after.height:.4g}, {_widths(before, after)}"
        )
    reached = "reached" if found.reached else "not reached: use fewer kinds, or allow more height"
    wanted = "from any other at every speed; one" if apart else "above the next at every speed; two"
    click.echo(f"{path}: each at least {found.least_steps:.2f} steps {wanted} {reached}")
    for line in found.unreached:
        click.echo(f"not reached: {line}")


def _moved(before: EventKind, after: EventKind) -> dict[str, float]:
    """What of a kind was moved."""
    keys = ("height", "width_percent", "width_ms")
    return {key: getattr(after, key) for key in keys if getattr(after, key) != getattr(before, key)}


def _widths(before: EventKind, after: EventKind) -> str:
    if before.width_percent is not None and after.width_percent is not None:
        return f"width {before.width_percent:g} to {after.width_percent:.3g} %"
    return f"width {before.width_ms:g} to {after.width_ms:.4g} ms"
