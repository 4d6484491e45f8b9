"""Library of presets: bundled and user presets by name, other presets by path, and their tags."""

from __future__ import annotations

import operator
import os
import re
from collections.abc import Mapping
from pathlib import Path

from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.design.presets.model import TAG_SCALES, Preset
from overview_dsp.design.presets.validation import parse_preset
from overview_dsp.errors import InputError
from overview_dsp.files.library import Library
from overview_dsp.files.toml import MAX_BYTES, SUFFIX, read_text

FOR_DATA = ("football", "series", "heart", "crowd")
"""Bundled presets for one type of data each; `plain` is for all other data."""

LIBRARY = Library("presets", "a preset", "OVERVIEW_PRESETS")


def bundled_presets() -> tuple[str, ...]:
    """List the bundled presets.

    Returns
    -------
    tuple of str
        Names, sorted.

    Examples
    --------
    >>> "football" in ov.bundled_presets()
    True
    """
    return LIBRARY.bundled


def user_presets() -> tuple[str, ...]:
    """List the user presets, in the folder of the user's configuration.

    Returns
    -------
    tuple of str
        Names, sorted; a bundled name always refers to the bundled preset.

    Examples
    --------
    >>> import os
    >>> os.environ["OVERVIEW_PRESETS"] = "."  # another folder
    >>> path = ov.presets.save(ov.load_preset("football"), "mine.toml")
    >>> ov.presets.user_presets()
    ('mine',)
    >>> del os.environ["OVERVIEW_PRESETS"]
    """
    return LIBRARY.user


preset_path = LIBRARY.path


def load_preset(name: str | Path) -> Preset:
    """Load a preset.

    Parameters
    ----------
    name : str or path
        Name of a bundled or user preset (`football`), or path of a TOML file.

    Returns
    -------
    Preset
        Preset with all values of the presets that it extends.

    Raises
    ------
    InputError
        No such preset, or one that is not valid; the error names file, line, key and range.

    Examples
    --------
    >>> ov.load_preset("football").title
    'Football'
    >>> ov.load_preset("futball")
    Traceback (most recent call last):
    overview_dsp.errors.InputError: no preset is called 'futball'; did you mean 'football'? ...
    """
    path = preset_path(name)
    return parse_preset(read_text(path), path.stem, str(path), _base)


def parse_user_preset(text: str, path: Path) -> Preset:
    """Return the preset of a text for the file `path`; InputError if it is not valid."""
    if len(text.encode()) > MAX_BYTES:
        raise InputError(
            f"{path.name}: size is {len(text.encode()):,} bytes; must be at most {MAX_BYTES:,}"
        )
    return parse_preset(text, path.stem, str(path), _base)


LOUDNESS_UNIT = "LUFS"  # unit of a recording's curve


def best_preset(kinds: Mapping[str, int], unit: str = "") -> str:
    """Return the bundled preset that names most of these kinds of events.

    It is `plain` if none names at least half of the events other than ticks. `kinds` has the number
    of events of each kind; none: a series, or a recording without cheers. `unit` is that of the
    curve.
    """
    if not kinds:
        return "crowd" if unit == LOUDNESS_UNIT else "series"
    counts = {kind: n for kind, n in kinds.items() if kind not in TICKS} or dict(kinds)
    best, most = "plain", 0
    for name in FOR_DATA:
        preset = load_preset(name)
        named = sum(n for kind, n in counts.items() if preset.kind_for(kind))
        if named > most:
            best, most = name, named
    return best if 2 * most >= sum(counts.values()) else "plain"


def best_preset_for(timeline: Timeline) -> str:
    """Return the bundled preset for the kinds of a timeline (`best_preset`)."""
    curve = timeline.intensity
    return best_preset(timeline.kinds(), "" if curve is None else curve.unit)


def _base(name: str, source: str) -> tuple[str, str]:
    """Return file and text of an extended preset: a name, or a path relative to the file."""
    beside = Path(source).parent / name
    is_file = beside.suffix == SUFFIX and os.path.isfile(beside)
    path = beside if is_file else preset_path(name)
    return str(path), read_text(path)


_COMPARED = {"=": operator.eq, "<": operator.lt, ">": operator.gt}
_SCALE = re.compile(r"(?P<name>\w+)\s*(?P<sign>[=<>])\s*(?P<value>[1-5])")
TAG_FORMS = (
    f"a use (football), or {', '.join(TAG_SCALES)} with =, < or > and 1 to 5 (energy=4, tempo<3)"
)


def check_tag(tag: str) -> None:
    """Raise InputError for an unknown scale or a value out of range."""
    if any(sign in tag for sign in _COMPARED):
        found = _SCALE.fullmatch(tag.strip())
        if not found or found["name"] not in TAG_SCALES:
            raise InputError(f"--tag {tag!r} is not valid; allowed: {TAG_FORMS}")


def has_tag(preset: Preset, tag: str) -> bool:
    """Return whether a preset has a tag that `check_tag` accepts."""
    found = _SCALE.fullmatch(tag.strip())
    if found is None:
        return is_for_use(preset, tag)
    value = getattr(preset.tags, found["name"])
    return value is not None and bool(_COMPARED[found["sign"]](value, int(found["value"])))


def is_for_use(preset: Preset, use: str) -> bool:
    """Return whether a use is the name of a preset, one of its uses, or a word of these."""
    wanted = use.strip().casefold()
    names = [preset.name, *preset.tags.usage]
    words = {word.casefold() for name in names for word in re.findall(r"\w+", name)}
    return bool(wanted) and (
        wanted in words
        or wanted.removesuffix("s") in words
        or any(wanted == name.casefold() for name in names)
    )
