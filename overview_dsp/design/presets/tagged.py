"""Which presets are like a tag, or for a use."""

from __future__ import annotations

import operator
import re

from overview_dsp.design.presets.model import TAG_SCALES, Preset
from overview_dsp.errors import InputError

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
