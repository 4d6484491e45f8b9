"""The small TOML files a person writes, read strictly.

Presets, the profiles of actuators and sensors, maps of controllers: what is wrong in one is said
with its file and line.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, did_you_mean, shown

SUFFIX = ".toml"
MAX_BYTES = 1_000_000
TEXTS = ("title", "description")


def read_text(path: Path) -> str:
    """The text of a file; InputError if it can't be read, is too large or no text."""
    try:
        data = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    if data is None:
        raise InputError(f"{path}: larger than {MAX_BYTES:,} bytes; it is a short TOML file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: not UTF-8 text (byte {error.start}); it is a TOML file"
        ) from None


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """The tables of a text; InputError if it isn't TOML."""
    try:
        return tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None


@contextmanager
def faults_at_their_line(text: str, source: str) -> Iterator[None]:
    """An InputError whose message begins with a key gets the file and line of that key."""
    try:
        yield
    except InputError as error:
        path = str(error).split(maxsplit=1)[0].rstrip(":;,").split(".")
        line = line_of(text, path)
        place = f"{source}:{line}" if line else source
        raise InputError(f"{place}: {error}") from None


def check_head(
    data: Mapping[str, Any], sections: Iterable[str], schema: int, needs_texts: bool
) -> None:
    """Check a profile's keys outside its sections: schema, title, description, nothing unknown.

    Raises
    ------
    InputError
        Its message begins with the key.
    """
    require_known(data, ("schema", *TEXTS, *sections))
    if "schema" not in data:
        raise InputError(f"schema is missing; it is {schema}")
    if data["schema"] != schema or isinstance(data["schema"], bool):
        raise InputError(f"schema = {shown(data['schema'])} is not known; this reads {schema}")
    for key in TEXTS:
        if key not in data:
            if needs_texts:
                raise InputError(f"{key} is missing; it is a line of text in quotes")
        elif not isinstance(data[key], str):
            raise InputError(
                f"{key} = {shown(data[key])} is no text; it is a line of text in quotes"
            )


def sections_of(ids: Iterable[str]) -> tuple[str, ...]:
    """The sections of ids, `section.key`, in order."""
    return tuple(dict.fromkeys(id.partition(".")[0] for id in ids))


def values_in(data: Mapping[str, Any], ids: Collection[str]) -> dict[str, Any]:
    """What a profile gives, by id; InputError, which begins with the key, for one not of `ids`."""
    values = {}
    for section in sections_of(ids):
        given = data.get(section, {})
        if not isinstance(given, dict):
            raise InputError(
                f"{section} = {shown(given)} is not allowed; it is a table: [{section}]"
            )
        known = [id.partition(".")[2] for id in ids if id.startswith(f"{section}.")]
        require_known(given, known, f"{section}.")
        values.update({f"{section}.{key}": value for key, value in given.items()})
    return values


def require_known(table: Iterable[str], known: Collection[str], before: str = "") -> None:
    """InputError, which begins with the key, for one that isn't known."""
    for key in table:
        if key not in known:
            raise InputError(f"{before}{format_key(key)}: unknown key{did_you_mean(key, known)}")


def format_key(key: str) -> str:
    """A key as an error names it: quoted where it may hold anything."""
    return key if key.isprintable() and not any(c.isspace() for c in key) else repr(key)


def line_of(text: str, path: Iterable[str | int]) -> int | None:
    """The line (from 1) that sets a key of a TOML text, or its nearest enclosing table."""
    parts = list(path)
    best: tuple[int, int] | None = None
    table: list[str | int] = []
    counts: dict[tuple[str | int, ...], int] = {}
    for number, line in enumerate(text.split("\n"), 1):
        bare = line.strip()
        header = re.match(r"(\[\[?)\s*([^\]]+?)\s*\]", bare)
        assigned = re.match(r"([A-Za-z0-9_\-.\"']+)\s*=", bare)
        if header:
            table = [part.strip().strip("\"'") for part in header[2].split(".")]
            if header[1] == "[[":
                index = counts.get(tuple(table), -1) + 1
                counts[tuple(table)] = index
                table = [*table, index]
            here = table
        elif assigned:
            here = [*table, *(part.strip("\"'") for part in assigned[1].split("."))]
        else:
            continue
        same = 0
        while same < min(len(here), len(parts)) and here[same] == parts[same]:
            same += 1
        if same == len(here) and same and (best is None or same > best[0]):
            best = (same, number)
    return best[1] if best else None
