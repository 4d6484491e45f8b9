"""Cues as events: subtitles (SubRip, WebVTT), and label tracks of Audacity.

`00:00:01,000 --> 00:00:04,000`: a cue is an event where it begins: of the kind `cue`, or of what a
caption in brackets says (`[Applause]` is `applause`); its text is the label, without marks of
style.

`start<TAB>end<TAB>label` in seconds, one a line, no header: lines that begin with a backslash
(frequencies of a spectral selection) are skipped. A label is an event where it begins. Labels that
come again are kinds, others are what is said of a `label`.
"""

from __future__ import annotations

import html
import re

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.listing import (
    About,
    Listed,
    kind_of,
    kinds_or_labels,
    timeline_of,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import clock_s
from overview_dsp.errors import InputError, shown

_TIMES = re.compile(
    r"\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})\s*-->\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})(?:\s.*)?",
    re.ASCII,
)
_STYLE = re.compile(r"<[^>]*>|\{\\[^}]*\}")
_SOUND = re.compile(r"[\[(]([^\])]{1,40})[\])]")
_KIND = "cue"
_LABEL = re.compile(r"\s*(\d+(?:[.,]\d+)?)\t(\d+(?:[.,]\d+)?)(?:\t(.*))?", re.ASCII)
_WORD = re.compile(r"[^\W\d_]")


def sniff(source: DataFile) -> bool:
    """Return whether the file is text with the arrow of a cue among its first lines."""
    text = source.head_text
    if text is None or "-->" not in text:
        return False
    return any(_TIMES.fullmatch(line) for line in text.splitlines()[:200])


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read cues (takes `duration_s`); InputError names the line."""
    text = source.text
    with validation.located(f"{source.where}: "):
        name = "WebVTT" if text.lstrip("\ufeff").startswith("WEBVTT") else "SubRip"
        about = About(source.stem, f"events: {name} cues", (), options.duration_s)
        return timeline_of(_listed(text.splitlines()), about)


def _listed(lines: list[str]) -> list[Listed]:
    listed = []
    for i, line in enumerate(lines):
        if "-->" not in line:
            continue
        match = _TIMES.fullmatch(line)
        begin, end = (clock_s(match[k]) for k in (1, 2)) if match else (None, None)
        if begin is None or end is None:
            raise InputError(
                f"line {i + 1}: {shown(line)} isn't a cue's times; write "
                "00:01:02,500 --> 00:01:04,000"
            )
        words = []
        for following in lines[i + 1 :]:
            if not following.strip() or "-->" in following:
                break
            words.append(following)
        said = html.unescape(_STYLE.sub("", " ".join(words)))
        said = " ".join(said.split())
        sound = _SOUND.fullmatch(said)
        kind = kind_of(sound[1]) if sound else ""
        listed.append(Listed(begin, kind or _KIND, "" if kind else said, f"line {i + 1}", end))
    return listed


def sniff_labels(source: DataFile) -> bool:
    """Return whether all lines are labels, some of them in words."""
    if source.head_text is None or "\t" not in source.head_text:
        return False
    text = source.head_text
    lines = _lines(text if source.size <= len(source.head) else text[: text.rfind("\n")])
    found = [_LABEL.fullmatch(line) for _, line in lines]
    return (
        bool(found)
        and all(match and _seconds(match[1]) <= _seconds(match[2]) for match in found)
        and any(match and match[3] and _WORD.search(match[3]) for match in found)
    )


def read_labels(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a label track (takes `duration_s`); InputError names the line."""
    text = source.text
    with validation.located(f"{source.where}: "):
        listed = []
        for number, line in _lines(text):
            match = _LABEL.fullmatch(line)
            if match is None:
                raise InputError(
                    f"line {number}: {shown(line)} isn't start, end and label with tabs "
                    "between them"
                )
            begin, end, words = _seconds(match[1]), _seconds(match[2]), (match[3] or "").strip()
            listed.append(Listed(begin, words, "", f"line {number}", end))
        about = About(source.stem, "events: an Audacity label track", (), options.duration_s)
        return timeline_of(kinds_or_labels(listed, "label"), about)


def _lines(text: str) -> list[tuple[int, str]]:
    lines = enumerate(text.splitlines(), 1)
    return [(n, line) for n, line in lines if line.strip() and not line.startswith("\\")]


def _seconds(text: str) -> float:
    return float(text.replace(",", "."))
