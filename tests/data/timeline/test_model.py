from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, replace
from datetime import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.errors import InputError
from tests.data.timeline.strategies import timelines, without_ticks


def curve(*points: tuple[float, float], unit: str = "") -> Intensity:
    return Intensity(np.array([p[0] for p in points]), np.array([p[1] for p in points]), unit)


def make(**changes: object) -> Timeline:
    values: dict[str, object] = {
        "title": "t",
        "duration_s": 100.0,
        "events": (Event(10.0, "goal"), Event(90.0, "foul")),
        "intensity": curve((0.0, 10.0), (50.0, 20.0), (100.0, -10.0)),
    }
    return Timeline(**(values | changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, "90", True, None, 10**400])
def test_a_duration_that_is_no_positive_number_is_refused(bad: object) -> None:
    with pytest.raises(InputError, match="duration_s is"):
        make(duration_s=bad)


@pytest.mark.parametrize("bad", [-0.001, math.nan, math.inf, "1", True])
def test_an_event_time_that_is_no_time_is_refused(bad: object) -> None:
    with pytest.raises(InputError, match="time_s is"):
        Event(bad, "goal")  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", ["", "Goal", "near miss", "a-b", "gö", "goal\n", "x" * 65, 3, "٣"])
def test_a_kind_of_other_characters_is_refused_with_what_is_allowed(bad: object) -> None:
    with pytest.raises(InputError, match="a-z, 0-9 and _"):
        Event(1.0, bad)  # type: ignore[arg-type]


def test_a_refused_kind_comes_with_one_that_would_do() -> None:
    with pytest.raises(InputError, match="try 'near_miss'"):
        Event(1.0, "Near-Miss")


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, "1"])
def test_a_weight_that_is_no_positive_number_is_refused(bad: object) -> None:
    with pytest.raises(InputError, match="weight is"):
        Event(1.0, "goal", weight=bad)  # type: ignore[arg-type]


def test_text_with_a_lone_surrogate_is_refused_in_printable_words() -> None:
    for build in (lambda: Event(1.0, "goal", "\ud800"), lambda: make(title="a\udfff")):
        with pytest.raises(InputError, match="surrogate") as caught:
            build()
        str(caught.value).encode()


def test_events_are_sorted_and_those_of_one_time_keep_their_order() -> None:
    events = (Event(5.0, "yellow_card"), Event(5.0, "foul"), Event(1.0, "period"))
    kinds = [event.kind for event in make(events=events).events]
    assert kinds == ["period", "yellow_card", "foul"]


def test_an_event_may_be_at_the_very_start_and_the_very_end() -> None:
    timeline = make(events=(Event(0, "period"), Event(100, "period")))
    assert [event.time_s for event in timeline.events] == [0.0, 100.0]


def test_an_event_after_the_end_is_refused() -> None:
    with pytest.raises(InputError, match=r"foul at 100\.5 s is after the end"):
        make(events=(Event(100.5, "foul"),))


def test_the_same_event_twice_is_refused_but_a_foul_and_its_card_are_not() -> None:
    with pytest.raises(InputError, match="repeated"):
        make(events=(Event(5.0, "foul", "a"), Event(5.0, "foul", "a", 2.0)))
    assert len(make(events=(Event(5.0, "foul", "a"), Event(5.0, "red_card", "a"))).events) == 2
    assert len(make(events=(Event(5.0, "foul", "a"), Event(5.0, "foul", "b"))).events) == 2


def test_a_timeline_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="neither events nor an intensity"):
        make(events=(), intensity=None)
    assert make(events=()).intensity is not None
    assert make(intensity=None).events


