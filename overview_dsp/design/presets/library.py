"""Where presets are: the bundled ones and a person's own by name, any other by its path.

Which presets are like a tag, or for a use.
"""

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
"""The bundled presets made for a sort of data; `plain` is for what none of them names."""

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


def own_names() -> tuple[str, ...]:
    """List a person's own presets, which lie in a folder of the user's configuration.

    Returns
    -------
    tuple of str
        Names, sorted; a bundled name stays the bundled preset's.

    Examples
    --------
    >>> import os
    >>> os.environ["OVERVIEW_PRESETS"] = "."  # the folder, where it is another one
    >>> path = ov.presets.save(ov.load_preset("football"), "mine.toml")
    >>> ov.presets.own()
    ('mine',)
    >>> del os.environ["OVERVIEW_PRESETS"]
    """
    return LIBRARY.user


def preset_path(name: str | Path) -> Path:
    """The file of a preset given by name or path.

    Raises
    ------
    InputError
        There is no such preset or file.
    """
    return LIBRARY.path(name)


def load_preset(name: str | Path) -> Preset:
    """Load a preset.

    Parameters
    ----------
    name : str or path
        A bundled or own name (`football`), or the path of a TOML file.

    Returns
    -------
    Preset
        Complete: what it extends is in it.

    Raises
    ------
    InputError
        No such preset, or one that is not valid: names file, line, key and range.

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


def parse_own(text: str, path: Path) -> Preset:
    """The preset of a text that is to be the file `path`; InputError if it isn't valid."""
    if len(text.encode()) > MAX_BYTES:
        raise InputError(f"{path.name}: larger than {MAX_BYTES:,} bytes; it is a short TOML file")
    return parse_preset(text, path.stem, str(path), _base)


LOUDNESS_UNIT = "LUFS"
"""In which the curve of a recording is."""


def fitting(kinds: Mapping[str, int], unit: str = "") -> str:
    """The bundled preset made for data with these kinds of events: the one that names most of them.

    `plain` where none names at least half of them, ticks aside.

    Parameters
    ----------
    kinds
        How many events there are of each kind; none is a series, or a recording without a cheer.
    unit
        The curve's.
    """
    if not kinds:
        return "crowd" if unit == LOUDNESS_UNIT else "series"
    told = {kind: n for kind, n in kinds.items() if kind not in TICKS} or dict(kinds)
    best, most = "plain", 0
    for name in FOR_DATA:
        preset = load_preset(name)
        named = sum(n for kind, n in told.items() if preset.kind_for(kind))
        if named > most:
            best, most = name, named
    return best if 2 * most >= sum(told.values()) else "plain"


def fitting_preset(timeline: Timeline) -> str:
    """The bundled preset made for data like a timeline's (`fitting`)."""
    curve = timeline.intensity
    return fitting(timeline.kinds(), "" if curve is None else curve.unit)


def _base(name: str, source: str) -> tuple[str, str]:
    """What a file extends: a name, or a path from where the file is."""
    beside = Path(source).parent / name
    is_file = beside.suffix == SUFFIX and os.path.isfile(beside)
    path = beside if is_file else preset_path(name)
    return str(path), read_text(path)


_COMPARED = {"=": operator.eq, "<": operator.lt, ">": operator.gt}
_SCALE = re.compile(r"(?P<name>\w+)\s*(?P<sign>[=<>])\s*(?P<value>[1-5])")
WAYS = f"a use (football), or {', '.join(TAG_SCALES)} with =, < or > and 1 to 5 (energy=4, tempo<3)"


def require_tag(tag: str) -> None:
    """InputError for a scale that there isn't, or a value that no scale has."""
    if any(sign in tag for sign in _COMPARED):
        found = _SCALE.fullmatch(tag.strip())
        if not found or found["name"] not in TAG_SCALES:
            raise InputError(f"--tag {tag!r} is none; it is {WAYS}")


def tagged(preset: Preset, tag: str) -> bool:
    """Whether a preset has a tag, as `require_tag` allows it."""
    found = _SCALE.fullmatch(tag.strip())
    if found is None:
        return serves(preset, tag)
    value = getattr(preset.tags, found["name"])
    return value is not None and bool(_COMPARED[found["sign"]](value, int(found["value"])))


def serves(preset: Preset, use: str) -> bool:
    """Whether a preset is for a use: its name, or a word or all of one of its uses, says so."""
    wanted = use.strip().casefold()
    names = [preset.name, *preset.tags.usage]
    words = {word.casefold() for name in names for word in re.findall(r"\w+", name)}
    return bool(wanted) and (
        wanted in words
        or wanted.removesuffix("s") in words
        or any(wanted == name.casefold() for name in names)
    )
