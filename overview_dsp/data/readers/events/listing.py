"""Happenings as they are listed into a Timeline: kinds of words, zero, length, what is twice."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from overview_dsp.data.analysis.crowd_excitement import FOOTBALL_KINDS, derive_intensity
from overview_dsp.data.timeline.event import MAX_EVENTS
from overview_dsp.data.timeline.model import Event, Timeline
from overview_dsp.errors import InputError, shown

PLAIN_KIND = "event"
"""What something is called that has only a sentence."""

_MOST_WORDS, _LONGEST_KIND = 4, 40
_SHOWN = 3


@dataclass(frozen=True)
class Listed:
    """One happening.

    Parameters
    ----------
    time_s, end_s
        When it begins and ends, s; `end_s` is None where only one moment is known.
    words
        What kind of thing it is, as written.
    label
        What is said of it.
    place
        `line 7`, for a person.
    weight
        How strong; 1 = ordinary.
    id
        Its own name in the file, or empty.
    """

    time_s: float
    words: str
    label: str = ""
    place: str = ""
    end_s: float | None = None
    weight: float = 1.0
    id: str = ""


@dataclass(frozen=True)
class About:
    """Of the whole list: its title, where it is from, notes, and a length or calendar if known.

    `from_first` makes the first happening time 0, as for dates and times of day; else 0 is where
    the clock of the list begins. `as_written` takes the words as kinds that are valid already.
    """

    title: str
    provenance: str
    notes: tuple[str, ...] = ()
    duration_s: float | None = None
    start: datetime | None = None
    from_first: bool = False
    as_written: bool = False


def kind_of(words: str) -> str:
    """Return words as a kind: small letters, figures and underlines; empty if none is left.

    Accents are dropped; a sentence (more than `_MOST_WORDS` words) is none.
    """
    plain = unicodedata.normalize("NFKD", words.replace("ß", "ss")).encode("ascii", "ignore")
    kind = re.sub(r"[^a-z0-9]+", "_", plain.decode().lower()).strip("_")
    return kind if len(kind) <= _LONGEST_KIND and kind.count("_") < _MOST_WORDS else ""


def are_kinds(words: Sequence[str]) -> bool:
    """Return whether texts are kinds of things, of which some come again, and not their names."""
    kinds = [kind_of(text) for text in words]
    return all(kinds) and 4 * len(set(kinds)) <= 3 * len(kinds)


def kinds_or_labels(listed: Sequence[Listed], plain_kind: str = PLAIN_KIND) -> list[Listed]:
    """Return a list whose words are kinds if they are such, else labels of the kind given."""
    if are_kinds([one.words for one in listed]):
        return list(listed)
    return [replace(one, words=plain_kind, label=one.words) for one in listed]


def timeline_of(listed: Sequence[Listed], about: About) -> Timeline:
    """Make a Timeline of a list.

    Raises
    ------
    InputError
        Nothing listed, too much, no length, an event after a length that was given.
    """
    if not listed:
        raise InputError("no events in it; add one row for each event")
    if len(listed) > MAX_EVENTS:
        raise InputError(
            f"{len(listed)} events, more than the {MAX_EVENTS} that are read; cut the file into "
            "parts, or make a curve of them"
        )
    zero = min(one.time_s for one in listed) if about.from_first else 0.0
    early = min(listed, key=lambda one: one.time_s)
    if early.time_s < zero:
        raise InputError(
            f"{early.place}: {early.time_s:g} s is before the start; times are seconds from 0 up"
        )
    notes = [*about.notes, *repeated_ids(one.id for one in listed)]
    events: dict[tuple[float, str, str], Event] = {}
    for one in listed:
        kind = one.words if about.as_written else kind_of(one.words) or PLAIN_KIND
        label = one.label or ("" if kind == one.words else one.words)
        event = Event(one.time_s - zero, kind, label, one.weight)
        events.setdefault((event.time_s, event.kind, event.label), event)
    if len(events) < len(listed):
        notes.append(f"{len(listed) - len(events)} rows repeat another; they count once")
    last = max(max(one.time_s, one.end_s or one.time_s) for one in listed) - zero
    duration_s = about.duration_s if about.duration_s is not None else last
    if not duration_s > 0.0:
        raise InputError(
            "all events are at one moment, so the duration is unknown; give it with duration_s "
            "(--read duration=S)"
        )
    late = max(listed, key=lambda one: one.time_s)
    if late.time_s - zero > duration_s:
        raise InputError(
            f"{late.place}: {late.time_s - zero:g} s is after the end of the timeline (duration_s "
            f"{duration_s!r}); correct one of them"
        )
    known = tuple(events.values())
    football = sum(event.kind in FOOTBALL_KINDS for event in known) * 2 >= len(known)
    curve, derived, said = derive_intensity(known, duration_s) if football else (None, "", ())
    return Timeline(
        title=about.title,
        duration_s=duration_s,
        events=known,
        intensity=curve,
        provenance="; ".join(part for part in (about.provenance, derived) if part),
        notes=(*notes, *said),
        start=about.start,
    )


def repeated_ids(ids: Iterable[str]) -> list[str]:
    """Return a note on ids, but for empty ones, that are there more than once; none if none is."""
    twice = [name for name, count in Counter(ids).items() if name and count > 1]
    if not twice:
        return []
    repeated = ", ".join(shown(name) for name in twice[:_SHOWN])
    more = f" and {len(twice) - _SHOWN} more" if len(twice) > _SHOWN else ""
    return [f"the same event id is there more than once: {repeated}{more}; all of them are kept"]
