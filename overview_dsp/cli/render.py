"""`overview render`: a gesture over a timeline, into a sound file.

The option --transcript: what happened when, into files or onto the terminal.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, print_json, progress_bar, read_gesture
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.output import ACTUATOR, calibrated, drive_line
from overview_dsp.cli.options.reading import (
    PresetChoice,
    Reading,
    Window,
    open_window,
    preset_for,
)
from overview_dsp.design.gestures.spec import DEFAULT, FORMS
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable

if TYPE_CHECKING:
    from overview_dsp.offline.rendering.event_log import PassedEvent


TERMINAL = "-"

GESTURE = option(FORMS + "; + joins gestures.", default=DEFAULT, metavar="SPEC")
TAIL = option("Time after the gesture: rest, none, or seconds.", default="rest", metavar="S")
TRANSCRIPT = option(
    "Events with their times: .txt, .json, .vtt, .audacity.txt, .csv (REAPER), or - to print "
    "them. May be repeated.",
    "--transcript",
    metavar="FILE",
)


def require_transcripts(paths: Sequence[str]) -> None:
    """InputError, before any work, for a file that no transcript can be written to."""
    from overview_dsp.offline.rendering.event_log import writer_of

    for path in paths:
        if path != TERMINAL:
            writer_of(path)
            require_writable(Path(path))


def require_wav(path: str) -> None:
    """InputError if a sound file can't hold cue points."""
    if Path(path).suffix.lower() != ".wav":
        raise InputError(f"{path}: --cue-points is for .wav files; give a --transcript for others")


def write_transcripts(
    paths: Sequence[str], passed: Sequence[PassedEvent], as_json: bool
) -> dict[str, Any]:
    """Write or print what happened; what the JSON report says of it."""
    from overview_dsp.offline.rendering.event_log import as_records, as_text, save_transcript

    files = [path for path in paths if path != TERMINAL]
    for path in files:
        save_transcript(passed, path)
        if not as_json:
            click.echo(f"{path}: what happened when, {len(passed)} events")
    if TERMINAL in paths and not as_json:
        click.echo(as_text(passed), nl=False)
    if not paths:
        return {}
    return {"transcripts": files, "events": as_records(passed)}


@cli_command("render match.json --gesture sweep:4 -o match.wav --trace match.npz", name="render")
def command(
    timeline: str,
    *,
    gesture: str = GESTURE,
    output: str = option("WAV, FLAC, ... by suffix.", default="out.wav"),
    trace: str | None = option("Write disk motion and torque to a .npz or .csv file."),
    sample_rate: float = option("Hz, 1000 to 768000.", default=48_000.0),
    subtype: str | None = option("Sample format: PCM_16, PCM_24, FLOAT, ..."),
    seed: int = SEED,
    tail: str = TAIL,
    stems: bool = option("Also write click, tactor and the disk's curves alone."),
    measure_loudness: bool = option("Report click loudness (ITU-R BS.1770)."),
    normalize: float | None = option(
        "Bring the click to this loudness, such as -23.", metavar="LUFS"
    ),
    cue_points: bool = option("Write the events into the WAV as cue points."),
    transcripts: tuple[str, ...] = TRANSCRIPT,
    actuator: str | None = ACTUATOR,
    as_json: bool = JSON,
    choice: PresetChoice,
    reading: Reading,
    window: Window,
) -> None:
    """Play a gesture over TIMELINE into a sound file: left = clicks, right = tactor.

    TIMELINE is any supported file, detected by content, or the bundled match
    (world-cup-final-2018).
    """
    from overview_dsp.files.cue_points import add_cues
    from overview_dsp.offline.rendering.event_log import passed_events
    from overview_dsp.offline.rendering.schedule import tail_of
    from overview_dsp.offline.rendering.stems import stem_paths
    from overview_dsp.signal.actuators.stage import protection_json
    from overview_dsp.units import clock_text, gain_to_db

    require_transcripts(transcripts)
    if cue_points:
        require_wav(output)
    data = open_window(timeline, reading, window)
    chosen = choice.load(preset_for(data, choice.preset))
    movement = read_gesture(gesture)
    rest = tail_of(tail)
    driven = calibrated(actuator)
    announce_compile(*(("drive_block",) if driven else ()))
    with progress_bar(f"rendering {Path(output).name}") as progress:
        done = ov.render_to_file(
            data,
            chosen,
            movement,
            output,
            sample_rate,
            seed,
            tail=rest,
            subtype=subtype,
            trace_path=trace,
            progress=progress,
            actuator=driven,
            stems=stems,
            loudness=measure_loudness,
            normalize=normalize,
        )
    passed = passed_events(done.passed, done.engine.timeline) if done.passed is not None else []
    if cue_points:
        marked = [(round(one.time_s * sample_rate), one.text) for one in passed]
        add_cues(Path(output), marked)
    beside = [str(one) for one in stem_paths(Path(output))] if stems else []
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
                "stems": beside,
                "click_lufs": done.lufs if done.lufs is None else round(done.lufs, 1),
                "click_gain_db": round(done.gain_db, 1),
                "cues": len(passed) if cue_points else 0,
                **write_transcripts(transcripts, passed, as_json),
                "actuator": protection_json(driven, done.protected),
            }
        )
        return
    click.echo(
        f"{output}: {chosen.name}, {clock_text(done.duration_s)}, {done.strikes} strikes, "
        f"peaks {_level(click_db)} click and {_level(tactor_db)} tactor, {done.note}"
    )
    if beside:
        click.echo(f"{', '.join(beside)}: click, tactor, and cursor, touching, torque, envelope")
    if measure_loudness or normalize is not None:
        click.echo(_loudness(done.lufs, done.gain_db, normalize))
    if driven and done.protected:
        click.echo(drive_line(driven, done.protected))
    for kind, count in done.engine.surface.omitted_events.items():
        click.echo(
            f"left out: {count} {kind}, too dense to be felt one by one; use a shorter window"
        )
    if trace:
        click.echo(f"{trace}: what the disk did, one row a frame")
    if missed:
        named = [f"{event.kind} {data.moment_text(event.time_s)}" for event in missed[:NAMED]]
        more = f" and {len(missed) - NAMED} more" if len(missed) > NAMED else ""
        click.echo(
            f"not reached: {', '.join(named)}{more}; the disk did not arrive in time: "
            "hold on longer, render a longer tail, or move more slowly"
        )
    write_transcripts(transcripts, passed, as_json)


NAMED = 6
"""Events that were not reached, by name; the JSON has all."""


def _level(db: float | None) -> str:
    return "silent" if db is None else f"{db:.1f} dBFS"


def _loudness(lufs: float | None, gain_db: float, wanted: float | None) -> str:
    if lufs is None:
        return "click: silent"
    turned = f", turned by {gain_db:+.1f} dB" if wanted is not None else ""
    # less than asked for, beyond what the gates of loudness make of it
    short = wanted is not None and lufs < wanted - 0.5
    why = "; its highest sample is at -1 dBFS and allows no more" if short else ""
    return f"click: {lufs:.1f} LUFS{turned}{why}"
