"""Every zoom on every shared match and series: at each step as many events a degree, or all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.data.readers import list_matches, load_timeline, save_timeline
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.data.timeline.time_expressions import NARROWEST_S, ZOOM_LEAD
from overview_dsp.data.timeline.window_events import MOST_BY_RULE
from overview_dsp.design.presets.library import load_preset
from overview_dsp.signal.surface.build import build_surface

BUNDLED = ("world-cup-final-2018", "made-up-share")

MATCHES = (
    "football/statsbomb/22936.json",
    "football/statsbomb/69321.json",
    "football/statsbomb/15986.json",
    "football/metrica/Sample_Game_1_RawEventsData.csv",
    "football/wyscout/wyscout_v2_match_2499773.json",
)

SERIES = (
    *(("stocks/bokeh_AAPL.csv", column) for column in ("Open", "Close", "Volume", "Adj Close")),
    *(("stocks/bokeh_IBM.csv", column) for column in ("High", "Low", "Close", "Adj Close")),
    *(("stocks/sp500-2000.csv", column) for column in ("open", "close", "volume", "adjclose")),
    *(
        ("weather/seattle-weather.csv", column)
        for column in ("precipitation", "temp_max", "temp_min", "wind")
    ),
    *(
        ("weather/seattle-weather-hourly-normals.csv", column)
        for column in ("pressure", "temperature", "wind")
    ),
)

RECORDINGS = (
    ("ecg/100.hea", None),
    ("ecg/118e24.csv", 360.0),
    ("ecg/e0103.csv", 250.0),
    ("ecg/heartpy_data_ppg_100hz.csv", 100.0),
    ("crowd/mdn_concert-crowd.ogg", None),
    ("crowd/gpf_crowd01.wav", None),
    ("crowd/gpf_whistle2.wav", None),
)


def zoom_steps(timeline: Timeline, about_s: float) -> Iterator[tuple[float, Timeline]]:
    """Where the parts of 1/1, 1/2, 1/4, ... about a moment begin, and the parts."""
    width = timeline.duration_s
    while width >= NARROWEST_S:
        start = min(max(about_s - ZOOM_LEAD * width, 0.0), timeline.duration_s - width)
        yield start, timeline.window(start, min(start + width, timeline.duration_s))
        width /= 2.0


def shows_all(timeline: Timeline, start: float, part: Timeline) -> bool:
    """Whether no detail, and no sample at which the series moves, is left to show."""
    shown = {(event.time_s, event.kind) for event in part.events}
    if any((event.time_s, event.kind) not in shown for event in part.details):
        return False
    if timeline.rules is None:
        return True
    assert timeline.intensity is not None
    time_s = np.asarray(timeline.intensity.time_s)
    moved = np.flatnonzero(np.diff(timeline.intensity.value)) + 1
    over_a_gap = np.isin(time_s[moved], [end for _, end in timeline.gaps])
    samples = time_s[moved[~over_a_gap]] - start
    inside = samples[(samples > 0.0) & (samples <= part.duration_s)][1:]
    times = np.array([event.time_s for event in part.events])
    return all(np.abs(times - sample).min() < 1e-3 for sample in inside.tolist())


def check(timeline: Timeline, about: list[Event]) -> int:
    """Zoom about each event; the number of steps that were looked at."""
    assert about
    steps = 0
    for event in about:
        before = len(timeline.events)
        for start, part in zoom_steps(timeline, event.time_s):
            there = [e.time_s + start for e in part.events if e.kind == event.kind]
            assert np.abs(np.array(there) - event.time_s).min() < 1e-3
            assert len(part.events) >= before or shows_all(timeline, start, part)
            assert any(e.kind in TICKS for e in part.events)
            before = len(part.events)
            steps += 1
    return steps


def felt(timeline: Timeline) -> list[Event]:
    """The events but for those of a kind too dense to be felt singly under `heart`."""
    surface = build_surface(timeline, load_preset("heart"))
    return [timeline.events[i] for i in surface.event.tolist()]


def some(events: tuple[Event, ...], kinds: tuple[str, ...] = ()) -> list[Event]:
    """The events of these kinds; of any kind, all but the ticks and, of many, every fourth."""
    if kinds:
        return [event for event in events if event.kind in kinds]
    own = [event for event in events if event.kind not in TICKS]
    return own[:: 1 + len(own) // 100]


@pytest.mark.parametrize("name", BUNDLED)
def test_a_bundled_timeline_shows_more_about_every_event(name: str) -> None:
    timeline = load_timeline(name)
    assert check(timeline, some(timeline.events)) > 50


@pytest.mark.parametrize("file", MATCHES)
def test_a_match_shows_no_fewer_events_at_every_step_about_every_event(
    data_folder: Path, file: str
) -> None:
    timeline = load_timeline(data_folder / file)
    assert check(timeline, some(timeline.events)) > 300
    for goal in some(timeline.events, ("goal", "own_goal")):
        for _, (start, part) in zip(range(4), zoom_steps(timeline, goal.time_s), strict=False):
            # to an eighth a match has far more than its goals, cards and fouls
            assert len(part.events) >= 2 * len(timeline.events), (goal, start)


def test_every_match_of_the_world_cup_shows_no_fewer_about_every_goal(data_folder: Path) -> None:
    path = data_folder / "football" / "openfootball" / "worldcup_2018.json"
    numbers = range(1, len(list_matches(path)) + 1)
    goals = 0
    for number in numbers:
        timeline = load_timeline(path, match=str(number))
        about = some(timeline.events, ("goal", "own_goal"))
        goals += len(about)
        if about:
            check(timeline, about)
            for goal in about:
                assert all(
                    len(part.events) >= min(len(timeline.events), 9)
                    for _, part in zoom_steps(timeline, goal.time_s)
                )
    assert goals == 169


def test_a_list_of_goals_shows_no_fewer_about_every_goal(data_folder: Path) -> None:
    timeline = load_timeline(
        data_folder / "football" / "goalscorers_2010s.csv", match="2014-07-08 Brazil Germany"
    )
    about = some(timeline.events, ("goal", "own_goal"))
    assert len(about) == 8
    check(timeline, about)


@pytest.mark.parametrize(("file", "column"), SERIES)
def test_a_series_shows_no_fewer_events_at_every_step_about_every_event(
    data_folder: Path, file: str, column: str
) -> None:
    timeline = load_timeline(data_folder / file, value=column)
    assert check(timeline, some(timeline.events, ("highest", "lowest"))) > 40
    check(timeline, some(timeline.events)[::6])


def test_counted_points_show_no_fewer_events_at_every_step(tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    quakes = np.sort(random.uniform(0.0, 4e7, 3000)) % 3e7  # in any order, denser at first
    path = tmp_path / "quakes.csv"
    path.write_text("epoch,magnitude\n" + "".join(f"{1.5e9 + at:.0f},2\n" for at in quakes))
    timeline = load_timeline(path, map="count:6h")
    assert check(timeline, some(timeline.events)[::3]) > 40


@pytest.mark.parametrize("map_name", ["change", "activity", "volatility"])
def test_another_map_of_a_series_finds_the_same_events_in_its_windows(
    data_folder: Path, map_name: str
) -> None:
    path = data_folder / "stocks" / "sp500-2000.csv"
    level, other = (load_timeline(path, map=wish) for wish in ("level", map_name))
    for start in (0.0, 1e8, 3e8):
        shown = [one.window(start, start + 2e7).events for one in (level, other)]
        assert shown[0] == shown[1]


@pytest.mark.parametrize("map_name", ["rate", "variability"])
@pytest.mark.parametrize(("file", "rate"), [r for r in RECORDINGS if r[0].startswith("ecg")])
def test_a_heart_shows_no_fewer_events_until_every_beat_is_felt(
    data_folder: Path, file: str, rate: float | None, map_name: str
) -> None:
    timeline = load_timeline(data_folder / file, rate=rate, map=map_name)
    beats = np.array([e.time_s for e in timeline.events if e.kind == "beat"])
    wide = 0
    for about in some(timeline.events)[::20]:
        before = len(felt(timeline))
        for start, part in zoom_steps(timeline, about.time_s):
            shown = felt(part)
            times = np.array([event.time_s for event in shown]) + start
            inside = beats[(beats >= start) & (beats <= start + part.duration_s)]
            every_beat = all(np.abs(times - beat).min() < 1e-3 for beat in inside.tolist())
            assert len(shown) >= before or every_beat
            assert every_beat or len(shown) >= MOST_BY_RULE
            wide += not every_beat
            before = len(shown)
    assert wide > 0 or len(beats) <= 100


def test_a_written_heart_has_the_same_windows(data_folder: Path, tmp_path: Path) -> None:
    timeline = load_timeline(data_folder / "ecg/118e24.csv", rate=360.0)
    save_timeline(timeline, tmp_path / "heart.json")
    again = load_timeline(tmp_path / "heart.json")
    for end in (120.0, 60.0, 7.0):
        assert again.window(0.0, end).events == timeline.window(0.0, end).events


@pytest.mark.parametrize(("file", "rate"), RECORDINGS)
def test_a_recording_says_where_one_is_in_every_window(
    data_folder: Path, file: str, rate: float | None
) -> None:
    timeline = load_timeline(data_folder / file, rate=rate)
    middle = [Event(timeline.duration_s / 2.0, "second")]
    for event in some(timeline.events)[::10] or middle:
        for _, part in zoom_steps(timeline, event.time_s):
            assert any(e.kind in TICKS for e in part.events)
