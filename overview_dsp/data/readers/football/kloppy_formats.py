"""Reader of match events in formats that kloppy supports (the extra `football`).

The formats are Opta F24 or F73, Stats Perform MA3 (XML or JSON), Sportec, Metrica JSON,
DataFactory, and Wyscout v3. The first four require a second file with the teams in the same folder:
Opta F7, MA1, match information, or EPTS metadata. It is detected by its content.

Some data are read from the raw events, because kloppy 3.19 omits them: own goals of DataFactory,
cards of Wyscout v3 and Metrica, and woodwork of Metrica. Wyscout v2 has its own reader (`wyscout`),
because kloppy omits its own goals and does not know its home team.
"""

from __future__ import annotations

import contextlib
import io
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from typing import Any

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import repeated_ids
from overview_dsp.data.readers.football.match_timeline import (
    MAX_PERIOD_S,
    SHOOT_OUT,
    START_LABELS,
    TOUCH,
    MatchEvent,
    concatenate_periods,
    match_timeline,
    short_name,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.toml import load_toml
from overview_dsp.installation import require_package

MAX_BYTES = 16 * 2**20
"""Maximum file size without `max_mb`. A match has up to 5 MB; kloppy needs 20 times the memory."""

LATE_START_S = (600.0, 14_400.0)
"""Range of the first time in a period, s, if the clock runs on from the previous period.

Later times indicate a broken clock.
"""

MAX_FILES = 200
"""Maximum number of files that are searched for the teams."""

_TABLE = load_toml(__file__, "kloppy_formats.toml")
_CARDS: dict[str, tuple[str, str]] = {name: (*card,) for name, card in _TABLE["cards"].items()}
_BALL_TOUCHES: dict[str, str] = _TABLE["ball_touches"]
_NEAR_MISS = {"SAVED": "saved", "POST": "on the post"}
_OWN_GOAL_OF_DATAFACTORY = 10


def sniff(source: DataFile) -> bool:
    """Return whether the file has match events in one of the formats."""
    return _format_of(source) is not None


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a match (takes only the options for limits).

    InputError: kloppy is not installed or cannot read the file, or the companion file is missing.
    """
    format_ = _format_of(source)
    assert format_ is not None  # checked by `sniff`
    name, files = format_["name"], [_bytes(source)]
    module, function, *arguments = format_["load"]
    kloppy = require_package(f"kloppy.{module}", f"reading {name}", "football")
    if "companion" in format_:
        files.append(_bytes(_companion(source, name, format_["companion"])))
    streams = {name: io.BytesIO(data) for name, data in zip(arguments, files, strict=True)}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            dataset = getattr(kloppy, function)(**streams)
    except Exception as error:  # the exceptions of kloppy are not documented
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise InputError(
            f"kloppy cannot read these {name} ({reason}); the file may be incomplete"
        ) from error
    return _timeline(dataset, name, source.stem)


def _format_of(source: DataFile) -> dict[str, Any] | None:
    return next((format_ for format_ in _TABLE["formats"] if _fits(source, format_)), None)


def _fits(source: DataFile, signature: Mapping[str, Any]) -> bool:
    """Return whether a file has the XML or the JSON of a format or companion (see the table)."""
    root, *texts = signature.get("xml", [None])
    if source.xml_root == root and all(text in (source.head_text or "") for text in texts):
        return True
    path = signature.get("json")
    if path is None or not source.looks_like_json or f'"{path[0]}"' not in source.text:
        return False
    value: Any = source.json
    try:
        for step in path:
            value = value[step]
    except (KeyError, IndexError, TypeError):
        return False
    return value is not None


def _bytes(source: DataFile) -> bytes:
    """Return the text of a file as UTF-8, after checking its size and content."""
    limit = source.options.max_mb * 2**20 if source.options.max_mb is not None else MAX_BYTES
    if source.size > limit:
        raise InputError(
            f"{source.where}: size is {source.size / 2**20:.0f} MB; one match must have at most "
            f"{limit / 2**20:g} MB: raise the limit with max_mb (--read max-mb=MB)"
        )
    if source.looks_like_json:
        _ = source.json  # checks its limits
        return source.text.removeprefix("\ufeff").encode()
    # kloppy detects XML by the declaration
    with validation.prefix_errors(f"{source.where}: "):
        return ('<?xml version="1.0" encoding="UTF-8"?>\n' + source.xml_text.lstrip()).encode()


def _companion(source: DataFile, name: str, companion: Mapping[str, Any]) -> DataFile:
    """Return the companion file, which must be the only one in the folder."""
    found: list[DataFile] = []
    try:
        paths = sorted(p for p in source.folder.iterdir() if p.suffix.lower() in (".xml", ".json"))
    except OSError:  # no permission to list the folder
        paths = []
    for path in paths[:MAX_FILES]:
        with contextlib.suppress(InputError):  # an unrelated file
            candidate = DataFile.open(path, source.options)
            if path != source.path and candidate.size <= MAX_BYTES and _fits(candidate, companion):
                found.append(candidate)
    if len(found) > 1:
        # for several matches in a folder: the name with the longest common prefix
        prefixes = [os.path.commonprefix([source.path.name, f.path.name]) for f in found]  # noqa: RUF071
        longest = max(map(len, prefixes))
        best = [one for one, same in zip(found, prefixes, strict=True) if len(same) == longest]
        found = best if len(best) == 1 else found
    if len(found) != 1:
        problem = f"{len(found)} files in the folder may be" if found else "the folder lacks"
        raise InputError(
            f"{name}: {problem} {companion['name']}; put only that of this match into the same "
            "folder"
        )
    return found[0]


def _timeline(dataset: Any, format_name: str, default_title: str) -> Timeline:
    notes = repeated_ids(_unique_ids(dataset.events))
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
            notes.append(f"the clock of period {period} starts at {start:.0f} s, not at 0")
        else:
            start = 0.0
        inside = [(t - start, e) for t, e in events if 0.0 <= t - start <= MAX_PERIOD_S]
        outside += len(events) - len(inside)
        lengths[period] = max((time_s for time_s, _ in inside), default=0.0)
        by_period[period] = inside
    begins, end_s = concatenate_periods(lengths)
    if outside:
        notes.append(f"{outside} events are outside their period: omitted")
    if kicks:
        notes.append(f"the shoot-out is omitted: {len(kicks)} kicks, {sum(kicks)} scored")
    match_events: list[MatchEvent] = []
    for period in begins:
        for period_s, event in by_period[period]:
            time_s, player = begins[period] + period_s, _player(event)
            ground = getattr(getattr(event.team, "ground", None), "name", "")
            team = {"HOME": 0, "AWAY": 1}.get(ground)
            kinds = list(_classify(event))
            if not kinds and event.event_type.name in _BALL_TOUCHES:
                kinds = [(TOUCH, _BALL_TOUCHES[event.event_type.name])]
            for kind, detail in kinds:
                scorer = 1 - team if kind == "own_goal" and team is not None else team
                location = f"event {event.event_id}"
                match_events.append(MatchEvent(time_s, kind, scorer, player, detail, "", location))
    metadata = dataset.metadata
    date = metadata.date
    # a score of Metrica may be an empty text
    goals = [getattr(metadata.score, name, None) for name in ("home", "away")]
    home, away = (one if isinstance(one, int) else None for one in goals)
    return match_timeline(
        [_name(team.name or f"team {team.team_id}", "team") for team in metadata.teams],
        begins,
        end_s,
        match_events,
        f"events: {format_name}, read with kloppy",
        notes,
        default_title=default_title,
        title_parts=[date.date().isoformat()] if isinstance(date, datetime) else [],
        final=None if home is None or away is None else (home, away),
    )


def _unique_ids(events: Iterable[Any]) -> Iterator[str]:
    """Yield each event's id, once if kloppy makes two of it, such as a pass that goes out."""
    seen: set[tuple[int, str]] = set()
    for event in events:
        key = (id(event.raw_event), str(event.event_id))
        if event.raw_event is None or key not in seen:
            seen.add(key)
            yield key[1]


def _classify(event: Any) -> Iterator[tuple[str, str]]:
    """Yield the event kinds and details of an event."""
    kind, result = event.event_type.name, _result(event)
    raw = event.raw_event if isinstance(event.raw_event, Mapping) else {}
    if kind == "FOUL_COMMITTED":
        yield "foul", ""
        secondary = _mapping(raw.get("type")).get("secondary")
        for card in ("yellow_card", "red_card"):  # Wyscout v3
            if isinstance(secondary, list) and card in secondary:
                yield card, ""
    elif kind == "CARD":
        # cards of Wyscout v3 are read from the fouls above
        if event.card_type is not None and "primary" not in _mapping(raw.get("type")):
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
        elif result in _NEAR_MISS or "WOODWORK" in names:
            how = _NEAR_MISS.get(result, "on the post")
            yield "near_miss", f"penalty {how}" if penalty else how
        elif penalty:
            yield "near_miss", "penalty missed"
    elif _mapping(raw.get("type")).get("name") == "CARD":  # Metrica
        yield ("red_card" if "RED" in _subtypes(raw) else "yellow_card"), ""


def _mapping(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _subtypes(raw: Mapping[str, object]) -> list[object]:
    """Return the names of Metrica's subtypes, which are a list or one object."""
    value = raw.get("subtypes")
    return [_mapping(one).get("name") for one in (value if isinstance(value, list) else [value])]


def _result(event: Any) -> str:
    return str(getattr(event.result, "name", ""))


def _player(event: Any) -> str:
    player = event.player
    name = player and (player.last_name or player.name)
    return short_name(_name(name or "", "player"))


def _name(value: object, of: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"the name of a {of} is {quoted(value)}, not text; correct it in the file")
    return value
