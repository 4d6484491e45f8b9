"""The command `overview export`: haptic clips, a page or C source."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import overview_dsp as ov
from overview_dsp.cli import render
from overview_dsp.cli.common import announce_compile, print_json, progress_bar, read_gesture, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, argument, cli_command, option, refuse_options
from overview_dsp.cli.options.output import ACTUATOR, drive_line, load_calibrated
from overview_dsp.cli.options.reading import PRESET_OPTION, Reading, Window, open_window, preset_for
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import Preset
    from overview_dsp.offline.export.clip import PerceptualError

FORMAT_NAMES = ("ahap", "haptic", "hjif", "android", "wav4")
DRIVEN = "wav4"  # format that an actuator profile changes
SITE, SOURCE, BOARD = "web", "c", "board"  # formats of a timeline in a folder
CLIP_OPTIONS = ("gesture", "points_per_second", "tail", "transcripts")
PAGE_OPTIONS = ("zoom_levels", "actuator", "base_url")

ERROR_NOTE = (
    "(median error of the perceived level; part of the felt time with an error below 2.3 dB; both "
    "with strikes; the event with the largest error)"
)

_SUFFIXES = {"android": ".json", "wav4": ".wav"}


@cli_command(
    "export match.json --gesture sweep:4 --to ahap -o match.ahap",
    name="export",
    first="formats output gesture preset window zoom_to points_per_second actuator as_json",
)
def command(
    timelines: tuple[str, ...] = argument(metavar="TIMELINE...", required=True),
    *,
    preset: str | None = PRESET_OPTION,
    gesture: str = render.GESTURE,
    formats: tuple[str, ...] = option(
        "--to", required=True, type=click.Choice((*FORMAT_NAMES, SITE, SOURCE, BOARD))
    ),
    output: str | None = option(),
    points_per_second: float = option(default=50.0, type=click.FloatRange(1.0, 1000.0)),
    tail: str = render.TAIL,
    seed: int = SEED,
    zoom_levels: int | None = option(type=click.IntRange(0, 5)),
    base_url: str | None = option(),
    transcripts: tuple[str, ...] = render.TRANSCRIPT,
    actuator: str | None = ACTUATOR,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Export a gesture over TIMELINE as a haptic clip, and report its perceptual error.

    --to web writes a page on which TIMELINE is played, in a folder for any web host. Several
    timelines get an overview page. --to c writes C source that plays TIMELINE without Python, with
    the samples of overview render. --to board writes sketches with which a Teensy 4 or an ESP32-S3
    plays TIMELINE without a computer.

    Only wav4 and web depend on --actuator. The other formats store perceived levels, which the
    playing device converts to its own drive.
    """
    from overview_dsp.offline.rendering.event_log import passed_events
    from overview_dsp.offline.rendering.schedule import tail_of
    from overview_dsp.signal.actuators.stage import protection_json

    if len(timelines) > 1 and set(formats) != {SITE}:
        raise InputError(
            f"{len(timelines)} timelines ({', '.join(timelines)}); only --to {SITE} allows several"
        )
    loaded = []
    for timeline in timelines:
        data = open_window(timeline, reading, window)
        chosen = ov.load_preset(preset_for(data, preset))
        loaded.append((data, chosen))
    for to, name in ((SOURCE, "voice"), (BOARD, "board")):
        if to in formats:
            _require_alone(to, formats, *CLIP_OPTIONS, *PAGE_OPTIONS)
            _source(to, data, chosen, output or name, seed, as_json)
            return
    if SITE in formats:
        _require_alone(SITE, formats, *CLIP_OPTIONS)
        options: dict[str, Any] = {"levels": zoom_levels, "seed": seed}
        options |= {"actuator": load_calibrated(actuator), "address": _base_url(base_url)}
        _site(loaded, output or "site", options, as_json)
        return
    if base_url is not None:
        raise InputError(f"--base-url does not apply to clips; remove it, or use --to {SITE}")
    movement, chosen_tail = read_gesture(gesture), tail_of(tail)
    driven = load_calibrated(actuator)
    if driven is not None and DRIVEN not in formats:
        raise InputError(
            f"--actuator {actuator} applies only to {DRIVEN}; add --to {DRIVEN}, or remove it"
        )
    paths = {to: _output_path(output, to, len(set(formats)) > 1) for to in formats}
    for path in paths.values():
        require_writable(path)
    render.require_transcripts(transcripts)
    announce_compile(*(("drive_block",) if driven else ()))
    with progress_bar("rendering") as progress:
        result = ov.render(data, chosen, movement, seed=seed, tail=chosen_tail, actuator=driven)
        progress(1.0)
    reports: list[dict[str, Any]] = []
    for to, path in paths.items():
        done = ov.export.export(result, to, path, points_per_second)
        report: dict[str, Any] = {"format": to, "files": [str(file) for file in done.files]}
        if done.error is not None:
            report |= {
                "points": done.points,
                "transients": done.transients,
                **_error(done.error),
                "players": {name: _error(error) for name, error in done.players.items()},
            }
        else:
            report["actuator"] = protection_json(driven, result.protected)
        reports.append(report)
    log = render.write_transcripts(transcripts, passed_events(result.strikes, data), as_json)
    if as_json:
        print_json([*reports, log] if log else reports)
        return
    for report in reports:
        files = " and ".join(report["files"])
        if "points" not in report:
            click.echo(f"{files}: four channels, clicks on 1 and 2, vibration on 3 and 4")
            if driven and result.protected:
                click.echo(drive_line(driven, result.protected))
            continue
        click.echo(
            f"{files}: {report['points']} points, {report['transients']} strikes; "
            + "; ".join(f"on {name}: {_error_text(on)}" for name, on in report["players"].items())
        )
    if any("players" in report for report in reports):
        click.echo(ERROR_NOTE)


