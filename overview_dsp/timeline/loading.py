"""Any supported file, told by its content, into a Timeline.

A new format is one module with `sniff(source) -> bool` and `read(source, options) -> Timeline`, and
one entry in `FORMATS`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks, events_csv, native, statsbomb
from overview_dsp.timeline.model import Timeline
from overview_dsp.timeline.source import LoadOptions, Source, decode_text, parse_json


@dataclass(frozen=True)
class Format:
    """A file format and its reader.

    Parameters
    ----------
    name
        What an error line calls it.
    sniff
        Tells from the source whether it is this format; cheap, never by the file's name.
    read
        Makes the Timeline; errors begin with the file's path.
    options
        The names of the `LoadOptions` it takes.
    """

    name: str
    sniff: Callable[[Source], bool]
    read: Callable[[Source, LoadOptions], Timeline]
    options: frozenset[str] = frozenset()


FORMATS: tuple[Format, ...] = (
    Format(
        'native timeline (JSON with the key "overview_timeline")',
        native.sniff,
        native.read,
    ),
    Format(
        "StatsBomb events (JSON list with period, timestamp and type)",
        statsbomb.sniff,
        statsbomb.read,
    ),
    Format(
        "event list (CSV with the columns time_s and kind)",
        events_csv.sniff,
        events_csv.read,
        frozenset({"duration_s"}),
    ),
)
"""The formats that can be read, asked in this order."""

BUNDLED: dict[str, str] = {
    "world-cup-final-2018": "world_cup_final_2018.json",
    "made-up-share": "made_up_share.json",
}
"""Timelines that come with the package: name and file."""

_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")


def load_timeline(
    path: str | os.PathLike[str],
    duration_s: float | None = None,
    *,
    value: str | None = None,
    time: str | None = None,
    map: str | None = None,
    rate: float | None = None,
    match: str | None = None,
    max_mb: float | None = None,
) -> Timeline:
    """Load a timeline from any supported file, or a bundled one by its name.

    Parameters
    ----------
    path
        A file, told by its content; or a name of `BUNDLED` (for a file of that name, write
        `./world-cup-final-2018`).
    duration_s
        Length in s, for a format that takes it (event lists).
    value, time, map, rate, match, max_mb
        As `LoadOptions` says, each for the formats that take it.

    Raises
    ------
    InputError
        One line: what is wrong, where, what is known, what to try.
    """
    options = LoadOptions(
        duration_s=_positive(duration_s, "duration_s", "a duration is seconds"),
        value=_words(value, "value"),
        time=_words(time, "time"),
        map=_words(map, "map"),
        rate=_positive(rate, "rate", "a rate is samples a second"),
        match=_words(match, "match"),
        max_mb=_positive(max_mb, "max_mb", "a limit is megabytes"),
    )
    try:
        name = os.fspath(path)
    except TypeError as error:
        raise InputError(
            f"{checks.shown(path)} is neither a path nor a bundled name ({_bundled_names()})"
        ) from error
    if name in BUNDLED:
        _refuse_options(options, name, frozenset())
        return bundled_timeline(name)
    try:
        source = Source.open(path)
    except InputError as error:
        missing = isinstance(error.__cause__, FileNotFoundError)
        hint = f", or use a bundled name ({_bundled_names()})" if missing else ""
        raise InputError(f"{error}{hint}") from error
    for candidate in FORMATS:
        if candidate.sniff(source):
            _refuse_options(options, f"{source.where}: {candidate.name}", candidate.options)
            return candidate.read(source, options)
    known = "; ".join(candidate.name for candidate in FORMATS)
    raise InputError(
        f"{source.where}: {_described(source)}, not a format that can be read. Known: {known}. "
        "Convert the data to one of these"
    )


def bundled_timeline(name: str = "world-cup-final-2018") -> Timeline:
    """Load a timeline that comes with the package; InputError names the known ones."""
    if name not in BUNDLED:
        raise InputError(
            f"no bundled timeline is called {checks.shown(name)}; there is {_bundled_names()}"
        )
    data = (resources.files("overview_dsp.timeline") / "bundled" / BUNDLED[name]).read_bytes()
    return native.decode(parse_json(decode_text(data, name), name), name)


def _bundled_names() -> str:
    return ", ".join(BUNDLED)


def _positive(given: float | None, name: str, meaning: str) -> float | None:
    if given is None:
        return None
    return checks.positive(given, name, f"{meaning}, a finite number above 0")


def _words(given: str | None, name: str) -> str | None:
    return None if given is None else checks.text(given, name)


def _refuse_options(options: LoadOptions, what: str, taken: frozenset[str]) -> None:
    for option in sorted(options.given() - taken):
        raise InputError(f"{what}: {option} can't be given, the format holds it; leave it out")


def _described(source: Source) -> str:
    """Say what an unknown file seems to be."""
    if source.head_text is None:
        binary = _CONTROL.search(source.head) is not None
        return "binary data" if binary else "text that isn't UTF-8 (save it as UTF-8)"
    if not source.head_text.strip():
        return "a text file of blanks only"
    if not source.looks_like_json:
        first = source.head_text.strip().splitlines()[0]
        return f"text that begins {checks.shown(first)}"
    document = source.json
    if isinstance(document, dict):
        keys = ", ".join(checks.shown(key) for key in list(document)[:6])
        return f"a JSON object with the keys {keys or '(none)'}"
    return f"a JSON list of {len(document) if isinstance(document, list) else 0} entries"
