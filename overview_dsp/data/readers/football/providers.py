"""Matches of other providers, read with kloppy (the extra `football`).

Opta F24 or F73 (its F7 beside it), Stats Perform MA3 (MA1 beside it; XML or JSON), Sportec (match
information beside it), Metrica JSON (EPTS metadata beside it), DataFactory, Wyscout v3. Whichever
file beside it holds the teams is told by its content.

What kloppy 3.19 leaves to whoever has the raw event is taken from it: own goals of DataFactory,
cards of Wyscout v3 and Metrica, woodwork of Metrica. Wyscout v2 has a reader of its own
(`wyscout`), as kloppy has no own goals there and takes whichever team comes first for the home
team.
"""

from __future__ import annotations

import contextlib
import io
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.listing import repeated_ids
from overview_dsp.data.readers.football.match import (
    MAX_PERIOD_S,
    SHOOT_OUT,
    START_LABELS,
    Happening,
    Touch,
    lay_end_to_end,
    match_timeline,
    short_name,
)
from overview_dsp.data.readers.plugins import require_package
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

MAX_BYTES = 16 * 2**20
"""Largest file without `max_mb`: a match has up to 5 MB, and kloppy takes 20 times its size."""

LATE_START_S = (600.0, 14_400.0)
"""A period whose first event lies between has a clock that didn't restart; later, a broken one."""

MAX_BESIDE = 200
"""Most files beside it that are looked into."""

_CARDS = {
    "FIRST_YELLOW": ("yellow_card", ""),
    "SECOND_YELLOW": ("red_card", "second yellow"),
    "RED": ("red_card", ""),
}
_NEAR = {"SAVED": "saved", "POST": "on the post"}
_TOUCHES = {
    "PASS": "pass", "DUEL": "duel", "TAKE_ON": "take-on", "CARRY": "carry", "SHOT": "shot",
    "CLEARANCE": "clearance", "INTERCEPTION": "interception", "RECOVERY": "recovery",
    "MISCONTROL": "miscontrol", "GOALKEEPER": "goalkeeper",
}  # fmt: skip
_OWN_GOAL_OF_DATAFACTORY = 10


@dataclass(frozen=True)
class _Feed:
    """A provider's files.

    Parameters
    ----------
    name
        Of the events, for a person.
    claims
        Whether a file holds its events.
    load
        Module and function of kloppy, and the names of its arguments: events, then what is beside.
    beside
        Of what must lie beside it: its name, and whether a file is that.
    """

    name: str
    claims: Callable[[DataFile], bool]
    load: tuple[str, ...]
    beside: tuple[str, Callable[[DataFile], bool]] | None = None


def _xml(root: str, *words: str) -> Callable[[DataFile], bool]:
    def claims(source: DataFile) -> bool:
        return source.xml_root == root and all(w in (source.head_text or "") for w in words)

    return claims


def _json(*path: str | int) -> Callable[[DataFile], bool]:
    """Return whether a file is JSON with something at the end of a path of keys and positions."""

    def claims(source: DataFile) -> bool:
        if not source.looks_like_json or f'"{path[0]}"' not in source.text:
            return False
        at: Any = source.json
        try:
            for step in path:
                at = at[step]
        except (KeyError, IndexError, TypeError):
            return False
        return at is not None

    return claims


def _either(*claims: Callable[[DataFile], bool]) -> Callable[[DataFile], bool]:
    return lambda source: any(claim(source) for claim in claims)


_FEEDS = (
    _Feed(
        "Opta events (F24)",
        _xml("Games", "<Event", "type_id="),
        ("opta", "load", "f24_data", "f7_data"),
        ("the match's F7 file (line-ups)", _xml("SoccerFeed")),
    ),
    _Feed(
        "Stats Perform events (MA3)",
        _either(_xml("matchEvents"), _json("liveData", "event", 0, "typeId")),
        ("statsperform", "load_event", "ma3_data", "ma1_data"),
        ("the match's MA1 file (line-ups)", _either(_xml("match"), _json("liveData", "lineUp"))),
    ),
    _Feed(
        "Sportec events",
        _xml("PutDataRequest", "<Event "),
        ("sportec", "load_event", "event_data", "meta_data"),
        ("the match information", _xml("PutDataRequest", "<MatchInformation")),
    ),
    _Feed(
        "Metrica events (JSON)",
        _json("data", 0, "start", "frame"),
        ("metrica", "load_event", "event_data", "meta_data"),
        ("the match's EPTS metadata (XML)", _xml("main", "<Metadata")),
    ),
    _Feed("DataFactory match", _json("incidences", "goals"), ("datafactory", "load", "event_data")),
    _Feed(
        "Wyscout v3 events",
        _json("events", 0, "type", "primary"),
        ("wyscout", "load", "event_data"),
    ),
)


