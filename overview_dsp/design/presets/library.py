"""Library of presets: bundled and user presets by name, other presets by path, and their tags."""

from __future__ import annotations

import operator
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.design.presets.model import TAG_SCALES, Preset
from overview_dsp.design.presets.validation import parse_preset
from overview_dsp.errors import InputError, warn
from overview_dsp.files.library import Library
from overview_dsp.files.toml import MAX_BYTES, SUFFIX, read_text
from overview_dsp.public import counted

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


def preset_path(name: str | Path) -> Path:
    """Return the file of a preset, by name or path; InputError if no such preset or file exists."""
    return LIBRARY.path(name)


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
FOR_ALL = "plain"  # preset for all other data


class Fit(NamedTuple):
    """Preset that is chosen, and the numbers of kinds that it names and that there are."""

    preset: str
    named: int
    kinds: int

    def __str__(self) -> str:
        kinds = f"{self.named} of {counted(self.kinds, 'event kind')}" if self.kinds else "a curve"
        return f"preset {self.preset} fits the data best, with {kinds}"


def fitting_preset(kinds: Mapping[str, int], unit: str = "") -> Fit:
    """Return the bundled or user preset that names most of the events.

    It is `plain` if none names at least half of the events other than ticks. `kinds` has the number
    of events of each kind; none: a series, or a recording without cheers. `unit` is that of the
    curve. Of equal presets, one whose file sets `tags.data` comes first, then
    the user's, then one that names more of the kinds without aliases.
    """
    counts = {kind: n for kind, n in kinds.items() if kind not in TICKS} or dict(kinds)
    wanted = "events" if counts else "recordings" if unit == LOUDNESS_UNIT else "series"
    best, most = load_preset(FOR_ALL), (0, False, False, 0)
    for preset, is_user in _candidates():
        named = sum(n for kind, n in counts.items() if preset.kind_for(kind))
        fits = 2 * named >= sum(counts.values()) if counts else wanted in preset.tags.data
        direct = len(counts.keys() & preset.kinds)
        if fits and (rank := (named, bool(preset.tags.data), is_user, direct)) > most:
            best, most = preset, rank
    return Fit(best.name, sum(best.kind_for(kind) is not None for kind in counts), len(counts))


def _candidates() -> Iterator[tuple[Preset, bool]]:
    """Yield the presets that may be chosen, and whether they are the user's."""
    for name in LIBRARY.bundled:
        if (preset := load_preset(name)).tags.data:
            yield preset, False
    for name in LIBRARY.user:
        try:
            yield load_preset(name), True
        except InputError as error:
            warn(f"not considered for these data: {error}", 3)


def fitting_preset_for(timeline: Timeline) -> Fit:
    """Return the preset for the kinds of a timeline (`fitting_preset`)."""
    curve = timeline.intensity
    return fitting_preset(timeline.kinds(), "" if curve is None else curve.unit)


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
