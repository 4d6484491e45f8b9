"""Readers of cues: subtitles (SubRip, WebVTT) and label tracks of Audacity.

A cue of a subtitle file, `00:00:01,000 --> 00:00:04,000`, is an event at its start. Its kind is
`cue` or the caption in brackets (`[Applause]` is `applause`). Its text without formatting is the
label.

A label track has lines `start<TAB>end<TAB>label`, with times in seconds and without a header.
Lines that begin with a backslash (frequencies of a spectral selection) are skipped. A label is an
event at its start. Labels that are repeated are event kinds; otherwise each is an event of the
kind `label` with this label.
"""

from __future__ import annotations

import html
import itertools
import re

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import (
    ListDescription,
    ListEntry,
    kind_of,
    timeline_of,
    with_kinds,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import clock_s
from overview_dsp.errors import InputError, quoted

_TIMES = re.compile(
    r"\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})\s*-->\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})(?:\s.*)?",
    re.ASCII,
)
_STYLE = re.compile(r"<[^>]*>|\{\\[^}]*\}")
_SOUND = re.compile(r"[\[(]([^\])]{1,40})[\])]")
_KIND = "cue"
_LABEL = re.compile(r"\s*(\d+(?:[.,]\d+)?)\t(\d+(?:[.,]\d+)?)(?:\t(.*))?", re.ASCII)
_LETTER = re.compile(r"[^\W\d_]")


def sniff(source: DataFile) -> bool:
    """Return whether the file is text with the times of a cue in its first lines."""
    text = source.head_text
    if text is None or "-->" not in text:
        return False
    return any(_TIMES.fullmatch(line) for line in text.splitlines()[:200])


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read cues (takes `duration_s`); the InputError contains the line."""
    text = source.text
    name = "WebVTT" if text.lstrip("\ufeff").startswith("WEBVTT") else "SubRip"
    description = ListDescription(source.stem, f"events: {name} cues", (), options.duration_s)
    return timeline_of(_listed(text.splitlines()), description)


def _listed(lines: list[str]) -> list[ListEntry]:
    listed = []
    for i, line in enumerate(lines):
        if "-->" not in line:
            continue
        match = _TIMES.fullmatch(line)
        begin, end = (clock_s(match[k]) for k in (1, 2)) if match else (None, None)
        if begin is None or end is None:
            raise InputError(
                f"line {i + 1}: {quoted(line)} is not the time of a cue; must have the form "
                "00:01:02,500 --> 00:01:04,000"
            )
        following = itertools.takewhile(lambda ln: ln.strip() and "-->" not in ln, lines[i + 1 :])
        text = " ".join(html.unescape(_STYLE.sub("", " ".join(following))).split())
        sound = _SOUND.fullmatch(text)
        kind = kind_of(sound[1]) if sound else ""
        listed.append(ListEntry(begin, kind or _KIND, "" if kind else text, f"line {i + 1}", end))
    return listed


def sniff_labels(source: DataFile) -> bool:
    """Return whether all lines are labels, and some contain letters."""
    if source.head_text is None or "\t" not in source.head_text:
        return False
    text = source.head_text
    lines = _lines(text if source.size <= len(source.head) else text[: text.rfind("\n")])
    labels = [_LABEL.fullmatch(line) for _, line in lines]
    return all(match and _seconds(match[1]) <= _seconds(match[2]) for match in labels) and any(
        match and match[3] and _LETTER.search(match[3]) for match in labels
    )


def read_labels(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a label track (takes `duration_s`); the InputError contains the line."""
    text = source.text
    listed = []
    for number, line in _lines(text):
        match = _LABEL.fullmatch(line)
        if match is None:
            raise InputError(
                f"line {number}: {quoted(line)} is not a label; must be start, end and label, "
                "separated by tabs"
            )
        begin, end, label = _seconds(match[1]), _seconds(match[2]), (match[3] or "").strip()
        listed.append(ListEntry(begin, label, "", f"line {number}", end))
    description = ListDescription(
        source.stem, "events: an Audacity label track", (), options.duration_s
    )
    return timeline_of(with_kinds(listed, "label"), description)


def _lines(text: str) -> list[tuple[int, str]]:
    lines = enumerate(text.splitlines(), 1)
    return [(n, line) for n, line in lines if line.strip() and not line.startswith("\\")]


def _seconds(text: str) -> float:
    return float(text.replace(",", "."))
