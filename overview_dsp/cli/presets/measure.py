"""`overview presets`: audition, feel, tune: what a preset is like.

The options of an observer: what it gets, whose hands move, which random numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, print_json, progress_bar, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import (
    JSON,
    argument,
    cli_command,
    option,
    refuse_options,
)
from overview_dsp.cli.options.reading import Reading, Window, open_window
from overview_dsp.cli.presets.group import command
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import EventKind, Preset
    from overview_dsp.measure.arm import ArmReport
    from overview_dsp.measure.observer.report import ObserverReport
    from overview_dsp.measure.report import FeelReport


TIMELINES = argument(metavar="[TIMELINE]...")


@dataclass(frozen=True)
class Observer:
    """Options of an observer; the others are arguments of `measure.observe`."""

    heading: ClassVar[str] = "Observer"

    modality: tuple[str, ...] = option(
        "What an observer gets; may be repeated.  [default: all three]",
        type=click.Choice(["touch", "sound", "both"]),
    )
    movement: str | None = option(
        "An observer's strokes: steady (sweeps, a tap, the recoil), arm (releases early), "
        "all of these, or mixed (speeds up, hesitates, turns back).  [default: all]",
        type=click.Choice(["all", "steady", "arm", "mixed"]),
    )
    seed: int | None = option("Seed of the observer.  [default: 0]", type=click.IntRange(min=0))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `measure.observe` that were given."""
        given = {"modalities": self.modality or None, "movement": self.movement, "seed": self.seed}
        return {name: value for name, value in given.items() if value is not None}


@cli_command("presets audition heart -o heart.wav", group=command)
def audition(
    preset: str,
    *,
    output: str | None = option("The sound file.  [default: PRESET-audition.wav here]"),
    seed: int = SEED,
    as_json: bool = JSON,
) -> None:
    """Sweep over every kind of event of PRESET, a sound file, and a picture beside it.

    Left is what is heard, right what is felt.
    """
    from overview_dsp.measure.pictures import plot_gallery
    from overview_dsp.offline.plots.saving import save_figure
    from overview_dsp.offline.rendering.audition import audition as sound

    loaded = ov.load_preset(preset)
    path = Path(output) if output is not None else Path(f"{loaded.name}-audition.wav")
    announce_compile()
    result = sound(loaded, seed)
    result.save(path)
    pictures = save_figure(plot_gallery(result, loaded), path.with_suffix(""))
    report = {
        "file": str(path),
        "pictures": [str(picture) for picture in pictures],
        "kinds": [
            {"kind": event.kind, "time_s": round(event.time_s, 3)}
            for event in result.engine.timeline.events
        ],
    }
    show(as_json, report, f"{path}: {', '.join(loaded.kinds)}, out and back", pictures[0])


@cli_command("presets feel football match.json --plot feel.png", group=command)
def feel(
    preset: str,
    timelines: tuple[str, ...] = TIMELINES,
    *,
    plot: str | None = option("Also draw it, to a .png, .svg or .pdf file."),
    observer: bool = option(
        "Report which kinds an observer with human limits tells apart, and takes for another.",
        heading=Observer.heading,
    ),
    observing: Observer,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
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
    from overview_dsp.offline.plots.saving import require_picture

    loaded = ov.load_preset(preset)
    given = []
    for path in timelines:
        given.append(open_window(path, reading, window))
        if not given[-1].events:
            raise InputError(f"{path}: has no events; there is nothing to distinguish")
    if plot is not None:
        require_picture(plot)
    if not observer:
        refuse_options("is for --observer; add that, or leave it out", Observer)
    measured = _observed if observer else _measured
    report, figure = measured(loaded, given, **observing.arguments())
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


@cli_command("presets tune my-match match.json --order 'goal>red_card>foul'", group=command)
def tune(
    preset: str,
    timelines: tuple[str, ...] = TIMELINES,
    *,
    order: str | None = option("Kinds from the strongest down, joined by >."),
    separate: bool = option(
        "Separate all kinds, by one just noticeable step in any way they are felt."
    ),
    seed: int = option("Seed of the search.", default=0),
    output: str | None = option("The file.  [default: PRESET-tuned.toml here]"),
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Move heights and widths until each kind of the target is two steps above the next.

    On TIMELINEs, measured where the events lie; it says what can't be reached there.
    Without, on a made-up timeline of the target's kinds alone.

    With --separate until no two kinds of PRESET feel alike; a target's kinds are then a step above
    the next. The file keeps what else PRESET's says: what it extends, variables and comments.
    """
    from overview_dsp.design.presets.text_update import save_updated
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.measure.tuning import tune as tune_kinds

    if order is None and not separate:
        raise InputError("give --order KIND>KIND, --separate, or both")
    if timelines and (separate or order is None):
        raise InputError("--separate is for a preset's kinds alone; leave it or the timelines out")
    loaded = ov.load_preset(preset)
    target = [] if order is None else [name.strip() for name in order.split(">")]
    given = [open_window(path, reading, window) for path in timelines]
    announce_compile()
    with progress_bar(f"tuning {loaded.name}") as progress:
        found = tune_kinds(loaded, target, given or None, separate, seed, progress)
    names = list(loaded.kinds) if separate else target
    path = Path(output) if output is not None else Path(f"{loaded.name}-tuned{SUFFIX}")
    moved = {name: _moved(loaded.kinds[name], found.preset.kinds[name]) for name in names}
    _, made = save_updated(preset, {name: keys for name, keys in moved.items() if keys}, path)
    reached = "reached" if found.reached else "not reached: use fewer kinds, or allow more height"
    wanted = "from any other" if separate else "above the next"
    number = "one" if separate else "two"
    report = {
        "file": str(path),
        "least_jnds": round(found.least_jnds, 2),
        "reached": found.reached,
        "unreached": list(found.unreached),
        "kinds": {name: {key: getattr(made.kinds[name], key) for key in TUNED} for name in names},
    }
    show(
        as_json,
        report,
        *(_change(name, loaded.kinds[name], made.kinds[name]) for name in names),
        f"{path}: each at least {found.least_jnds:.2f} steps {wanted} at every speed; {number} "
        f"{reached}",
        *(f"not reached: {line}" for line in found.unreached),
    )


TUNED = ("height", "width_percent", "width_ms")


def _moved(before: EventKind, after: EventKind) -> dict[str, float]:
    """Return the values of a kind that were moved."""
    return {
        key: getattr(after, key) for key in TUNED if getattr(after, key) != getattr(before, key)
    }


def _change(name: str, before: EventKind, after: EventKind) -> str:
    """Return what was moved, as one line."""
    if before.width_percent is not None and after.width_percent is not None:
        width = f"{before.width_percent:g} to {after.width_percent:.3g} %"
    else:
        width = f"{before.width_ms:g} to {after.width_ms:.4g} ms"
    return f"{name}: height {before.height:g} to {after.height:.4g}, width {width}"
