"""`overview export`: a gesture baked to haptic formats, or a timeline to a page or to C."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, print_json, progress_bar, read_gesture, show
from overview_dsp.cli.live_session import SEED
from overview_dsp.cli.options.declaring import JSON, argument, cli_command, option, refuse_options
from overview_dsp.cli.options.output import ACTUATOR, calibrated, drive_line
from overview_dsp.cli.options.reading import (
    PRESET_OPTION,
    Reading,
    Window,
    open_window,
    preset_for,
)
from overview_dsp.cli.render import (
    GESTURE,
    TAIL,
    TRANSCRIPT,
    require_transcripts,
    write_transcripts,
)
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.design.presets.model import Preset
    from overview_dsp.offline.export.clip import PerceptualError
    from overview_dsp.signal.actuators.model import Actuator

FORMAT_NAMES = ("ahap", "haptic", "hjif", "android", "wav4")
DRIVEN = "wav4"
"""The format of a gesture that an actuator is driven by."""

SITE, SOURCE = "web", "c"
"""The timeline itself, as a folder: for a browser, or for a C compiler."""

CLIP_OPTIONS = ("gesture", "points_per_second", "tail", "transcripts")
PAGE_OPTIONS = ("zoom_levels", "actuator", "base_url")

FIGURES = (
    "(median error of the felt level, and how much of the clip is within a step of 2.3 dB, strikes "
    "included)"
)

_SUFFIXES = {"android": ".json", "wav4": ".wav"}


@cli_command("export match.json --gesture sweep:4 --to ahap -o match.ahap", name="export")
def command(
    timelines: tuple[str, ...] = argument(metavar="TIMELINE...", required=True),
    *,
    preset: str | None = PRESET_OPTION,
    gesture: str = GESTURE,
    formats: tuple[str, ...] = option(
        "Format; may be repeated. web is a folder with a page, c with C source.",
        "--to",
        required=True,
        type=click.Choice((*FORMAT_NAMES, SITE, SOURCE)),
    ),
    output: str | None = option(
        "Of one format: its file or folder. Of several: a name without suffix."
    ),
    points_per_second: float = option(
        "Amplitude points per second.", default=50.0, type=click.FloatRange(1.0, 1000.0)
    ),
    tail: str = TAIL,
    seed: int = SEED,
    zoom_levels: int = option(
        "Of a page: how often it can zoom in, by 3 each; of a match 0.4, 1.5, 5, 10, 23, 60 MB.",
        default=3,
        type=click.IntRange(0, 5),
    ),
    base_url: str | None = option(
        "Of a page: where its folder will be (https://example.org/match/), for its picture "
        "where the link is shared."
    ),
    transcripts: tuple[str, ...] = TRANSCRIPT,
    actuator: str | None = ACTUATOR,
    as_json: bool = JSON,
    reading: Reading,
    window: Window,
) -> None:
    """Bake a gesture over TIMELINE to a haptic clip, and say how near it is to what was felt.

    --to web writes no gesture but a folder for any web host, a page to feel TIMELINE on; of several
    timelines a page that shows each and leads to its own. --to c writes a folder to compile:
    TIMELINE for programs and instruments without Python, with the bits of `render`.

    An actuator is driven by wav4 and web alone: the other formats hold how strong it is to feel,
    and the device that plays them makes its drive.
    """
    from overview_dsp.offline.rendering.event_log import passed_events
    from overview_dsp.offline.rendering.schedule import tail_of
    from overview_dsp.signal.actuators.stage import protection_json

    if len(timelines) > 1 and set(formats) != {SITE}:
        raise InputError(
            f"{len(timelines)} timelines ({', '.join(timelines)}): only --to {SITE} takes several; "
            f"give one"
        )
    shown = []
    for timeline in timelines:
        data = open_window(timeline, reading, window)
        chosen = ov.load_preset(preset_for(data, preset))
        shown.append((data, chosen))
    if SOURCE in formats:
        _require_alone(SOURCE, formats, *CLIP_OPTIONS, *PAGE_OPTIONS)
        _source(data, chosen, output or "voice", seed, as_json)
        return
    if SITE in formats:
        _require_alone(SITE, formats, *CLIP_OPTIONS)
        driven, url = calibrated(actuator), _base_url(base_url)
        _site(shown, output or "site", zoom_levels, seed, driven, url, as_json)
        return
    if base_url is not None:
        raise InputError(f"--base-url is for --to {SITE}: a clip has no page; leave it out")
    movement, rest = read_gesture(gesture), tail_of(tail)
    driven = calibrated(actuator)
    if driven is not None and DRIVEN not in formats:
        raise InputError(
            f"--actuator {actuator} changes {DRIVEN} alone, which is not among the formats: add "
            f"--to {DRIVEN}, or leave it out"
        )
    places = {to: _place(output, to, len(set(formats)) > 1) for to in formats}
    for place in places.values():
        require_writable(place)
    require_transcripts(transcripts)
    announce_compile(*(("drive_block",) if driven else ()))
    with progress_bar("rendering") as progress:
        result = ov.render(data, chosen, movement, seed=seed, tail=rest, actuator=driven)
        progress(1.0)
    reports: list[dict[str, Any]] = []
    for to, place in places.items():
        done = ov.export.export(result, to, place, points_per_second)
        report: dict[str, Any] = {"format": to, "files": [str(path) for path in done.files]}
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
    told = write_transcripts(transcripts, passed_events(result.strikes, data), as_json)
    if as_json:
        print_json([*reports, told] if told else reports)
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
            + "; ".join(
                f"on {name}: {on['median_error_db']:.1f} dB, {on['within_step_percent']:.0f} %"
                for name, on in report["players"].items()
            )
        )
    if any("players" in report for report in reports):
        click.echo(FIGURES)


def _error(error: PerceptualError) -> dict[str, float]:
    return {
        "median_error_db": round(error.median_db, 2),
        "largest_error_db": round(error.largest_db, 2),
        "within_step_percent": round(error.within_percent, 1),
    }


def _require_alone(to: str, formats: tuple[str, ...], *refused: str) -> None:
    """Refuse what a folder of the timeline itself would ignore."""
    if set(formats) != {to}:
        raise InputError(f"--to {to} writes a folder, not a clip: give it in a call of its own")
    refuse_options(f"does not apply to --to {to}; remove it", *refused)


def _source(data: Timeline, preset: Preset, out: str, seed: int, as_json: bool) -> None:
    """Write the C folder and say how to try it."""
    files = [str(path) for path in ov.export.export_c(data, preset, out, seed=seed)]
    try_it = f"to try it: make -C {out} && {out}/example {files[-1]} sweep.wav"
    show(as_json, [{"format": SOURCE, "files": files}], ", ".join(files), try_it)


def _base_url(given: str | None) -> str | None:
    """A folder's address, with a slash at its end."""
    from urllib.parse import urlsplit

    if given is None:
        return None
    try:
        parts = urlsplit(given)
        right = parts.scheme in ("https", "http") and bool(parts.hostname)
    except ValueError:
        right = False
    if not right or parts.query or parts.fragment or re.search(r"\s", given):
        raise InputError(
            f"--base-url {given!r} is no address of a folder; one is https://example.org/match/"
        )
    return given.rstrip("/") + "/"


def _site(
    shown: list[tuple[Timeline, Preset]],
    out: str,
    zooms: int,
    seed: int,
    actuator: Actuator | None,
    address: str | None,
    as_json: bool,
) -> None:
    """Write the folder and say how to open it."""
    from overview_dsp.web.gallery import write_gallery
    from overview_dsp.web.static_site import write_site

    with progress_bar("writing the page") as progress:
        given: dict[str, Any] = {"levels": zooms, "seed": seed, "actuator": actuator}
        given |= {"address": address, "progress": progress}
        if len(shown) > 1:
            size = write_gallery(shown, out, **given)
        else:
            size = write_site(*shown[0], out, **given)
    line = (
        f"{out}: {size / 1e6:.1f} MB for any web host (phones give motion to https pages only); "
        f"to try it here: python -m http.server -b 127.0.0.1 -d {out}, then http://127.0.0.1:8000"
    )
    show(as_json, [{"format": SITE, "files": [out], "bytes": size}], line)


def _place(out: str | None, to: str, several: bool) -> Path:
    suffix = _SUFFIXES.get(to, f".{to}")
    if out is None:
        return Path(f"out{suffix}")
    if several:
        return Path(out).with_name(Path(out).name + suffix)
    return Path(out)
