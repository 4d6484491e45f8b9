"""Strict reading of small TOML files: presets, profiles of actuators and sensors, control maps.

Each error names file and line.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, did_you_mean, quoted

SUFFIX = ".toml"
MAX_BYTES = 1_000_000
TEXTS = ("title", "description")


def read_text(path: Path) -> str:
    """Read the text of a file; InputError if it can't be read, is too large or isn't UTF-8."""
    try:
        data = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    if data is None:
        raise InputError(f"{path}: larger than {MAX_BYTES:,} bytes, the limit for a TOML file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start})") from None


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Parse a TOML text; InputError with the name `source` if it isn't TOML."""
    try:
        return tomllib.loads(text)
    # ValueError: not TOML, or an integer with thousands of digits
    except (ValueError, RecursionError) as error:
        reason, place = str(error), re.search(r" \(at line (\d+), column (\d+)\)$", str(error))
        if place is None:
            raise InputError(f"{source}: not TOML: {reason}") from None
        remedy = "; remove one of the two" if "overwrite" in reason else ""
        reason = f"{reason[: place.start()]}, before column {place[2]}{remedy}"
        raise InputError(f"{source}:{place[1]}: not TOML: {reason}") from None


def load_toml(module: str, name: str) -> dict[str, Any]:
    """Return the table in the TOML file `name` of this package, beside the file of a module."""
    return tomllib.loads(Path(module).with_name(name).read_text(encoding="utf-8"))


@contextmanager
def faults_at_their_line(text: str, source: str) -> Iterator[None]:
    """Prefix an InputError whose message begins with a key with the file and line of that key."""
    try:
        yield
    except InputError as error:
        path = str(error).split(maxsplit=1)[0].rstrip(":;,").split(".")
        line = line_of(text, path)
        raise InputError(f"{source}:{line}: {error}" if line else f"{source}: {error}") from None


def check_head(
    data: Mapping[str, Any], sections: Iterable[str], schema: int, needs_texts: bool
) -> None:
    """Check the keys outside a profile's sections: `schema`, `title`, `description`; InputError."""
    require_known(data, ("schema", *TEXTS, *sections))
    if "schema" not in data:
        raise InputError(f"schema is missing; must be {schema}")
    if data["schema"] != schema or isinstance(data["schema"], bool):
        raise InputError(f"schema = {quoted(data['schema'])}; must be {schema}")
    for key in TEXTS:
        if key not in data:
            if needs_texts:
                raise InputError(f"{key} is missing; must be text in quotes")
        elif not isinstance(data[key], str):
            raise InputError(f"{key} = {quoted(data[key])}; must be text in quotes")


def sections_of(ids: Iterable[str]) -> tuple[str, ...]:
    """Return the sections of ids (`section.key`), in order."""
    return tuple(dict.fromkeys(id.partition(".")[0] for id in ids))


def values_in(data: Mapping[str, Any], ids: Collection[str]) -> dict[str, Any]:
    """Return the values of a profile by id; InputError, which begins with the key, if unknown."""
    values = {}
    for section in sections_of(ids):
        table = data.get(section, {})
        if not isinstance(table, dict):
            raise InputError(f"{section} = {quoted(table)}; must be a table: [{section}]")
        known = [id.partition(".")[2] for id in ids if id.startswith(f"{section}.")]
        require_known(table, known, f"{section}.")
        values.update({f"{section}.{key}": value for key, value in table.items()})
    return values


def require_known(table: Iterable[str], known: Collection[str], prefix: str = "") -> None:
    """Refuse unknown keys with an InputError that begins with the key."""
    for key in table:
        if key not in known:
            plain = key.isprintable() and not any(c.isspace() for c in key)
            text = key if plain else repr(key)
            raise InputError(f"{prefix}{text}: unknown key{did_you_mean(key, known)}")


def line_of(text: str, path: Iterable[str | int]) -> int | None:
    """Return the line (from 1) of a key in a TOML text, or of its nearest enclosing table."""
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
        if here == parts[: len(here)] and (best is None or len(here) > best[0]):
            best = (len(here), number)
    return best[1] if best else None