@pytest.mark.parametrize(
    ("times", "values", "words"),
    [
        ([0.0, 1.0, 1.0], [0, 0, 0], r"time_s\[2\] is 1\.0, not after"),
        ([0.0, 2.0, 1.0], [0, 0, 0], r"time_s\[2\] is 1\.0, not after"),
        ([-1.0, 0.0], [0, 0], r"time_s\[0\] is -1\.0, before"),
        ([0.0, math.nan], [0, 0], r"time_s\[1\] is nan"),
        ([0.0, 1.0], [0, math.inf], r"value\[1\] is inf"),
        ([0.0, 1.0], [0, 1e301], r"value\[1\] is 1e\+301"),
        ([0.0, 1.0], [0], "2 points and intensity.value 1"),
        ([], [], "no points"),
        ([[0.0, 1.0]], [[0, 1]], "one row"),
        (["0", "1"], [0, 1], "one row of numbers"),
        ([0.0, [1.0]], [0, 1], "one row of numbers"),
        ([False, True], [0, 1], "one row of numbers"),
        ([0.0, 1j], [0, 1], "one row of numbers"),
    ],
)
def test_a_curve_that_is_none_is_refused_at_its_first_bad_place(
    times: object, values: object, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        Intensity(times, values)  # type: ignore[arg-type]


def test_a_curve_beyond_the_end_is_refused() -> None:
    with pytest.raises(InputError, match=r"intensity.time_s\[1\] is 101\.0, after the end"):
        make(intensity=curve((0.0, 1.0), (101.0, 1.0)))


@pytest.mark.parametrize(
    ("gaps", "words"),
    [
        (((5.0, 5.0),), "reaches from"),
        (((6.0, 5.0),), "reaches from"),
        (((90.0, 101.0),), "reaches from"),
        (((-1.0, 5.0),), "reaches from"),
        (((1.0, 5.0), (4.0, 8.0)), r"overlap; merge them into \(1.0, 8.0\)"),
        (((1.0,),), "not a pair"),
        (((1.0, math.nan),), r"gaps\[0\]\[1\] is nan"),
        ("ab", "not a list"),
    ],
)
def test_gaps_that_are_none_are_refused(gaps: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        make(gaps=gaps)


def test_gaps_are_sorted_and_may_touch() -> None:
    assert make(gaps=((5.0, 8.0), (1.0, 5.0))).gaps == ((1.0, 5.0), (5.0, 8.0))


def test_every_error_is_one_line() -> None:
    with pytest.raises(InputError) as caught:
        Event(1.0, "a\nb")
    assert "\n" not in str(caught.value)


def test_arrays_are_copies_and_read_only() -> None:
    times = np.array([0.0, 1.0])
    intensity = Intensity(times, [3, 4])  # type: ignore[arg-type]
    times[0] = 0.5
    assert intensity.time_s[0] == 0.0
    assert intensity.value.dtype == np.float64
    for array in (intensity.time_s, intensity.value):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_a_timeline_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        make().title = "other"  # type: ignore[misc]


def test_equal_timelines_are_equal_and_have_equal_hashes() -> None:
    a, b = make(), make()
    assert a == b
    assert hash(a) == hash(b)
    assert a != make(intensity=curve((0.0, 10.0), (50.0, 20.5), (100.0, -10.0)))
    assert a != make(intensity=curve((0.0, 10.0), (100.0, -10.0)))
    assert a != make(intensity=curve((0.0, 10.0), (50.0, 20.0), (100.0, -10.0), unit="dB"))
    assert a != make(events=())
    assert curve((0.0, 1.0)) != "curve"
    assert curve((0.0, 0.0)) == curve((0.0, -0.0))
    assert hash(curve((0.0, 0.0))) == hash(curve((0.0, -0.0)))


def test_the_curve_is_straight_between_points_and_zero_outside() -> None:
    timeline = make(intensity=curve((10.0, 10.0), (50.0, 20.0), (90.0, -10.0)))
    at = [0.0, 9.999, 10.0, 30.0, 50.0, 70.0, 90.0, 90.001, 200.0, -5.0, math.nan]
    assert timeline.intensity_at(at).tolist() == [0, 0, 10, 15, 20, 5, -10, 0, 0, 0, 0]


def test_the_curve_keeps_the_shape_of_what_is_asked() -> None:
    assert make().intensity_at(25.0).shape == ()
    assert float(make().intensity_at(25.0)) == 15.0
    assert make().intensity_at(np.zeros((2, 3))).shape == (2, 3)
    assert make().normalised_intensity_at(np.zeros((0,))).shape == (0,)


def test_points_a_hair_apart_with_huge_values_stay_finite() -> None:
    timeline = make(intensity=curve((0.0, -1e300), (5e-324, 1e300), (100.0, -1e300)))
    at = np.concatenate(([0.0, 5e-324], np.linspace(0.0, 100.0, 101)))
    assert np.isfinite(timeline.intensity_at(at)).all()
    scaled = timeline.normalised_intensity_at(at)
    assert scaled[0] == 0.0
    assert scaled[1] == 1.0
    # between the two, where a slope would be infinite
    steep = make(intensity=curve((0.0, -1e300), (1e-10, 1e300)))
    assert float(steep.intensity_at(5e-11)) == pytest.approx(0.0, abs=1e285)


def test_one_point_is_a_constant_over_the_whole_timeline() -> None:
    timeline = make(intensity=curve((40.0, 7.0)))
    assert timeline.intensity_at([0.0, 100.0, 100.1, -0.1]).tolist() == [7.0, 7.0, 0.0, 0.0]


def test_without_a_curve_everything_is_zero() -> None:
    timeline = make(intensity=None)
    assert timeline.intensity_at([1.0, 2.0]).tolist() == [0.0, 0.0]
    assert timeline.normalised_intensity_at([1.0, 2.0]).tolist() == [0.0, 0.0]


def test_inside_a_gap_the_curve_is_missing_and_at_its_ends_it_is_not() -> None:
    timeline = make(gaps=((20.0, 30.0), (30.0, 40.0)))
    at = [10.0, 20.0, 20.1, 29.9, 30.0, 35.0, 40.0, 41.0]
    there = [t != 0.0 for t in timeline.intensity_at(at)]
    assert there == [True, True, False, False, True, False, True, True]


def test_a_curve_is_scaled_from_its_least_to_its_most() -> None:
    at = [0.0, 50.0, 100.0, 200.0]
    expected = [20 / 30, 1.0, 0.0, 0.0]
    assert make().normalised_intensity_at(at).tolist() == pytest.approx(expected)


def test_a_curve_within_0_and_1_is_taken_as_it_is() -> None:
    timeline = make(intensity=curve((0.0, 0.2), (100.0, 0.6)))
    assert timeline.normalised_intensity_at([0.0, 100.0]).tolist() == [0.2, 0.6]
    timeline = make(intensity=curve((0.0, 0.2), (100.0, 1.0)))
    assert timeline.normalised_intensity_at([0.0, 100.0]).tolist() == [0.2, 1.0]
    assert make(intensity=curve((0.0, 0.3))).normalised_intensity_at([5.0]).tolist() == [0.3]


def test_a_constant_outside_0_and_1_becomes_0() -> None:
    timeline = make(intensity=curve((0.0, 7.0), (100.0, 7.0)))
    assert timeline.normalised_intensity_at([0.0, 50.0]).tolist() == [0.0, 0.0]
    assert make(intensity=curve((0.0, -7.0))).normalised_intensity_at([50.0]).tolist() == [0.0]


def test_points_inside_a_gap_do_not_set_the_scale() -> None:
    intensity = curve((0.0, 10.0), (50.0, 9999.0), (90.0, 20.0))
    timeline = make(intensity=intensity, gaps=((40.0, 60.0),))
    assert float(timeline.normalised_intensity_at(90.0)) == 1.0


def test_kinds_are_counted_in_order_of_appearance() -> None:
    events = (Event(3.0, "foul"), Event(1.0, "goal"), Event(2.0, "foul"))
    assert list(make(events=events).kinds().items()) == [("goal", 1), ("foul", 2)]


def test_an_event_is_found_by_kind_and_number() -> None:
    timeline = make(events=(Event(3.0, "goal", "b"), Event(1.0, "goal", "a")))
    assert timeline.event("goal", 1).label == "a"
    assert timeline.event("goal", 2).label == "b"
    for number in (0, 3, -1):
        with pytest.raises(InputError, match="has 2: give 1 to 2"):
            timeline.event("goal", number)
    with pytest.raises(InputError, match="no event of kind 'foul'; it has goal"):
        timeline.event("foul", 1)


def test_a_window_starts_at_zero_and_has_what_lies_in_it() -> None:
    timeline = make(gaps=((5.0, 15.0), (60.0, 95.0)))
    part = timeline.window(10.0, 70.0)
    assert part.duration_s == 60.0
    assert [(event.time_s, event.kind) for event in without_ticks(part)] == [(0.0, "goal")]
    assert part.gaps == ((0.0, 5.0), (50.0, 60.0))
    assert part.intensity is not None
    assert part.intensity.time_s.tolist() == [0.0, 40.0, 60.0]
    assert part.intensity.value.tolist() == pytest.approx([12.0, 20.0, 8.0])
    assert part.notes[-1] == "the window from 0:10.0 to 1:10.0"


def test_a_window_begins_at_its_own_calendar_moment() -> None:
    timeline = Timeline("a day", 86_400.0, (Event(1.0, "a"),), start=datetime(2012, 9, 19))
    part = timeline.window(3600.0, 7200.0)
    assert part.start == datetime(2012, 9, 19, 1)
    assert part.notes[0] == "the window from 2012-09-19 01:00:00 to 2012-09-19 02:00:00"


def test_events_at_both_ends_of_a_window_belong_to_it() -> None:
    assert [event.time_s for event in without_ticks(make().window(10.0, 90.0))] == [0.0, 80.0]


def test_a_window_over_everything_is_the_timeline_and_its_ticks() -> None:
    timeline = make()
    part = timeline.window(0.0, 100.0)
    assert replace(part, notes=(), events=tuple(without_ticks(part))) == timeline


def test_a_window_without_anything_is_flat_and_says_so() -> None:
    part = make(intensity=None).window(20.0, 30.0)
    assert without_ticks(part) == []
    assert part.intensity_at([0.0, 5.0, 10.0]).tolist() == [0.0, 0.0, 0.0]
    assert "this window has no event and no curve" in part.notes[-1]
    beside = make(events=(), intensity=curve((0.0, 5.0), (20.0, 6.0), unit="dB"))
    # 20 s belongs to the curve, but one point of it would become a constant of 6
    part = beside.window(20.0, 30.0)
    assert part.intensity_at([0.0, 10.0]).tolist() == [0.0, 0.0]
    assert part.intensity is not None
    assert part.intensity.unit == "dB"


def test_reasons_stay_with_their_gaps() -> None:
    timeline = make(gaps=((60.0, 95.0), (5.0, 15.0)), gap_reasons=("noise", "lead off"))
    assert timeline.gap_reasons == ("lead off", "noise")
    assert timeline.window(20.0, 70.0).gap_reasons == ("noise",)
    assert timeline.window(20.0, 30.0).gap_reasons == ()
    assert make(gaps=((5.0, 15.0),), gap_reasons=("",)).gap_reasons == ()


def test_reasons_are_as_many_as_gaps() -> None:
    with pytest.raises(InputError, match="2 gap_reasons for 1 gaps"):
        make(gaps=((5.0, 15.0),), gap_reasons=("a", "b"))


def test_a_window_within_a_gap_is_all_gap() -> None:
    part = make(events=(), gaps=((20.0, 80.0),)).window(30.0, 40.0)
    assert part.gaps == ((0.0, 10.0),)
    assert part.intensity_at([1.0, 5.0]).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("start", "end"), [(50, 50), (60, 50), (-1, 50), (50, 100.1), (math.nan, 50), (0, math.inf)]
)
def test_a_window_outside_or_empty_is_refused(start: float, end: float) -> None:
    with pytest.raises(InputError, match=r"give 0 <= start < end <= 100\.0"):
        make().window(start, end)


@given(timelines(), st.data())
def test_a_window_has_the_timelines_values_at_the_same_moments(
    timeline: Timeline, data: st.DataObject
) -> None:
    edges = st.floats(0.0, timeline.duration_s)
    start, end = sorted((data.draw(edges), data.draw(edges)))
    if end - start < 1e-3:
        return
    part = timeline.window(start, end)
    inside = [event for event in timeline.events if start <= event.time_s <= end]
    smaller = [event for event in timeline.details if start <= event.time_s <= end]
    own = {(event.kind, event.label) for event in without_ticks(part)}
    given = {(event.kind, event.label) for event in (*inside, *smaller) if event.kind not in TICKS}
    assert {(e.kind, e.label) for e in inside if e.kind not in TICKS} <= own <= given
    assert len(part.events) >= len(inside)
    assert len(part.details) == len(smaller)
    # moments clear of jumps (gap and curve ends), where rounding of a time changes little
    moments = start + (end - start) * np.linspace(0.0, 1.0, 41)
    jumps = np.array([start, end, *np.ravel(timeline.gaps)])
    if timeline.intensity is not None:
        jumps = np.concatenate((jumps, timeline.intensity.time_s[[0, -1]]))
    clear = np.abs(moments[:, None] - jumps).min(axis=1) > 1e-6
    moments = moments[clear]
    here, there = part.intensity_at(moments - start), timeline.intensity_at(moments)
    steepness = 0.0
    if timeline.intensity is not None and len(timeline.intensity.time_s) > 1:
        steps = np.maximum(np.diff(timeline.intensity.time_s), 1e-100)
        steepness = float(np.abs(np.diff(timeline.intensity.value) / steps).max())
    scale = 1e-9 + 1e-12 * (steepness * timeline.duration_s + float(np.abs(there).max(initial=0)))
    assert np.abs(here - there).max(initial=0.0) <= scale


@given(timelines())
def test_the_normalised_curve_stays_within_0_and_1(timeline: Timeline) -> None:
    at = np.linspace(-1.0, timeline.duration_s + 1.0, 201)
    scaled = timeline.normalised_intensity_at(at)
    assert scaled.min() >= 0.0
    assert scaled.max() <= 1.0


def test_percentiles_scale_a_curve_and_clip_it_there_alone() -> None:
    value = np.concatenate([np.linspace(10.0, 20.0, 101), [1e6]])
    curve = Intensity(np.arange(102.0), value, "m", (1.0, 90.0))
    timeline = Timeline("", 101.0, intensity=curve)
    low, high = np.percentile(value, (1.0, 90.0))
    expected = np.clip((value - low) / (high - low), 0.0, 1.0)
    assert timeline.normalised_intensity_at(np.arange(102.0)) == pytest.approx(expected)
    assert timeline.intensity_at(101.0) == 1e6
    # values within 0 and 1 are scaled too, once there are percentiles
    small = Timeline("", 100.0, intensity=Intensity([0, 50, 100], [0.2, 0.4, 0.6], "", (0, 99)))
    assert small.normalised_intensity_at(0.0) == 0.0


def test_percentiles_that_fall_together_give_way_to_the_extremes() -> None:
    fallen = np.zeros(1000)
    fallen[600], fallen[700] = 4.0, 8.0
    rain = Intensity(np.arange(1000.0), fallen, "mm", (1.0, 99.0))
    timeline = Timeline("", 999.0, intensity=rain)
    assert timeline.normalised_intensity_at([0.0, 600.0, 700.0]).tolist() == [0.0, 0.5, 1.0]


@pytest.mark.parametrize("given", [(50.0, 50.0), (-1.0, 99.0), (1.0, 101.0), (1.0,), "ab", None])
def test_percentiles_are_two_rising_ones(given: object) -> None:
    with pytest.raises(InputError, match=r"intensity\.percentiles"):
        Intensity([0.0, 1.0], [0.0, 1.0], "", given)  # type: ignore[arg-type]


def test_a_span_too_small_to_divide_by_is_still_a_scale():
    # found by chance: what lies in a gap isn't in the span, and overflowed
    curve = Intensity(np.array([0.0, 0.5, 1.0, 2.0, 3.0]), np.array([0, 1, 0, 0, -2.2e-309]))
    timeline = Timeline("", 3.0, (), curve, gaps=((0.0, 1.0),))
    levels = timeline.normalised_levels(6)
    assert np.all((levels >= 0.0) & (levels <= 1.0))
    assert levels[-2] < levels[-3] == 1.0