def sniff(source: DataFile) -> bool:
    """Return whether the file holds the events of a provider that kloppy reads."""
    return _feed_of(source) is not None


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a match (takes no options but the limits).

    Raises
    ------
    InputError
        kloppy isn't installed; no line-ups beside the events; what kloppy can't read.
    """
    feed = _feed_of(source)
    assert feed is not None  # sniffed
    files = [_bytes(source)]
    with validation.located(f"{source.where}: "):
        module, function, *arguments = feed.load
        kloppy = require_package(f"kloppy.{module}", feed.name, "football")
        if feed.beside is not None:
            files.append(_bytes(_beside(source, feed)))
        streams = {name: io.BytesIO(data) for name, data in zip(arguments, files, strict=True)}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                dataset = getattr(kloppy, function)(**streams)
        except Exception as error:  # whatever its code meets in a broken file
            said = " ".join(f"{type(error).__name__}: {error}".split())[:200]
            raise InputError(
                f"kloppy can't read these {feed.name} ({said}); is the file complete?"
            ) from error
        return _timeline(dataset, feed, source.stem)


def _feed_of(source: DataFile) -> _Feed | None:
    return next((feed for feed in _FEEDS if feed.claims(source)), None)


def _bytes(source: DataFile) -> bytes:
    """Return a file's text as UTF-8, checked to be harmless."""
    limit = source.options.max_mb * 2**20 if source.options.max_mb is not None else MAX_BYTES
    if source.size > limit:
        raise InputError(
            f"{source.where}: {source.size / 2**20:.0f} MB, more than the {limit / 2**20:g} MB a "
            "match has; is it one match? raise the limit with max_mb (--read max-mb=MB)"
        )
    if source.looks_like_json:
        _ = source.json  # its limits and errors
        return source.text.removeprefix("\ufeff").encode()
    # what one of kloppy's readers knows XML by
    return ('<?xml version="1.0" encoding="UTF-8"?>\n' + source.xml_text.lstrip()).encode()


def _beside(source: DataFile, feed: _Feed) -> DataFile:
    """Return the one file beside the events that holds the teams."""
    assert feed.beside is not None
    what, is_it = feed.beside
    found: list[DataFile] = []
    try:
        paths = sorted(p for p in source.folder.iterdir() if p.suffix.lower() in (".xml", ".json"))
    except OSError:  # a folder that may be passed through but not listed
        paths = []
    for path in paths[:MAX_BESIDE]:
        with contextlib.suppress(InputError):  # some other file
            candidate = DataFile.open(path, source.options)
            if path != source.path and candidate.size <= MAX_BYTES and is_it(candidate):
                found.append(candidate)
    if len(found) > 1:
        # of several matches in a folder: the one that is called most alike
        name = source.path.name
        shared = [len(os.path.commonprefix([name, f.path.name])) for f in found]  # noqa: RUF071
        best = [other for other, n in zip(found, shared, strict=True) if n == max(shared)]
        found = best if len(best) == 1 else found
    if len(found) != 1:
        many = f"{len(found)} files beside it may be" if found else "it needs"
        raise InputError(
            f"{feed.name}: {many} {what}; put the match's own, and no other, into the same folder"
        )
    return found[0]


