"""Inputs with their truths: each is read right, or refused in one line that names the remedy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import overview_dsp as ov


@dataclass(frozen=True)
class Series:
    """The values of a curve, the seconds from the first to each, its start and its unit."""

    values: Sequence[float]
    seconds: Sequence[float]
    start: str | None = None
    unit: str | None = None
    noted: str = ""


@dataclass(frozen=True)
class Events:
    """The seconds and kinds of events, and the start of the timeline."""

    seconds: Sequence[float]
    kinds: Sequence[str] = ()
    start: str | None = None
    noted: str = ""
    duration_s: float | None = None


@dataclass(frozen=True)
class Refused:
    """Words of the one line."""

    words: tuple[str, ...]


@dataclass(frozen=True)
class Input:
    """A file's content or an object (made when it is read), options, and what is true of it."""

    name: str
    data: str | bytes | Callable[[], Any]
    truth: Series | Events | Refused
    options: dict[str, Any] = field(default_factory=dict)
    file: str = "made.csv"


def parametrized(*tables: Sequence[Input]) -> Any:
    """Return the inputs as parameters of a test."""
    every = [one for table in tables for one in table]
    return pytest.mark.parametrize("made", every, ids=[one.name for one in every])


def check(made: Input, folder: Path) -> None:
    """Fail unless the input is read as it is, or refused with the words that it needs."""
    data: Any = made.data() if callable(made.data) else made.data
    if isinstance(made.data, str | bytes):
        path = folder / made.file
        path.write_bytes(made.data if isinstance(made.data, bytes) else made.data.encode())
        data = path
    if isinstance(made.truth, Refused):
        with pytest.raises(ov.InputError) as caught:
            ov.load_timeline(data, **made.options)
        line = str(caught.value)
        assert "\n" not in line.replace("\nnearest: ", "; ")
        for words in made.truth.words:
            assert words in line, line
        return
    timeline = ov.load_timeline(data, **made.options)
    if made.truth.start is not None:
        assert timeline.start is not None
        assert timeline.start.isoformat() == made.truth.start
    told = [timeline.provenance, *timeline.notes]
    assert not made.truth.noted or any(made.truth.noted in line for line in told), told
    if isinstance(made.truth, Events):
        assert [event.time_s for event in timeline.events] == pytest.approx(made.truth.seconds)
        kinds = [event.kind for event in timeline.events]
        assert not made.truth.kinds or kinds == list(made.truth.kinds)
        if made.truth.duration_s is not None:
            assert timeline.duration_s == pytest.approx(made.truth.duration_s)
        return
    curve = timeline.intensity
    assert curve is not None
    np.testing.assert_allclose(curve.value, made.truth.values, rtol=1e-6)
    np.testing.assert_allclose(curve.time_s, made.truth.seconds, rtol=1e-12, atol=1e-9)
    assert made.truth.unit is None or curve.unit == made.truth.unit
