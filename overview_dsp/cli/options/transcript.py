"""The option --transcript: what happened when, into files or onto the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from overview_dsp.offline.rendering.happened import Happening

TERMINAL = "-"

transcript_option = click.option(
    "--transcript",
    "transcripts",
    multiple=True,
    metavar="FILE",
    help="What happened when: .txt, .json, .vtt, .audacity.txt, .csv (REAPER), or - to print it. "
    "May be given several times.",
)


def require_transcripts(paths: Sequence[str]) -> None:
    """InputError, before any work, for a file that no transcript can be written to."""
    from overview_dsp.files.atomic import require_writable
    from overview_dsp.offline.rendering.happened import writer_of

    for path in paths:
        if path != TERMINAL:
            writer_of(path)
            require_writable(Path(path))


def require_wav(path: str) -> None:
    """InputError if a sound file can't hold cue points."""
    from overview_dsp.errors import InputError

    if Path(path).suffix.lower() != ".wav":
        raise InputError(f"{path}: --cues is for .wav files; give a --transcript for others")


def write_transcripts(
    paths: Sequence[str], passed: Sequence[Happening], as_json: bool
) -> dict[str, Any]:
    """Write or print what happened; what the JSON report says of it."""
    from overview_dsp.offline.rendering.happened import as_records, as_text, save_transcript

    files = [path for path in paths if path != TERMINAL]
    for path in files:
        save_transcript(passed, path)
        if not as_json:
            click.echo(f"{path}: what happened when, {len(passed)} events")
    if TERMINAL in paths and not as_json:
        click.echo(as_text(passed), nl=False)
    if not paths:
        return {}
    return {"transcripts": files, "happened": as_records(passed)}
