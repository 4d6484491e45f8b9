from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_dsp.offline.plots.style import save_picture
from overview_dsp.offline.plots.timeline import plot_timeline


def axis_of(duration_s: float, start: datetime | None, kind: str = "day"):
    events = (ov.Event(duration_s / 2, kind),)
    curve = ov.Intensity(np.array([0.0, duration_s]), np.array([0.0, 1.0]))
    figure = plot_timeline(ov.Timeline("x", duration_s, events, curve, start=start))
    figure.canvas.draw()
    return figure.axes[0]


@pytest.mark.parametrize(
    ("duration_s", "label", "end"),
    [(60.0, "time, s", 60.0), (5400.0, "time, min", 90.0), (86_400.0, "time, h", 24.0),
     (864_000.0, "time, days", 10.0)],
)  # fmt: skip
def test_the_time_axis_has_a_unit_that_suits_the_duration(duration_s, label, end):
    axes = axis_of(duration_s, None)
    assert axes.get_xlabel() == label
    assert axes.get_xlim() == (0.0, end)


def test_a_match_has_its_time_of_play():
    assert axis_of(5400.0, None, "goal").get_xlabel() == "time of play, min"


def match(halves, kinds=("goal",), start=None):
    edges = np.concatenate(([0.0], np.cumsum(halves))) * 60.0
    events = [ov.Event(float(edge), "period") for edge in edges]
    events += [ov.Event(60.0 * i, kind) for i, kind in enumerate(kinds, 1)]
    return ov.Timeline("x", float(edges[-1]), tuple(events), start=start)


def words_at(timeline):
    axes = plot_timeline(timeline).axes[0]
    ticks = axes.get_xticks()
    words = [text.get_text() for text in axes.get_xticklabels()]
    return dict(zip(words, np.round(ticks, 9).tolist(), strict=True))


def test_a_match_has_the_minutes_of_the_board_with_added_time():
    ticks = words_at(match((48.0, 50.0)))
    assert ticks == {"0": 0.0, "15": 15.0, "30": 30.0, "45+3": 48.0, "60": 63.0, "75": 78.0,
                     "90+5": 98.0}  # fmt: skip
    longer = words_at(match((45.0, 46.0, 16.0, 15.0)))
    assert list(longer)[-3:] == ["90+1", "105+1", "120"]
    assert longer["105+1"] == 107.0


def test_what_is_no_whole_match_has_plain_minutes():
    for timeline in (match((20.0, 50.0)), match((48.0,)), match((48.0, 50.0)).window(60.0, 3000.0)):
        assert plot_timeline(timeline).axes[0].get_xlabel() == "time of play, min"


@pytest.mark.parametrize("zone", [None, UTC, timezone(timedelta(hours=-5))])
def test_a_calendar_is_on_the_axis_in_the_timelines_own_zone(zone):
    start = datetime(2012, 1, 1, tzinfo=zone)
    axes = axis_of(366 * 86_400.0, start)
    words = [text.get_text() for text in axes.get_xticklabels()]
    assert "Jul" in words
    july = axes.get_xticks()[words.index("Jul")]
    assert july == pytest.approx(182.0, abs=1e-6)  # days
    assert axes.get_xlabel().startswith("from 2012-01-01 00:00:00")


@pytest.mark.parametrize(
    "start", [datetime(1, 1, 2), datetime(1969, 12, 31, 23, 59), datetime(9998, 1, 1)]
)
@pytest.mark.parametrize("duration_s", [0.01, 1.0, 90.0, 86_400.0, 1e7])
def test_any_calendar_can_be_drawn(start, duration_s):
    axes = axis_of(duration_s, start)
    low, high = axes.get_xlim()
    assert all(low <= tick <= high for tick in axes.get_xticks())


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf", ".PNG"])
def test_a_picture_is_one_file_and_the_same_bytes_each_time(tmp_path, suffix):
    figure = axis_of(60.0, None).figure
    for name in ("a", "b"):
        save_picture(figure, tmp_path / (name + suffix))
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


def test_a_picture_of_another_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"x\.gif: a picture is .png, .svg, .pdf"):
        save_picture(axis_of(60.0, None).figure, tmp_path / "x.gif")