def _timeline(dataset: Any, feed: _Feed, default_title: str) -> Timeline:
    notes = repeated_ids(_own_ids(dataset.events))
    kicks: list[bool] = []
    outside = 0
    by_period: dict[int, list[tuple[float, Any]]] = {}
    for event in dataset.events:
        time_s = event.timestamp.total_seconds()
        if event.period.id in START_LABELS:
            by_period.setdefault(event.period.id, []).append((time_s, event))
        elif event.period.id == SHOOT_OUT and event.event_type.name == "SHOT":
            kicks.append(_result(event) == "GOAL")
    lengths: dict[int, float] = {}
    for period, events in sorted(by_period.items()):
        start = min((time_s for time_s, _ in events if time_s >= 0.0), default=0.0)
        if LATE_START_S[0] < start < LATE_START_S[1]:
            notes.append(f"period {period} begins {start:.0f} s into its clock: that is its start")
        else:
            start = 0.0
        inside = [(t - start, e) for t, e in events if 0.0 <= t - start <= MAX_PERIOD_S]
        outside += len(events) - len(inside)
        lengths[period] = max((time_s for time_s, _ in inside), default=0.0)
        by_period[period] = inside
    begins, end_s = lay_end_to_end(lengths)
    if outside:
        notes.append(f"{outside} events lie outside of their period: left out")
    if kicks:
        notes.append(f"the shoot-out is left out: {len(kicks)} kicks, {sum(kicks)} scored")
    happenings: list[Happening] = []
    touches: list[Touch] = []
    for period in begins:
        for into_s, event in by_period[period]:
            time_s, who, team = begins[period] + into_s, _player(event), _team(event)
            found = list(_happened(event))
            for kind, detail in found:
                gets = 1 - team if kind == "own_goal" and team is not None else team
                place = f"event {event.event_id}"
                happenings.append(Happening(time_s, kind, gets, who, detail, "", place))
            if not found and event.event_type.name in _TOUCHES:
                touches.append((time_s, _TOUCHES[event.event_type.name], who))
    about = dataset.metadata
    return match_timeline(
        [team.name or f"team {team.team_id}" for team in about.teams],
        begins,
        end_s,
        happenings,
        f"events: {feed.name}, read with kloppy",
        notes,
        default_title=default_title,
        about=[about.date.date().isoformat()] if isinstance(about.date, datetime) else [],
        final=_score(about.score),
        touches=touches,
    )


def _own_ids(events: Iterable[Any]) -> Iterator[str]:
    """Yield the events' ids; one of which kloppy makes several (a pass and a ball out) once."""
    seen: set[tuple[int, str]] = set()
    for event in events:
        made_of = (id(event.raw_event), str(event.event_id))
        if event.raw_event is None or made_of not in seen:
            seen.add(made_of)
            yield made_of[1]


def _happened(event: Any) -> Iterator[tuple[str, str]]:
    """Yield (kind, detail) of what happens in an event."""
    kind, result = event.event_type.name, _result(event)
    raw = event.raw_event if isinstance(event.raw_event, Mapping) else {}
    if kind == "FOUL_COMMITTED":
        yield "foul", ""
        secondary = _table(raw.get("type")).get("secondary")
        for card in ("yellow_card", "red_card"):  # Wyscout v3
            if isinstance(secondary, list) and card in secondary:
                yield card, ""
    elif kind == "CARD":
        # Wyscout v3 has it at its foul already, should kloppy give it too
        if event.card_type is not None and "primary" not in _table(raw.get("type")):
            yield _CARDS[event.card_type.name]
    elif kind == "SHOT":
        penalty = any(
            getattr(q.value, "name", "") == "PENALTY" for q in event.qualifiers or () if q.value
        )
        names = _subtypes(raw)
        if result == "OWN_GOAL" or raw.get("type") == _OWN_GOAL_OF_DATAFACTORY:
            yield "own_goal", ""
        elif result == "GOAL":
            yield "goal", "pen" if penalty else ""
        elif result in _NEAR or "WOODWORK" in names:
            yield "near_miss", "penalty saved" if penalty else _NEAR.get(result, "on the post")
        elif penalty:
            yield "near_miss", "penalty missed"
    elif _table(raw.get("type")).get("name") == "CARD":  # Metrica
        yield ("red_card" if "RED" in _subtypes(raw) else "yellow_card"), ""


def _table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _subtypes(raw: Mapping[str, object]) -> list[object]:
    """Return the names of Metrica's subtypes: of a list or of one."""
    given = raw.get("subtypes")
    return [_table(one).get("name") for one in (given if isinstance(given, list) else [given])]


def _result(event: Any) -> str:
    return str(getattr(event.result, "name", ""))


def _player(event: Any) -> str:
    player = event.player
    return short_name(player.last_name or player.name or "") if player is not None else ""


def _team(event: Any) -> int | None:
    ground = getattr(getattr(event.team, "ground", None), "name", "")
    return {"HOME": 0, "AWAY": 1}.get(ground)


def _score(score: Any) -> tuple[int, int] | None:
    """Return the stated score; Metrica's may be empty text."""
    home, away = getattr(score, "home", None), getattr(score, "away", None)
    return (home, away) if isinstance(home, int) and isinstance(away, int) else None
