"""The commands `overview presets` audition, feel and tune."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, progress_bar, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, argument, cli_command, option, refuse_options
from overview_dsp.cli.options.output import DEVICE
from overview_dsp.cli.options.reading import Reading, Window, open_window
from overview_dsp.cli.presets.inspect import command
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import Preset
    from overview_dsp.measure.report_base import Report


TIMELINES = argument(metavar="[TIMELINE]...")


@dataclass(frozen=True)
class Observer:
    """Options of a simulated observer."""

    heading: ClassVar[str] = "Observer"

    modality: tuple[str, ...] = option(type=click.Choice(["touch", "sound", "both"]))
    movement: str | None = option(type=click.Choice(["all", "steady", "arm", "mixed"]))
    seed: int | None = option(type=click.IntRange(min=0))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `measure.observe`, without unset ones."""
        options = {
            "modalities": self.modality or None,
            "movement": self.movement,
            "seed": self.seed,
        }
        return {name: value for name, value in options.items() if value is not None}


@dataclass(frozen=True)
class Through:
    """Options of an audition through another player."""

    heading: ClassVar[str] = "Through a player"

    player: str | None = option(type=click.Choice(["ahap", "haptic", "hjif", "android"]))
    blind_trials: int | None = option(type=click.IntRange(1, 200), metavar="TRIALS")
    device: str | None = DEVICE


@cli_command("presets audition heart --player android -o heart.wav", group=command)
def audition(
    preset: str,
    *,
    output: str | None = option(),
    seed: int = SEED,
    as_json: bool = JSON,
    through: Through,
) -> None:
    """Render a sweep over every event kind of PRESET, and draw it.

    Left has the clicks, right the tactor signal; with --player both have the vibration, first the
    original, then the player's. The picture is written beside the sound file.
    """
    from overview_dsp.cli.presets import through_player
    from overview_dsp.files.sound import save_sound
    from overview_dsp.measure.pictures import audition as sound
    from overview_dsp.measure.pictures import plot_gallery
    from overview_dsp.offline.plots.style import save_figure

    if through.player is None:
        refuse_options("needs a --player", "blind_trials", "device")
    loaded = ov.load_preset(preset)
    path = Path(output) if output is not None else Path(f"{loaded.name}-audition.wav")
    announce_compile()
    result = sound(loaded, seed)
    if through.player is None:
        result.save(path)
    else:
        pair = through_player.original_and_played(result, through.player)
        save_sound(path, through_player.in_turn(pair, result.sample_rate), result.sample_rate)
    pictures = save_figure(plot_gallery(result, loaded), path.with_suffix(""))
    report: dict[str, Any] = {
        "file": str(path),
        "pictures": [str(picture) for picture in pictures],
        "kinds": [
            {"kind": event.kind, "time_s": round(event.time_s, 3)}
            for event in result.engine.timeline.events
        ],
    }
    line = f"{path}: {', '.join(loaded.kinds)}, out and back"
    if through.player is not None:
        begins_s = round(len(result.samples) / result.sample_rate + through_player.PAUSE_S, 6)
        report |= {"player": through.player, "player_from_s": begins_s}
        line += f"; from {begins_s:g} s as a player of {through.player} plays it"
    if through.blind_trials is not None:
        named = path.with_suffix(time.strftime(".blind-%Y%m%d-%H%M%S.csv"))
        answers = through_player.compare_blind(
            pair, result.sample_rate, through.device, through.blind_trials, named
        )
        report |= {"hits": answers.hits, "trials": answers.trials}
        line += f"\n{answers.result_text}"
    show(as_json, report, line, pictures[0])


