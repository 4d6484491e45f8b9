"""Recorded takes: control events with their samples, and stamped changes.

`take_writer.py` writes them during a session.

The CSV has the columns of any take and `sample`, `sample_rate` and `source`; a JSON of the same
name beside it holds the stamped parameter and surface changes::

    {"overview_take": 2, "sample_rate": 48000.0, "seed": 0, "angle_map": 0.7, "title": "...",
     "preset": "football",
     "changes": [{"sample": 9600, "set": {"tactor.gain_db": -6.0}},
                 {"sample": 24000, "window": [0.0, 2700.0]},
                 {"sample": 48000, "preset": {...}},
                 {"sample": 96000, "timeline": {..., "window": [0.0, 2700.0]}},
                 {"sample": 144000, "pattern": {"kind": "goal", "weight": 1.0}}]}

`timeline` is the change of a live timeline (`data/feeds`) and its window (null: all). With `ahead`
(0 to 1), only positions beyond it have changed. The first timeline of the take is in
`NAME.timeline.json` in the same folder. `angle_map` is the first value of the preset's
`surface.angle_map`.

| version | change |
|---|---|
| 1 | shaft 2 disengaged at once after a release |
| 2 | `angle_map`; the disk arrives after a release |
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from overview_dsp.design.gestures.model import LONGEST_S, SOURCES, Change
from overview_dsp.errors import InputError, warn
from overview_dsp.files.atomic import write_file

COLUMNS = ("time_s", "theta2_rad", "touching", "sample", "sample_rate", "source")
CHANGES = ("set", "preset", "window", "timeline", "pattern")
VERSION = 2


@dataclass(frozen=True)
class TakeDocument:
    """Changes of a recorded take, and the played duration (s) of an interrupted one."""

    changes: tuple[Change, ...]
    played_s: float | None


def save_document(
    path: Path,
    sample_rate: float,
    about: Mapping[str, Any],
    changes: Iterable[tuple[int, Mapping[str, Any]]],
) -> None:
    """Write the JSON file of the take at `path`, completely or not at all."""
    document = {
        "overview_take": VERSION,
        "sample_rate": sample_rate,
        **about,
        "changes": [{"sample": sample, **what} for sample, what in changes],
    }
    text = json.dumps(document, ensure_ascii=False, allow_nan=False)
    write_file(path.with_suffix(".json"), text)


def event_line(event: tuple[int, int, float, bool], sample_rate: float) -> str:
    """Return an event (sample, source, theta2, touching) as a line of a recorded take."""
    sample, source, theta2, touching = event
    return (
        f"{sample / sample_rate!r},{float(theta2)!r},{int(touching)},{sample},"
        f"{float(sample_rate)!r},{SOURCES[source]}\n"
    )


def load_document(path: Path) -> TakeDocument:
    """Return the contents of the JSON file of a recorded take; InputError names the location."""
    beside = path.with_suffix(".json")
    try:
        text = beside.read_bytes()
    except FileNotFoundError:
        raise InputError(
            f"{path}: {beside.name} with the parameter changes of this recorded take is missing; "
            "add it, or delete the columns sample, sample_rate and source"
        ) from None
    except OSError as error:
        raise InputError(f"{beside}: can't be read ({error.strerror})") from None
    growing = False
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        document = _cut_short(text)
        growing = document is not None
        if document is None:
            raise InputError(f"{beside}: broken JSON ({error})") from None
    if not isinstance(document, dict) or document.get("overview_take") not in (1, VERSION):
        raise InputError(f'{beside}: not a take\'s changes ("overview_take": {VERSION} is missing)')
    if document["overview_take"] < VERSION:
        warn(
            f"{path}: of an older version, in which a release let the disk go at once; now the "
            "disk arrives first, so that it sounds different after a release",
            2,
        )
    rate = document.get("sample_rate")
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not rate > 0.0:
        raise InputError(f"{beside}: sample_rate is {rate!r}; must be a number above 0 (Hz)")
    listed = document.get("changes", [])
    if not isinstance(listed, list):
        raise InputError(f"{beside}: changes must be a list")
    changes: list[Change] = []
    played_s = None
    before = 0.0
    for index, entry in enumerate(listed):
        location = f"{beside}: changes[{index}]"
        if not isinstance(entry, dict) or (
            len(entry.keys() & set(CHANGES)) != 1 and not (growing and entry.keys() == {"sample"})
        ):
            raise InputError(f"{location} must be one of {', '.join(CHANGES)} with its sample")
        sample = entry.get("sample")
        if type(sample) is not int or not before <= sample / rate <= LONGEST_S:
            raise InputError(
                f"{location}.sample is {sample!r}; samples must increase, from 0 to {LONGEST_S:g} s"
            )
        before = sample / rate
        what = {key: value for key, value in entry.items() if key != "sample"}
        if what:
            changes.append(Change(before, what))
        else:
            played_s = before
    return TakeDocument(tuple(changes), played_s)


def _cut_short(text: bytes) -> Any:
    """Return the document of an interrupted take's lines, or None."""
    *lines, _ = text.split(b"\n")  # the last line may be incomplete
    try:
        head, *entries = [json.loads(line) for line in lines]
    except (ValueError, RecursionError):
        return None
    return {**head, "changes": entries} if isinstance(head, dict) else None
