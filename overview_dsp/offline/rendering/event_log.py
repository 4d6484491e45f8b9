"""Event log: events passed by a gesture as text, JSON, labels and subtitles.

It describes a render in text for accessibility: the passed events and their strength.
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

from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import write_file
from overview_dsp.signal.engine.memory_reader import Strikes

STRONG_DB, MEDIUM_DB = 6.0, 18.0
"""Limits of strong and medium events below the strongest one, dB; others are weak."""

LEAST_SHOWN_S, SHOWN_S = 0.7, 1.5
"""Shortest and longest duration of a subtitle, s."""

MAX_SHOWN = 3  # most events that a subtitle names


@dataclass(frozen=True)
class PassedEvent:
    """Event passed by the disk.

    `time_s`: time of its strike from the start of the gesture, s.
    `moment`: time in the timeline as text.
    `below_db`: level of its click below the strongest one, dB.
    """

    time_s: float
    event: Event
    moment: str
    below_db: float

    @property
    def strength(self) -> str:
        """Strength: `strong`, `medium` or `weak`."""
        if self.below_db <= STRONG_DB:
            return "strong"
        return "medium" if self.below_db <= MEDIUM_DB else "weak"

    @property
    def text(self) -> str:
        """Description such as `goal, 2-1 Mbappe, strong`."""
        label = " ".join(self.event.display_label.split())
        named = [self.event.kind.replace("_", " "), *([label] if label else [])]
        return ", ".join([*named, self.strength])


def passed_events(strikes: Strikes, timeline: Timeline) -> list[PassedEvent]:
    """Return the passed events in order of time, without strikes of the base surface."""
    passed = strikes.of_events()
    events = [timeline.events[event] for event in passed.event]
    return of_events(passed.time_s.tolist(), passed.level.tolist(), events, timeline)


def of_events(
    times_s: Iterable[float], levels: Sequence[float], events: Iterable[Event], timeline: Timeline
) -> list[PassedEvent]:
    """Return passed events from their times and levels (linear amplitudes of the clicks)."""
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
    """Return one line per event, such as `1.24 s goal, 2-1 Mbappe, strong`."""
    return "".join(f"{one.time_s:.2f} s {one.text}\n" for one in passed)


def as_records(passed: Sequence[PassedEvent]) -> list[dict[str, object]]:
    """Return the events as plain data for JSON."""
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


def as_reaper(passed: Sequence[PassedEvent]) -> str:
    """Return markers for REAPER's region and marker manager."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["#", "Name", "Start", "End", "Length"])
    for number, one in enumerate(passed, 1):
        minutes, seconds = divmod(round(one.time_s * 1000), 60_000)
        rows.writerow([f"M{number}", one.text, f"{minutes}:{seconds / 1000:06.3f}", "", ""])
    return text.getvalue()


def as_webvtt(passed: Sequence[PassedEvent]) -> str:
    """Return WebVTT subtitles: each lasts until the next one, 0.7 to 1.5 s.

    Events that are closer than that share a subtitle, which names the three strongest.
    """
    groups: list[list[PassedEvent]] = []
    for one in passed:
        if groups and one.time_s < groups[-1][0].time_s + LEAST_SHOWN_S:
            groups[-1].append(one)
        else:
            groups.append([one])
    lines = ["WEBVTT", ""]
    for number, group in enumerate(groups):
        start = group[0].time_s
        following = groups[number + 1][0].time_s if number + 1 < len(groups) else start + SHOWN_S
        strongest = sorted(group, key=lambda one: one.below_db)[:MAX_SHOWN]
        # an arrow would end a cue's text, and & and < start markup
        words = [
            one.text.replace("&", "&amp;").replace("<", "&lt;").replace("-->", "--&gt;")
            for one in group
            if one in strongest
        ]
        if len(group) > len(words):
            words[-1] += f" (and {len(group) - len(words)} weaker)"
        end = min(start + SHOWN_S, following)
        lines += [f"{_clock(start)} --> {_clock(end)}", *words, ""]
    return "\n".join(lines)


def _clock(seconds: float) -> str:
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{milliseconds / 1000:06.3f}"


WRITERS: dict[str, Callable[[Sequence[PassedEvent]], str]] = {
    # a label track: start, end and text
    ".audacity.txt": lambda passed: "".join(
        f"{one.time_s:.6f}\t{one.time_s:.6f}\t{one.text}\n" for one in passed
    ),
    ".txt": as_text,
    ".json": lambda passed: json.dumps(as_records(passed), indent=1, ensure_ascii=False) + "\n",
    ".csv": as_reaper,
    ".vtt": as_webvtt,
}
"""Writers by the end of a file name; the first match applies."""


def writer_of(path: str | os.PathLike[str]) -> Callable[[Sequence[PassedEvent]], str]:
    """Return the writer for a file name; raise InputError for unknown suffixes."""
    for suffix, writer in WRITERS.items():
        if Path(path).name.lower().endswith(suffix):
            return writer
    raise InputError(
        f"{os.fspath(path)}: a transcript must be .txt, .json, .vtt (subtitles), .audacity.txt "
        "(labels) or .csv (REAPER's markers)"
    )


def save_transcript(passed: Sequence[PassedEvent], path: str | os.PathLike[str]) -> None:
    """Write passed events in the format of the file's suffix."""
    write_file(path, writer_of(path)(passed))


MOST = 8  # highest number of lines for the way out, and for the recoil


def transcript(
    strikes: Strikes, timeline: Timeline, engaged: FloatArray | None, sample_rate: float
) -> tuple[str, ...]:
    """Return one line for each of the strongest strikes of the way out and of the recoil.

    `strikes`: those of a render; those of the base surface are omitted.
    `engaged`: column of the trace, which separates the recoil from the way out; None: all strikes
        count as the way out.
    `sample_rate`: sample rate of `engaged`, Hz.

    A line is "1.75 s: goal, 1-0 Perez, at 27:00.0, 12 dB below the strongest".
    """
    passed = passed_events(strikes, timeline)
    touched = [True] * len(passed)
    if engaged is not None and len(engaged):
        frames = [min(int(one.time_s * sample_rate), len(engaged) - 1) for one in passed]
        touched = [bool(engaged[frame] > 0.5) for frame in frames]
    strongest = np.argsort(-strikes.of_events().level, kind="stable").tolist()
    kept = [i for way in (True, False) for i in [i for i in strongest if touched[i] == way][:MOST]]
    lines = []
    for i in sorted(kept):
        event, below = passed[i].event, round(passed[i].below_db)
        words = [event.kind.replace("_", " "), event.display_label]
        words += ["" if touched[i] else "on the way back", f"at {passed[i].moment}"]
        words.append(f"{below} dB below the strongest" if below else "the strongest")
        lines.append(f"{passed[i].time_s:.2f} s: {', '.join(filter(None, words))}")
    return tuple(lines)