def _error_text(on: dict[str, Any]) -> str:
    worst = on["worst_event"]
    event = f" ({worst['kind']} at {worst['time_s']} s: {worst['error_db']} dB)" if worst else ""
    return f"{on['median_error_db']:.1f} dB, {on['within_step_percent']:.0f} %{event}"


def _error(error: PerceptualError) -> dict[str, Any]:
    worst, worst_db = error.worst_event, round(error.worst_db, 1)
    return {
        "worst_event": worst
        and {"kind": worst.kind, "time_s": round(worst.time_s, 2), "error_db": worst_db},
        "median_error_db": round(error.median_db, 2),
        "largest_error_db": round(error.largest_db, 2),
        "within_step_percent": round(error.within_percent, 1),
    }


def _require_alone(to: str, formats: tuple[str, ...], *refused: str) -> None:
    """Refuse other formats and options beside a folder format."""
    if set(formats) != {to}:
        raise InputError(f"--to {to} writes a folder, not a clip; use it without other formats")
    refuse_options(f"does not apply to --to {to}; remove it", *refused)


def _source(to: str, data: Timeline, preset: Preset, out: str, seed: int, as_json: bool) -> None:
    """Write the folder of C source or of sketches, and print how to try it."""
    write = ov.export.export_c if to == SOURCE else ov.export.export_board
    files = [str(path) for path in write(data, preset, out, seed=seed)]
    try_it = f"try it: make -C {out} && {out}/example {files[-1]} sweep.wav"
    if to == BOARD:
        try_it = f"wiring: {files[0]}; upload a sketch with the Arduino IDE or PlatformIO"
    show(as_json, [{"format": to, "files": files}], ", ".join(files), try_it)


def _base_url(text: str | None) -> str | None:
    """Check the URL of a folder; return it with a slash at its end."""
    from urllib.parse import urlsplit

    if text is None:
        return None
    try:
        parts = urlsplit(text)
        valid = parts.scheme in ("https", "http") and bool(parts.hostname)
    except ValueError:
        valid = False
    if not valid or parts.query or parts.fragment or re.search(r"\s", text):
        raise InputError(
            f"--base-url is {text!r}; must be the URL of a folder, such as https://example.org/match/"
        )
    return text.rstrip("/") + "/"


def _site(
    timelines: list[tuple[Timeline, Preset]], out: str, options: dict[str, Any], as_json: bool
) -> None:
    """Write the folder and print how to open it."""
    from overview_dsp.web.static_site import write_gallery, write_site

    with progress_bar("writing the page") as progress:
        options["progress"] = progress
        if len(timelines) > 1:
            size = write_gallery(timelines, out, **options)
        else:
            size = write_site(*timelines[0], out, **options)
    line = (
        f"{out}: {size / 1e6:.1f} MB for any web host (phones need https for motion); "
        f"try it here: python -m http.server -b 127.0.0.1 -d {out}, then http://127.0.0.1:8000"
    )
    show(as_json, [{"format": SITE, "files": [out], "bytes": size}], line)


def _output_path(out: str | None, to: str, several: bool) -> Path:
    suffix = _SUFFIXES.get(to, f".{to}")
    if out is None:
        return Path(f"out{suffix}")
    if several:
        return Path(out).with_name(Path(out).name + suffix)
    return Path(out)
