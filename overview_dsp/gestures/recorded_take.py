"""Recorded takes: what a kernel applied, sample by sample, and what else changed meanwhile.

The CSV has the columns of any take and `sample`, `sample_rate` and `source`; a JSON of the same
name beside it holds the stamped parameter and surface changes::

    {"overview_take": 1, "sample_rate": 48000.0, "seed": 0, "title": "...", "preset": "football",
     "changes": [{"sample": 9600, "set": {"tactor.gain_db": -6.0}},
                 {"sample": 24000, "window": [0.0, 2700.0]},
                 {"sample": 48000, "preset": {...}}]}
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import whole_file
from overview_dsp.gestures.model import LONGEST_S, SOURCES, Change

COLUMNS = ("time_s", "theta2_rad", "touching", "sample", "sample_rate", "source")
CHANGES = ("set", "preset", "window")
VERSION = 1


def save_take(
    path: str | os.PathLike[str],
    events: Iterable[tuple[int, int, float, bool]],
    sample_rate: float,
    about: Mapping[str, Any],
    changes: Iterable[tuple[int, Mapping[str, Any]]],
) -> None:
    """Write a recorded take and its JSON, each whole or not at all.

    Parameters
    ----------
    path
        The CSV's; the JSON's has the suffix `.json`.
    events
        Sample, source (index of `SOURCES`), theta2 (rad), touching; in order.
    about
        What was played: `seed`, and words for a person (`title`, `preset`).
    changes
        Sample and change, in order.

    Raises
    ------
    InputError, OutputError
        An unwritable place, a full disk.
    """
    path = Path(path)
    document = {
        "overview_take": VERSION,
        "sample_rate": sample_rate,
        **about,
        "changes": [{"sample": sample, **what} for sample, what in changes],
    }
    with whole_file(path.with_suffix(".json")) as temporary:
        text = json.dumps(document, ensure_ascii=False, allow_nan=False)
        temporary.write_text(text, encoding="utf-8")
    with whole_file(path) as temporary, open(temporary, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        rate = repr(float(sample_rate))
        for sample, source, theta2, touching in events:
            time_s = repr(sample / sample_rate)
            writer.writerow(
                [time_s, repr(float(theta2)), int(touching), sample, rate, SOURCES[source]]
            )


def load_changes(path: Path) -> tuple[Change, ...]:
    """The changes beside a recorded take's CSV.

    Raises
    ------
    InputError
        No JSON there, or one that doesn't hold a take's changes: names the file and the place.
    """
    beside = path.with_suffix(".json")
    try:
        document = json.loads(beside.read_bytes())
    except FileNotFoundError:
        raise InputError(
            f"{path}: a recorded take, but {beside.name} with its parameter changes isn't beside "
            "it; put it there, or delete the columns sample, sample_rate and source"
        ) from None
    except OSError as error:
        raise InputError(f"{beside}: can't be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{beside}: broken JSON ({error})") from None
    if not isinstance(document, dict) or document.get("overview_take") != VERSION:
        raise InputError(f'{beside}: not a take\'s changes ("overview_take": {VERSION} is missing)')
    rate = document.get("sample_rate")
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not rate > 0.0:
        raise InputError(f"{beside}: sample_rate is {rate!r}; it is a number above 0, Hz")
    listed = document.get("changes", [])
    if not isinstance(listed, list):
        raise InputError(f"{beside}: changes isn't a list")
    changes: list[Change] = []
    for index, entry in enumerate(listed):
        place = f"{beside}: changes[{index}]"
        if not isinstance(entry, dict) or len(entry.keys() & set(CHANGES)) != 1:
            raise InputError(f"{place} isn't one of {', '.join(CHANGES)} with its sample")
        sample = entry.get("sample")
        before = changes[-1].time_s if changes else 0.0
        if (
            isinstance(sample, bool)
            or not isinstance(sample, int)
            or not before <= sample / rate <= LONGEST_S
        ):
            raise InputError(
                f"{place}.sample is {sample!r}; samples count up, from 0 to {LONGEST_S:g} s"
            )
        what = {key: value for key, value in entry.items() if key != "sample"}
        changes.append(Change(sample / rate, what))
    return tuple(changes)