@cli_command(
    "presets feel football match.json --plot feel.png",
    group=command,
    first="plot observer modality movement window zoom_to select as_json",
)
def feel(
    preset: str,
    timelines: tuple[str, ...] = TIMELINES,
    *,
    plot: str | None = option(),
    observer: bool = option(heading=Observer.heading),
    observing: Observer,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Measure how strong and how distinct the event kinds of PRESET feel, at several speeds.

    Without TIMELINE, the report uses an artificial timeline with every kind. It names kinds that
    can't be distinguished, that are masked or merged, and possible changes.

    With TIMELINEs, it measures each event in context: medians and ranges by kind, the order of
    importance, and missed, masked and confused events.

    The report also simulates a human arm, which accelerates, brakes and releases early: the lag of
    the disk, the events it never reaches, scrubbing and taps.

    --observer simulates which kinds a user distinguishes by touch, by sound and by both. The
    observer learns on random timelines. Its test uses other random timelines and every TIMELINE.
    """
    from overview_dsp.offline.plots.style import require_picture, save_picture

    loaded = ov.load_preset(preset)
    loaded_timelines = []
    for path in timelines:
        loaded_timelines.append(open_window(path, reading, window))
        if not loaded_timelines[-1].events:
            raise InputError(f"{path}: has no events to distinguish")
    if plot is not None:
        require_picture(plot)
    if not observer:
        refuse_options("needs --observer; add it, or remove the option", Observer)
    measured = _observed if observer else _measured
    reports, figure = measured(loaded, loaded_timelines, **observing.arguments())
    if plot is not None:
        save_picture(figure(), plot)
    warnings = [line for report in reports for line in report.warnings()]
    data = reports[0].to_json()
    if len(reports) > 1:
        data["arm"] = reports[1].to_json()
    tables = "\n\n".join(report.table() for report in reports)
    show(as_json, {**data, "warnings": warnings}, tables, *(f"note: {line}" for line in warnings))


def _measured(
    preset: Preset, timelines: list[Timeline]
) -> tuple[list[Report], Callable[[], Figure]]:
    from overview_dsp.measure.arm import arm_report
    from overview_dsp.measure.pictures import pages, plot_feel
    from overview_dsp.measure.report import feel_report

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
    return [first, arm], lambda: plot_feel(first)


def _observed(
    preset: Preset, timelines: list[Timeline], **options: Any
) -> tuple[list[Report], Callable[[], Figure]]:
    from overview_dsp.measure.observer.observing import observe
    from overview_dsp.measure.pictures import plot_observer

    announce_compile("process_lanes")
    with progress_bar(f"observing {preset.name}") as progress:
        report = observe(preset, timelines, progress=progress, **options)
    return [report], lambda: plot_observer(report)


@cli_command("presets tune my-match match.json --order 'goal>red_card>foul'", group=command)
def tune(
    preset: str,
    timelines: tuple[str, ...] = TIMELINES,
    *,
    order: str | None = option(),
    separate: bool = option(),
    seed: int = option(default=0),
    output: str | None = option(),
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Tune heights and widths until each kind in --order is two JNDs stronger than the next.

    With TIMELINEs, the kinds are measured in context; without, on an artificial timeline. The
    result is never worse than PRESET, on timelines held out of the search too.
    With --separate, no two kinds of PRESET feel the same, and each kind in --order is one JND
    stronger than the next. The file keeps everything else in PRESET: base, variables and comments.
    """
    from overview_dsp.design.presets.text_update import changes_between, save_updated
    from overview_dsp.files.toml import SUFFIX
    from overview_dsp.measure.tuning import tune as tune_kinds

    if order is None and not separate:
        raise InputError("no target; add --order KIND>KIND, --separate, or both")
    if timelines and (separate or order is None):
        raise InputError("--separate doesn't apply to TIMELINEs; remove either")
    loaded = ov.load_preset(preset)
    target = [] if order is None else [name.strip() for name in order.split(">")]
    measured = [open_window(path, reading, window) for path in timelines]
    announce_compile()
    with progress_bar(f"tuning {loaded.name}") as progress:
        found = tune_kinds(loaded, target, measured or None, separate, seed, progress)
    names = list(loaded.kinds) if separate else target
    path = Path(output) if output is not None else Path(f"{loaded.name}-tuned{SUFFIX}")
    _, made = save_updated(preset, changes_between(loaded, found.preset), path)
    reached = "is reached" if found.reached else "isn't: use fewer kinds"
    relation = "from any other" if separate else "above the next"
    number = 1 if separate else 2
    report = {
        "file": str(path),
        "least_jnds": round(found.least_jnds, 2),
        "reached": found.reached,
        "unreached": list(found.unreached),
        "missing_jnds": round(found.missing_jnds, 2),
        "missing_before": round(found.missing_before, 2),
        "kinds": {name: {key: getattr(made.kinds[name], key) for key in TUNABLE} for name in names},
    }
    show(
        as_json,
        report,
        *(
            f"{one.id}: {one.first:g} to {one.second:g} {one.unit}"
            for one in ov.presets.differences(loaded, made)
        ),
        f"{path}: each at least {found.least_jnds:.2f} JNDs {relation} in every stroke; the "
        f"target of {number} {reached}",
        f"missing, on held-out timelines too: {found.missing_jnds:.2f} JNDs, "
        f"{found.missing_before:.2f} before",
        *(f"not reached: {line}" for line in found.unreached),
    )


TUNABLE = ("height", "width_percent", "width_ms")
