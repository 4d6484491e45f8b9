"""Subtitles as events: SubRip (`00:00:01,000 --> 00:00:04,000`) and WebVTT cues.

A cue is an event where it begins: of the kind `cue`, or of what a caption in brackets says
(`[Applause]` is `applause`); its text is the label, without marks of style.
"""

from __future__ import annotations

import html
import re

from overview_dsp import validation
from overview_dsp.errors import InputError, shown
from overview_dsp.readers.everyday.listing import About, Listed, kind_of, timeline_of
from overview_dsp.readers.source import LoadOptions, Source
from overview_dsp.timeline.model import Timeline
from overview_dsp.timeline.times import clock_s

_TIMES = re.compile(
    r"\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})\s*-->\s*((?:\d+:)?\d{1,2}:\d{2}[.,]\d{1,3})(?:\s.*)?",
    re.ASCII,
)
_STYLE = re.compile(r"<[^>]*>|\{\\[^}]*\}")
_SOUND = re.compile(r"[\[(]([^\])]{1,40})[\])]")
_KIND = "cue"


def sniff(source: Source) -> bool:
    """Return whether the file is text with the arrow of a cue among its first lines."""
    text = source.head_text
    if text is None or "-->" not in text:
        return False
    return any(_TIMES.fullmatch(line) for line in text.splitlines()[:200])


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read cues (takes `duration_s`); InputError names the line."""
    text = source.text
    with validation.located(f"{source.where}: "):
        name = "WebVTT" if text.lstrip("\ufeff").startswith("WEBVTT") else "SubRip"
        listed = _listed(text.splitlines())
        return timeline_of(
            listed, About(source.stem, f"events: {name} cues", (), options.duration_s)
        )


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
