"""The command `overview render`, and the option --transcript."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, print_json, progress_bar, read_gesture, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.output import ACTUATOR, drive_line, load_calibrated
from overview_dsp.cli.options.reading import PresetChoice, Reading, Window, open_window, preset_for
from overview_dsp.design.gestures.spec import DEFAULT, FORMS
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable

if TYPE_CHECKING:
    from overview_dsp.offline.rendering.event_log import PassedEvent


TERMINAL = "-"

GESTURE = option(default=DEFAULT, metavar="SPEC", help=FORMS + "; + joins gestures.")
TAIL = option(default="rest", metavar="S")
TRANSCRIPT = option("--transcript", metavar="FILE")


def require_transcripts(paths: Sequence[str]) -> None:
    """Check before long work that transcripts can be written; InputError otherwise."""
    from overview_dsp.offline.rendering.event_log import writer_of

    for path in paths:
        if path != TERMINAL:
            writer_of(path)
            require_writable(Path(path))


def write_transcripts(
    paths: Sequence[str], passed: Sequence[PassedEvent], as_json: bool
) -> dict[str, Any]:
    """Write or print the events; return their part of the JSON report."""
    from overview_dsp.offline.rendering.event_log import as_records, as_text, save_transcript

    files = [path for path in paths if path != TERMINAL]
    for path in files:
        save_transcript(passed, path)
        if not as_json:
            click.echo(f"{path}: transcript of {len(passed)} events")
    if TERMINAL in paths and not as_json:
        show(False, None, *as_text(passed).splitlines())
    if not paths:
        return {}
    return {"transcripts": files, "events": as_records(passed)}


@cli_command(
    "render match.json --gesture sweep:4 -o match.wav --trace match.npz",
    name="render",
    first="gesture output preset window zoom_to trace transcripts actuator sample_rate as_json",
)
def command(
    timeline: str,
    *,
    gesture: str = GESTURE,
    output: str = option(default="out.wav"),
    trace: str | None = option(),
    sample_rate: float = option(default=48_000.0),
    subtype: str | None = option(),
    seed: int = SEED,
    tail: str = TAIL,
    stems: bool = option(),
    measure_loudness: bool = option(),
    normalize: float | None = option(metavar="LUFS"),
    cue_points: bool = option(),
    transcripts: tuple[str, ...] = TRANSCRIPT,
    actuator: str | None = ACTUATOR,
    tactors: int = option(default=1, type=click.IntRange(1, 8)),
    as_json: bool = JSON,
    choice: PresetChoice,
    reading: Reading,
    window: Window,
) -> None:
    """Render a gesture over TIMELINE to a sound file: left = clicks, right = tactor.

    TIMELINE is any supported file, detected by content, or the bundled match
    (world-cup-final-2018).
    """
    from overview_dsp.files.sound import add_cues
    from overview_dsp.offline.rendering.event_log import passed_events
    from overview_dsp.offline.rendering.schedule import tail_of
    from overview_dsp.offline.rendering.stems import stem_paths
    from overview_dsp.signal.actuators.stage import protection_json
    from overview_dsp.units import clock_text, gain_to_db

    require_transcripts(transcripts)
    if cue_points and Path(output).suffix.lower() != ".wav":
        raise InputError(f"{output}: --cue-points needs a .wav file; use --transcript for others")
    data = open_window(timeline, reading, window)
    chosen = choice.load(preset_for(data, choice.preset))
    movement = read_gesture(gesture)
    chosen_tail = tail_of(tail)
    driven = load_calibrated(actuator)
    announce_compile(*(("drive_block",) if driven else ()))
    with progress_bar(f"rendering {Path(output).name}") as progress:
        done = ov.render_to_file(
            data,
            chosen,
            movement,
            output,
            sample_rate,
            seed,
            tail=chosen_tail,
            subtype=subtype,
            trace_path=trace,
            progress=progress,
            actuator=driven,
            stems=stems,
            loudness=measure_loudness,
            normalize=normalize,
            tactors=tactors,
        )
    passed = passed_events(done.passed, done.engine.timeline) if done.passed is not None else []
    if cue_points:
        add_cues(Path(output), [(round(one.time_s * sample_rate), one.text) for one in passed])
    stem_names = [str(one) for one in stem_paths(Path(output))] if stems else []
    missed = [done.engine.timeline.events[i] for i in done.unreached]
    click_db, tactor_db = (round(gain_to_db(peak), 1) if peak else None for peak in done.peaks)
    if as_json:
        print_json(
            {
                "file": output,
                "trace": trace,
                "title": data.title,
                "preset": chosen.name,
                "duration_s": done.duration_s,
                "strikes": done.strikes,
                "left_out": dict(done.engine.surface.omitted_events),
                "unreached": [
                    {"time_s": event.time_s, "kind": event.kind, "label": event.label}
                    for event in missed
                ],
                "peak_click_dbfs": click_db,
                "peak_tactor_dbfs": tactor_db,
                "format": done.note,
                "stems": stem_names,
                "click_lufs": done.lufs if done.lufs is None else round(done.lufs, 1),
                "click_gain_db": round(done.gain_db, 1),
                "click_limited_db": round(done.limited_db, 1),
                "cues": len(passed) if cue_points else 0,
                **write_transcripts(transcripts, passed, as_json),
                "actuator": protection_json(driven, done.protected),
            }
        )
        return
    click_peak, tactor_peak = (
        "silent" if db is None else f"{db:.1f} dBFS" for db in (click_db, tactor_db)
    )
    click.echo(
        f"{output}: {chosen.name}, {clock_text(done.duration_s)}, {done.strikes} strikes, "
        f"peaks {click_peak} click and {tactor_peak} tactor, {done.note}"
    )
    if stem_names:
        click.echo(
            f"{', '.join(stem_names)}: click, tactor, and cursor, touching, torque, envelope"
        )
    if measure_loudness or normalize is not None:
        click.echo(_loudness(done, normalize))
    if driven and done.protected:
        click.echo(drive_line(driven, done.protected))
    for kind, count in done.engine.surface.omitted_events.items():
        click.echo(
            f"omitted: {count} {kind}, too dense to be felt one by one; use a shorter window"
        )
    if trace:
        click.echo(f"{trace}: disk motion and torque, one row per frame")
    if missed:
        named = [f"{event.kind} {data.moment_text(event.time_s)}" for event in missed[:MAX_NAMED]]
        more = f" and {len(missed) - MAX_NAMED} more" if len(missed) > MAX_NAMED else ""
        click.echo(
            f"not reached: {', '.join(named)}{more}; the disk was too slow: hold it longer, "
            "render a longer tail, or move more slowly"
        )
    write_transcripts(transcripts, passed, as_json)


MAX_NAMED = 6  # most events that a message names; the JSON report has all


def _loudness(done: ov.RenderFileResult, target: float | None) -> str:
    if done.lufs is None:
        return "click: silent"
    text = f"click: {done.lufs:.1f} LUFS"
    if target is not None:
        text += f", gain {done.gain_db:+.1f} dB"
    if done.limited_db >= 0.05:
        text += f", peaks limited by up to {done.limited_db:.1f} dB"
    # further below the target than the gating of the measurement can explain
    if target is not None and done.lufs < target - 0.5:
        text += "; the limiter (true peaks of -1 dBFS) allows no more"
    return text
