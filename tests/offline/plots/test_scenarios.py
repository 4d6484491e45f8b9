"""The paper's two scenarios, as the guide has them."""

from __future__ import annotations

import re
import shlex
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.data.timeline.time_expressions import window_of
from overview_dsp.measure.perceived_level import strokes, window_db
from tests.cli.running import overview
from tests.data.readers.made_up_share import share

GUIDE = (Path(__file__).parents[3] / "docs" / "guide" / "zoom.md").read_text(encoding="utf-8")
COMMANDS = [
    line
    for block in re.findall(r"```sh\n(.*?)```", GUIDE.partition("## Two looks")[2], re.S)
    for line in block.strip().splitlines()
]


@pytest.fixture(scope="module")
def year():
    return ov.load_timeline("made-up-share")


@pytest.fixture(scope="module")
def series():
    return ov.load_preset("series")


def parts_felt(timeline, preset, seconds, parts):
    """The median felt level, dB, in each of `parts` equal parts of a sweep, between the events."""
    result = ov.render(timeline, preset, ov.sweep(seconds))
    (out, *_) = strokes(result.trace.touching, result.trace.cursor)
    starts, level = window_db(result.samples[out.start : out.stop, 1], result.sample_rate, 0.005)
    middle = np.minimum((starts + 240).astype(int) + out.start, out.stop - 1)
    cursor = result.trace.cursor[middle]
    missing = np.zeros(len(cursor), dtype=bool)
    for start, end in timeline.gaps:
        missing |= (cursor * timeline.duration_s > start) & (cursor * timeline.duration_s < end)
    free = ~result.engine.surface.in_span(cursor) & ~missing & (cursor > 0.1) & (cursor < 0.97)
    edges = np.linspace(0.1, 0.97, parts + 1)
    return [
        float(np.median(level[free & (cursor >= low) & (cursor < high)]))
        for low, high in pairwise(edges)
    ]


def test_the_bundled_share_is_what_its_recipe_gives(year):
    made = share()
    for name in ("title", "duration_s", "gaps", "start", "notes", "provenance", "details"):
        assert getattr(year, name) == getattr(made, name), name
    assert [event.kind for event in year.events] == [event.kind for event in made.events]
    np.testing.assert_allclose(year.intensity.value, made.intensity.value, atol=0.011)
    assert "made up" in year.provenance
    assert "made-up" in year.title


@pytest.mark.parametrize("seconds", [2.0, 4.0])
def test_the_year_is_felt_strong_at_the_start_and_weaker_towards_now(year, series, seconds):
    levels = parts_felt(year, series, seconds, 3)
    assert sorted(levels, reverse=True) == levels
    assert levels[0] - levels[2] >= 2.5


@pytest.mark.parametrize("seconds", [2.0, 4.0])
def test_the_last_weeks_are_felt_getting_stronger(year, series, seconds):
    weeks = year.window(*window_of(year, "end-6w", "end"))
    levels = parts_felt(weeks, series, seconds, 3)
    assert sorted(levels) == levels
    assert levels[-1] - levels[0] >= 2.5
    assert weeks.kinds()["week"] >= 5


def test_the_preset_knows_every_kind_of_the_share(year, series):
    kinds = set(year.kinds()) | {event.kind for event in year.details}
    assert all(series.kind_for(kind) for kind in kinds)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_of_the_guide_work(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program, *arguments = shlex.split(command)
    assert program == "overview"
    outcome = overview(*arguments, "--sample-rate", "8000")
    assert outcome.code == 0, outcome.err
    samples, _ = soundfile.read(tmp_path / arguments[arguments.index("-o") + 1])
    assert np.abs(samples).max(axis=0).min() > 0.0


def test_the_guide_has_five_commands():
    assert len(COMMANDS) == 5
