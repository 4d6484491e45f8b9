"""Builder of a Timeline from the entries of an event list."""

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
from overview_dsp.errors import InputError, quoted

DEFAULT_KIND = "event"
"""Event kind of entries that have a label only."""

_MAX_KIND_WORDS, _MAX_KIND_LENGTH = 4, 40
_MAX_IDS_SHOWN = 3


@dataclass(frozen=True)
class ListEntry:
    """Entry of an event list.

    `time_s`, `end_s`: start and end, s; `end_s` is None if it is unknown.
    `kind_text`: event kind as written in the file.
    `label`: label of the event.
    `location`: position in the file for error messages, such as `line 7`.
    `weight`: strength relative to an ordinary event, 1.
    `id`: id in the file, or empty.
    `side`: team of the event, 1 or 2; 0 without one.
    """

    time_s: float
    kind_text: str
    label: str = ""
    location: str = ""
    end_s: float | None = None
    weight: float = 1.0
    id: str = ""
    side: int = 0


@dataclass(frozen=True)
class ListDescription:
    """Title, origin and notes of an event list, and its duration and start if known.

    `from_first`: time 0 is the first event, as for dates and times of day; else it is the zero of
    the list's clock. `as_written`: the texts of the kinds are valid event kinds.
    """

    title: str
    provenance: str
    notes: tuple[str, ...] = ()
    duration_s: float | None = None
    start: datetime | None = None
    from_first: bool = False
    as_written: bool = False


def kind_of(text: str) -> str:
    """Return a text as an event kind, in lower case without accents and with underscores.

    The result is empty for a sentence of more than `_MAX_KIND_WORDS` words.
    """
    plain = unicodedata.normalize("NFKD", text.replace("ß", "ss")).encode("ascii", "ignore")
    kind = re.sub(r"[^a-z0-9]+", "_", plain.decode().lower()).strip("_")
    return kind if len(kind) <= _MAX_KIND_LENGTH and kind.count("_") < _MAX_KIND_WORDS else ""


def with_kinds(listed: Sequence[ListEntry], default_kind: str = DEFAULT_KIND) -> list[ListEntry]:
    """Return the list as it is if its texts are kinds, else events of one kind with labels.

    They are kinds if each of them can be one, and at least a quarter of them are repeats.
    """
    kinds = [kind_of(one.kind_text) for one in listed]
    if all(kinds) and 4 * len(set(kinds)) <= 3 * len(kinds):
        return list(listed)
    return [replace(one, kind_text=default_kind, label=one.kind_text) for one in listed]


def timeline_of(listed: Sequence[ListEntry], description: ListDescription) -> Timeline:
    """Return the Timeline of an event list.

    InputError: the list is empty or too long, its duration is unknown, or an event is after its
    end.
    """
    if not listed:
        raise InputError("the file has no events; add one row per event")
    if len(listed) > MAX_EVENTS:
        raise InputError(
            f"the file has {len(listed)} events; must be at most {MAX_EVENTS}: cut it into parts, "
            "or read it as a curve (--map count)"
        )
    zero = min(one.time_s for one in listed) if description.from_first else 0.0
    early = min(listed, key=lambda one: one.time_s)
    if early.time_s < zero:
        raise InputError(
            f"{early.location}: {early.time_s:g} s is before the start; times must be 0 s or later"
        )
    notes = [*description.notes, *repeated_ids(one.id for one in listed)]
    events: dict[tuple[float, str, str], Event] = {}
    for one in listed:
        text = one.kind_text
        kind = text if description.as_written else kind_of(text) or DEFAULT_KIND
        label = one.label or ("" if kind == text else text)
        event = Event(one.time_s - zero, kind, label, one.weight, one.side)
        events.setdefault((event.time_s, event.kind, event.label), event)
    if len(events) < len(listed):
        notes.append(f"{len(listed) - len(events)} rows repeat another row and were omitted")
    last = max(max(one.time_s, one.end_s or one.time_s) for one in listed) - zero
    duration_s = description.duration_s if description.duration_s is not None else last
    if not duration_s > 0.0:
        raise InputError(
            "all events have the same time, so the duration is unknown; set duration_s "
            "(--read duration=S)"
        )
    late = max(listed, key=lambda one: one.time_s)
    if late.time_s - zero > duration_s:
        raise InputError(
            f"{late.location}: {late.time_s - zero:g} s is after the end of the timeline "
            f"(duration_s {duration_s!r}); correct one of them"
        )
    unique = tuple(events.values())
    football = sum(event.kind in FOOTBALL_KINDS for event in unique) * 2 >= len(unique)
    curve, derived, curve_notes = (
        derive_intensity(unique, duration_s) if football else (None, "", ())
    )
    return Timeline(
        title=description.title,
        duration_s=duration_s,
        events=unique,
        intensity=curve,
        provenance="; ".join(part for part in (description.provenance, derived) if part),
        notes=(*notes, *curve_notes),
        start=description.start,
    )


def repeated_ids(ids: Iterable[str]) -> list[str]:
    """Return a note about repeated ids, or no note; empty ids are ignored."""
    repeated = [quoted(id_) for id_, count in Counter(ids).items() if id_ and count > 1]
    if not repeated:
        return []
    listed, more = ", ".join(repeated[:_MAX_IDS_SHOWN]), len(repeated) - _MAX_IDS_SHOWN
    rest = f" and {more} more" if more > 0 else ""
    return [f"event ids occur more than once: {listed}{rest}; all these events were read"]
