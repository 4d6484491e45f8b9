"""Small made-up series as files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError

DAILY = "date,temp\n2020-01-01,3.5\n2020-01-02,4\n2020-01-03,2.25\n2020-01-04,6\n"
"""Four days."""


def load(folder: Path, text: str | bytes, name: str = "made.csv", **options: Any) -> Timeline:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_timeline(path, **options)


def values(timeline: Timeline) -> list[float]:
    assert timeline.intensity is not None
    return [float(value) for value in timeline.intensity.value]


def times(timeline: Timeline) -> list[float]:
    assert timeline.intensity is not None
    return [float(time) for time in timeline.intensity.time_s]


def refusal(read: Callable[[], Timeline]) -> str:
    """The one line that a reader refuses with."""
    with pytest.raises(InputError) as caught:
        read()
    words = str(caught.value)
    assert words.count("\n") <= 1  # the second line: what it comes nearest to
    return words


def noted(timeline: Timeline, words: str) -> bool:
    return any(words in note for note in timeline.notes)
