"""The observer from preset to report: what it must tell apart, what it can't, what it says."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.measure.observer import observing
from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
from overview_dsp.measure.observer.scoring import ObserverScores
from overview_dsp.measure.observer.strokes import rendered_strokes, stroke_names
from tests.examples import plain_preset

ARMS = ["arm 1 s", "arm 2 s", "arm 4 s", "arm 6 s"]
STROKES = ["1 s", "2 s", "4 s", "6 s", "15 s", "30 s", "recoil", "tap", *ARMS]


def preset_of(**kinds):
    made = {
        name: ov.EventKind(height=height, width_percent=width, modes=(ov.ClickMode(hertz, 20.0),))
        for name, (height, width, hertz) in kinds.items()
    }
    made.setdefault("default", ov.EventKind(height=4.0, width_percent=0.3))
    # on the times that a test gives: without football's map
    values = ov.load_preset("football").with_value("surface.angle_map", 0.0).values
    return ov.Preset("made", "x", "x", values, made)


def observed(preset, **how):
    return ov.measure.observe(preset, **({"learned": 14, "held_out": 6} | how))


def balanced(report, stroke, modality="touch"):
    return report.sets[-1].strokes[stroke][modality].kinds.balanced


@pytest.fixture(scope="module")
def unlike():
    """A hard knock and a bump that hardly stands out, which click alike."""
    return observed(preset_of(hard=(150.0, 0.15, 900.0), soft=(6.0, 0.3, 900.0)), movement="mixed")


@pytest.fixture(scope="module")
def alike():
    """Two kinds that feel the same and click two octaves apart."""
    return observed(preset_of(low=(60.0, 0.15, 500.0), high=(60.0, 0.15, 2000.0)), movement="mixed")


def test_kinds_that_feel_different_are_distinguished_by_touch(unlike):
    recall = unlike.sets[0].strokes["mixed"]["touch"].kinds
    assert recall.recall[recall.kinds.index("hard")] > 0.85
    confused = recall.confusion[recall.kinds.index("soft"), recall.kinds.index("hard")]
    assert confused < 0.1 * recall.events[recall.kinds.index("soft")]


def test_kinds_that_feel_the_same_are_distinguished_by_their_clicks_only(alike):
    assert balanced(alike, "mixed", "touch") < 0.6
    assert balanced(alike, "mixed", "sound") > 0.75
    assert balanced(alike, "mixed", "both") > 0.75


def test_warnings_name_the_confused_kinds(alike):
    lines = alike.warnings()
    (line,) = (one for one in lines if "is taken for a high" in one and "(by touch" in one)
    assert re.fullmatch(
        r"1 low in [234] is taken for a high in mixed movement "
        r"\(by touch, random timelines\)",
        line,
    )
    assert not any("is taken for a high" in one and "(by both" in one for one in lines)


def test_every_stroke_is_evaluated_on_the_given_timelines_too():
    preset = preset_of(hard=(150.0, 0.15, 900.0), soft=(6.0, 0.3, 900.0))
    given = [ov.measure.random_events(["hard", "soft"], seed) for seed in (901, 902)]
    report = observed(preset, timelines=given, modalities=["touch"], learned=2, held_out=2)
    assert [(one.name, one.timelines) for one in report.sets] == [
        ("random timelines", 2),
        ("timelines given", 2),
    ]
    counts = {kind: sum(one.kinds()[kind] for one in given) for kind in ("hard", "soft")}
    for one in report.sets:
        assert list(one.strokes) == STROKES == list(stroke_names("all"))
    for stroke in STROKES:
        scores = report.sets[1].strokes[stroke]["touch"].kinds
        events = dict(zip(scores.kinds, scores.events // scores.draws, strict=True))
        # every event counts, also in the recoil and the tap, and where an arm never reaches it
        assert {kind: events[kind] for kind in counts} == counts, stroke
    table = report.table()
    assert "timelines given (2), touch: recall / precision, %" in table
    assert all(f"touch, {stroke}: answers" in table for stroke in STROKES)
    plain = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert [stroke["name"] for stroke in plain["sets"][1]["strokes"]] == STROKES


def test_an_event_that_an_arm_never_reaches_counts_as_unnoticed():
    kind = ov.EventKind(height=20.0, width_percent=1.0)
    # a time constant of 3 s: the disk is far behind when the finger releases
    soft = plain_preset(disk__k1=1e-4, disk__k2=9e-4, surface__friction=3e-3)
    soft = replace(soft, kinds={"hard": kind, "default": kind})
    late = ov.Timeline("late", 100.0, (ov.Event(10.0, "hard"), ov.Event(90.0, "hard")))
    how = {"modalities": ["touch"], "movement": "arm", "learned": 4, "held_out": 0}
    report = observed(soft, timelines=[late], **how)
    assert list(report.sets[0].strokes) == ARMS
    scores = report.sets[0].strokes["arm 1 s"]["touch"].kinds
    assert scores.events.tolist() == [2 * scores.draws, 0]
    assert scores.recall[0] <= 0.5


def test_a_seed_gives_the_same_report_and_another_seed_another():
    preset = preset_of(hard=(150.0, 0.15, 900.0), soft=(6.0, 0.3, 900.0))
    how = {"modalities": ["touch"], "movement": "mixed", "learned": 4, "held_out": 2}
    first, again, other = (observed(preset, seed=seed, **how).to_json() for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_what_is_noticed_by_touch_is_the_same_at_16_and_at_48_khz(match, football):
    at = {
        rate: rendered_strokes(football, [match], "all", ["touch"], 0, lambda _: None, rate)
        for rate in (16_000.0, 48_000.0)
    }
    levels = []
    for name in STROKES:
        (low,), (high,) = (strokes[name] for strokes in at.values())
        low_ms, high_ms = low.features["touch"].at_ms, high.features["touch"].at_ms
        assert abs(len(low_ms) - len(high_ms)) <= 2
        for i, ms in enumerate(low_ms.tolist()):
            j = int(np.abs(high_ms - ms).argmin())
            assert abs(high_ms[j] - ms) <= 30
            rows = low.features["touch"].features[i], high.features["touch"].features[j]
            levels.append(rows[0][0] - rows[1][0])
    # a person's noise is 1.6 dB
    assert np.sqrt(np.mean(np.square(levels))) < 0.5


def test_progress_rises_to_the_end():
    parts = []
    preset = preset_of(hard=(150.0, 0.15, 900.0))
    observed(preset, modalities=["touch"], learned=3, held_out=2, progress=parts.append)
    assert parts == sorted(parts)
    assert parts[0] < 0.1
    assert parts[-1] == 1.0


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"modalities": ["smell"]}, "touch, sound, both"),
        ({"modalities": []}, "touch, sound, both"),
        ({"movement": "cold"}, "all, steady, arm, mixed"),
        ({"learned": 0}, "must be at least 1"),
        ({"held_out": -1}, "held_out is -1"),
        ({"held_out": 0}, "no timelines to evaluate on"),
    ],
)
def test_a_mistake_gives_a_one_line_error_that_says_what_is_allowed(how, words):
    with pytest.raises(ov.InputError, match=words) as caught:
        observed(preset_of(), **how)
    assert "\n" not in str(caught.value)


def scores(confusion, draws=1):
    table = np.array(confusion)
    named = table[:, :-1].sum(axis=0)
    return ObserverScores(("goal", "card"), table, named, np.diagonal(table)[:-1].copy(), draws)


def warnings(strokes):
    by_stroke = {name: {"touch": StrokeScores(one, one)} for name, one in strokes.items()}
    found = SetScores("random timelines", 40, by_stroke)
    return ObserverReport("football", "steady", 120, (found,)).warnings()


def test_warnings_name_the_share_of_each_confusion_and_its_strokes():
    one_in_twelve = scores([[24, 0, 0], [2, 22, 0], [0, 0, 0]])
    one_in_four = scores([[24, 0, 0], [6, 18, 0], [0, 0, 0]])
    assert warnings({"2 s": one_in_twelve, "recoil": one_in_four}) == [
        "1 card in 12 is taken for a goal at 2 s, 1 in 4 in the recoil (by touch, random timelines)"
    ]


def test_warnings_name_kinds_that_are_unnoticed_sometimes_and_mostly():
    assert warnings({"tap": scores([[9, 0, 3], [0, 5, 15], [0, 0, 0]])}) == [
        "1 goal in 4 is unnoticed in the tap (by touch, random timelines)",
        "3 cards in 4 are unnoticed in the tap (by touch, random timelines)",
    ]


def test_rare_confusions_and_few_events_give_no_warning():
    assert warnings({"tap": scores([[95, 5, 0], [0, 100, 0], [0, 0, 0]])}) == []
    assert warnings({"tap": scores([[5, 5, 0], [0, 100, 0], [0, 0, 0]])}) == []
    # ten events, five times each
    assert warnings({"tap": scores([[25, 25, 0], [0, 100, 0], [0, 0, 0]], draws=5)}) == []


def test_an_observer_is_evaluated_on_timelines_outside_of_its_training(monkeypatch):
    made = []

    def recorded(preset, count, seed):
        made.append(range(seed, seed + count))
        return ov.measure.random_timelines(preset, count, seed)

    monkeypatch.setattr(observing, "random_timelines", recorded)
    preset = preset_of(hard=(150.0, 0.15, 900.0))
    observed(preset, modalities=["touch"], movement="mixed", learned=2, held_out=2, seed=5)
    learned, asked = made
    assert len(learned) == len(asked) == 2
    assert not set(learned) & set(asked)
