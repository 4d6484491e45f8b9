"""Label tracks of Audacity: `start<TAB>end<TAB>label` in seconds, one a line, no header.

Lines that begin with a backslash (frequencies of a spectral selection) are skipped. A label is an
event where it begins. Labels that come again are kinds, others are what is said of a `label`.
"""

from __future__ import annotations

import re

from overview_dsp import validation
from overview_dsp.errors import InputError, shown
from overview_dsp.readers.everyday.listing import About, Listed, are_kinds, timeline_of
from overview_dsp.readers.source import LoadOptions, Source
from overview_dsp.timeline.model import Timeline

_LINE = re.compile(r"\s*(\d+(?:[.,]\d+)?)\t(\d+(?:[.,]\d+)?)(?:\t(.*))?", re.ASCII)
_WORD = re.compile(r"[^\W\d_]")


def sniff(source: Source) -> bool:
    """Return whether all lines are labels, some of them in words."""
    if source.head_text is None or "\t" not in source.head_text:
        return False
    text = source.head_text
    lines = _lines(text if source.size <= len(source.head) else text[: text.rfind("\n")])
    found = [_LINE.fullmatch(line) for _, line in lines]
    return (
        bool(found)
        and all(match and _seconds(match[1]) <= _seconds(match[2]) for match in found)
        and any(match and match[3] and _WORD.search(match[3]) for match in found)
    )


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read a label track (takes `duration_s`); InputError names the line."""
    text = source.text
    with validation.located(f"{source.where}: "):
        rows = []
        for number, line in _lines(text):
            match = _LINE.fullmatch(line)
            if match is None:
                raise InputError(
                    f"line {number}: {shown(line)} isn't start, end and label with tabs "
                    "between them"
                )
            rows.append((number, _seconds(match[1]), _seconds(match[2]), (match[3] or "").strip()))
        few = are_kinds([label for *_, label in rows])
        listed = [
            Listed(start, label if few else "label", "" if few else label, f"line {number}", end)
            for number, start, end, label in rows
        ]
        return timeline_of(
            listed, About(source.stem, "events: an Audacity label track", (), options.duration_s)
        )


def _lines(text: str) -> list[tuple[int, str]]:
    lines = enumerate(text.splitlines(), 1)
    return [(n, line) for n, line in lines if line.strip() and not line.startswith("\\")]


def _seconds(text: str) -> float:
    return float(text.replace(",", "."))
