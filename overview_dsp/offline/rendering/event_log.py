"""What passed_events when: the events a gesture passed, as text, JSON, labels and subtitles.

A render in words, for who can't hear or feel it: which events were passed, and how hard.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import whole_file
from overview_dsp.signal.engine.memory_reader import Strikes

STRONG_DB, MEDIUM_DB = 6.0, 18.0
"""Within so much of the strongest an event counts as strong, as medium; weak below."""

SHOWN_S = 1.5
"""A subtitle stays so long, or until the next one."""


@dataclass(frozen=True)
class PassedEvent:
    """An event that was passed.

    Attributes
    ----------
    time_s : float
        When it was struck, s from the beginning of the gesture.
    event : Event
        Which one.
    moment : str
        Where in the timeline it lies, as a person writes it.
    below_db : float
        Its click under the strongest one's, dB.
    """

    time_s: float
    event: Event
    moment: str
    below_db: float

    @property
    def strength(self) -> str:
        """In a word."""
        if self.below_db <= STRONG_DB:
            return "strong"
        return "medium" if self.below_db <= MEDIUM_DB else "weak"

    @property
    def words(self) -> str:
        """`goal, 2-1 Mbappe, strong`."""
        label = " ".join(self.event.words.split())
        named = [self.event.kind.replace("_", " "), *([label] if label else [])]
        return ", ".join([*named, self.strength])


def passed_events(strikes: Strikes, timeline: Timeline) -> list[PassedEvent]:
    """The events that were passed, in order of time; those of the base surface are left out."""
    passed = strikes.of_events()
    events = [timeline.events[event] for event in passed.event]
    return of_events(passed.time_s.tolist(), passed.level.tolist(), events, timeline)


def of_events(
    times_s: Iterable[float], levels: Sequence[float], events: Iterable[Event], timeline: Timeline
) -> list[PassedEvent]:
    """Events with when they were struck and how hard (the click's amplitude, linear)."""
    strongest = max([*levels, 1e-12])
    return [
        PassedEvent(
            time_s,
            event,
            timeline.moment_text(event.time_s),
            -20.0 * float(np.log10(max(level / strongest, 1e-6))),
        )
        for time_s, level, event in zip(times_s, levels, events, strict=True)
    ]


def as_text(passed: Sequence[PassedEvent]) -> str:
    """`1.24 s goal, 2-1 Mbappe, strong`, a line each."""
    return "".join(f"{one.time_s:.2f} s {one.words}\n" for one in passed)


def as_records(passed: Sequence[PassedEvent]) -> list[dict[str, object]]:
    """The same as plain data."""
    return [
        {
            "time_s": round(one.time_s, 4),
            "kind": one.event.kind,
            "label": one.event.label,
            "event_s": one.event.time_s,
            "moment": one.moment,
            "strength": one.strength,
            "below_strongest_db": round(one.below_db, 1),
        }
        for one in passed
    ]


def _json(passed: Sequence[PassedEvent]) -> str:
    return json.dumps(as_records(passed), indent=1, ensure_ascii=False) + "\n"


def as_audacity(passed: Sequence[PassedEvent]) -> str:
    """A label track of Audacity: start, end, text, by tabs."""
    return "".join(f"{one.time_s:.6f}\t{one.time_s:.6f}\t{one.words}\n" for one in passed)


def as_reaper(passed: Sequence[PassedEvent]) -> str:
    """Markers as REAPER's region and marker manager reads them."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["#", "Name", "Start", "End", "Length"])
    for number, one in enumerate(passed, 1):
        minutes, seconds = divmod(round(one.time_s * 1000), 60_000)
        rows.writerow([f"M{number}", one.words, f"{minutes}:{seconds / 1000:06.3f}", "", ""])
    return text.getvalue()


def as_webvtt(passed: Sequence[PassedEvent]) -> str:
    """Subtitles: each event until the next, at most 1.5 s."""
    lines = ["WEBVTT", ""]
    for number, one in enumerate(passed):
        end = one.time_s + SHOWN_S
        if number + 1 < len(passed):
            end = min(end, max(passed[number + 1].time_s, one.time_s + 0.001))
        # an arrow in a cue's text would end it, and these begin markup
        words = one.words.replace("&", "&amp;").replace("<", "&lt;").replace("-->", "--&gt;")
        lines += [f"{_clock(one.time_s)} --> {_clock(end)}", words, ""]
    return "\n".join(lines)


def _clock(seconds: float) -> str:
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{milliseconds / 1000:06.3f}"


WRITERS: dict[str, Callable[[Sequence[PassedEvent]], str]] = {
    ".audacity.txt": as_audacity,
    ".txt": as_text,
    ".json": _json,
    ".csv": as_reaper,
    ".vtt": as_webvtt,
}
"""By how a file's name ends: the first that fits."""


def writer_of(path: str | os.PathLike[str]) -> Callable[[Sequence[PassedEvent]], str]:
    """What writes a file of that name; InputError if none does."""
    for suffix, writer in WRITERS.items():
        if Path(path).name.lower().endswith(suffix):
            return writer
    raise InputError(
        f"{os.fspath(path)}: a transcript is .txt, .json, .vtt (subtitles), .audacity.txt (labels) "
        "or .csv (REAPER's markers)"
    )


def save_transcript(passed: Sequence[PassedEvent], path: str | os.PathLike[str]) -> None:
    """Write what passed_events, in the format that the file's name asks for."""
    text = writer_of(path)(passed)
    with whole_file(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


MOST = 8
"""Lines for each way: the strongest events; a match has hundreds of weak ones."""


def transcript(
    strikes: Strikes,
    timeline: Timeline,
    engaged: NDArray[np.float64] | None,
    sample_rate: float,
    most: int = MOST,
) -> tuple[str, ...]:
    """The strongest strikes of the way out and of the recoil, in order of time, a line each.

    Parameters
    ----------
    strikes
        Of a render; those of the base surface are left out.
    timeline
        The one that was rendered: gives kinds, labels and moments.
    engaged
        The trace's column, one value a frame, or None where there is no trace: says which
        strikes belong to the recoil; without it all count as one way.
    sample_rate
        Hz, of `engaged`.
    most
        Lines for each way.

    Returns
    -------
    tuple of str
        "1.75 s: goal, 1-0 Perez, at 27:00.0, 12 dB below the strongest"; empty if nothing was
        passed.
    """
    passed = passed_events(strikes, timeline)
    touched = [True] * len(passed)
    if engaged is not None and len(engaged):
        frames = [min(int(one.time_s * sample_rate), len(engaged) - 1) for one in passed]
        touched = [bool(engaged[frame] > 0.5) for frame in frames]
    strongest = np.argsort(-strikes.of_events().level, kind="stable").tolist()
    kept = [i for way in (True, False) for i in [i for i in strongest if touched[i] == way][:most]]
    lines = []
    for i in sorted(kept):
        event, below = passed[i].event, round(passed[i].below_db)
        words = event.kind.replace("_", " ") + (f", {event.words}" if event.words else "")
        words += "" if touched[i] else ", on the way back"
        level = f"{below} dB below the strongest" if below else "the strongest"
        lines.append(f"{passed[i].time_s:.2f} s: {words}, at {passed[i].moment}, {level}")
    return tuple(lines)
