"""Presets tuned by search: what is reached, what is kept, and what is said of the rest."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import sweep, tap
from overview_dsp.design.presets.text_update import save_updated
from overview_dsp.measure import tuning
from overview_dsp.measure.pictures import pages
from overview_dsp.measure.report import feel_report
from overview_dsp.measure.tuning import JUDGED, ORDERED_JNDS, REST, rearranged, tune
from tests.cli.running import MATCH, overview
from tests.measure.test_feel_report import SWEEPS, preset_of, timeline_of
from tests.parameters import first_in_gate


@pytest.fixture
def few_strokes(monkeypatch):
    """A search and a judgement of two gestures and a few tries, where more would show no more."""
    monkeypatch.setattr(tuning, "TRIES", 10)
    for name in ("SEARCHED", "JUDGED"):
        monkeypatch.setattr(tuning, name, {"1 s": sweep(1.0), "a tap": tap(1.0, 3.0)})


def gaps_of(preset, target, timelines):
    """The JNDs between the kinds of a target, in each stroke on each timeline."""
    return tuning._Search(preset, tuple(target), tuple(timelines), JUDGED).judged(preset).gaps


@pytest.fixture(scope="module")
def two_apart():
    """Two kinds that are nearly one, tuned."""
    return tune(preset_of(strong=20.0, weak=18.0), ("strong", "weak"), seed=1)


def test_tuning_sets_kinds_two_jnds_apart_at_every_speed(two_apart):
    found = two_apart
    assert found.reached
    assert found.least_jnds >= ORDERED_JNDS
    assert found.preset.kinds["strong"].height > found.preset.kinds["weak"].height
    report = feel_report(found.preset, timeline_of("strong", "weak", "weak", "strong"))
    for name in SWEEPS:
        strong, weak = report.stroke(name).kinds
        assert strong.level_db > weak.level_db + 2.3


@pytest.mark.soak
def test_separated_kinds_are_all_distinct():
    preset = preset_of(a=20.0, b=20.0, d=8.0)
    found = tune(preset, ("a", "d"), separate=True, seed=1)
    assert found.reached
    report = feel_report(
        found.preset, pages(found.preset), {"slow": sweep(5.0), "fast": sweep(1.0)}
    )
    for name in ("slow", "fast"):
        assert report.stroke(name).indistinct == ()
        levels = {kind.kind: kind.level_db for kind in report.stroke(name).kinds}
        assert levels["a"] > levels["d"] + 2.3
    assert tune(found.preset, ("a", "d"), separate=True, seed=2).preset.kinds == found.preset.kinds


@pytest.mark.usefixtures("few_strokes")
@pytest.mark.parametrize("apart", first_in_gate([True, False]))
def test_a_search_gives_the_same_preset_for_a_seed(monkeypatch, apart):
    for name in ("TRIES", "TRIES_SEPARATE"):
        monkeypatch.setattr(tuning, name, 6)  # however far it comes
    preset = preset_of(a=20.0, d=20.0)
    one, again, other = (tune(preset, ("a", "d"), None, apart, seed).preset for seed in (1, 1, 2))
    assert one.kinds == again.kinds != preset.kinds
    assert other.kinds != one.kinds


def test_an_invalid_target_gives_a_one_line_error():
    preset = preset_of(strong=20.0, weak=10.0)
    for target, words in (
        (("strong",), "two kinds or more"),
        (("strong", "wek"), "did you mean 'weak'"),
        (("strong", "strong"), "twice"),
    ):
        with pytest.raises(ov.InputError, match=words):
            tune(preset, target)


def test_a_preset_with_separate_kinds_is_unchanged(two_apart):
    apart = two_apart.preset
    found = tune(apart, ("strong", "weak"), seed=2)
    assert found.preset.kinds == apart.kinds
    assert found.reached


CHILD = """# my match, kept as it is
schema = 4
extends = "football"
title = "Mine"

[variables]
hard = 40.0  # how hard

[kinds.goal]
height = "$hard * 0.5"  # half

# the cards
[kinds.yellow_card]
height = 33.0
"""


def test_a_tuned_preset_that_extends_another_keeps_its_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "child.toml"
    source.write_text(CHILD)
    out = tmp_path / "elsewhere" / "made.toml"
    out.parent.mkdir()
    changes = {
        "goal": {"height": 30.0},
        "yellow_card": {"height": 11.0, "width_percent": 0.08},
        "foul": {"height": 2.5},
    }
    path, made = save_updated(source, changes, out)
    assert made == ov.load_preset(path)
    for kind, values in changes.items():
        for key, value in values.items():
            assert getattr(made.kinds[kind], key) == pytest.approx(value, rel=1e-3)
    kept = [line for line in CHILD.splitlines() if not line.startswith("height")]
    text = path.read_text()
    assert [line for line in text.splitlines() if line in kept][: len(kept)] == kept
    assert 'height = "($hard * 0.5) * 1.5"  # half' in text
    # it still follows its variables
    path.write_text(text.replace("hard = 40.0", "hard = 80.0"))
    assert ov.load_preset(path).kinds["goal"].height == pytest.approx(60.0)


def test_a_file_of_an_older_schema_is_retuned_where_its_keys_are_the_present_ones(tmp_path):
    source, out = tmp_path / "child.toml", tmp_path / "made.toml"
    for version in (1, 2, 3):
        source.write_text(CHILD.replace("schema = 4", f"schema = {version}"))
        _, made = save_updated(source, {"goal": {"height": 30.0}}, out)
        assert made.kinds["goal"].height == pytest.approx(30.0)
        assert out.read_text() == CHILD.replace('0.5"', '0.5) * 1.5"').replace('"$', '"($')
    out.unlink()
    source.write_text(CHILD.replace("schema = 4", "schema = 2") + "\n[disk]\ncatch_up = 1.1\n")
    with pytest.raises(ov.InputError, match=r"child\.toml: has keys of an older schema") as error:
        save_updated(source, {"goal": {"height": 30.0}}, out)
    assert "\n" not in str(error.value)
    assert not out.exists()


def test_a_child_of_a_file_extends_it_from_another_folder_too(tmp_path):
    (tmp_path / "base.toml").write_text(CHILD)
    child = tmp_path / "child.toml"
    child.write_text('schema = 4\nextends = "base.toml"\n')
    folder = tmp_path / "deep" / "er"
    folder.mkdir(parents=True)
    _, made = save_updated(child, {"goal": {"height": 7.0}}, folder / "made.toml")
    assert made.kinds["goal"].height == 7.0
    assert made.title == "Mine"


def test_a_preset_is_tuned_on_given_timelines_and_reports_unreached_requirements(
    match, football, monkeypatch
):
    target = ["goal", "yellow_card", "foul"]
    with monkeypatch.context() as short:
        short.setattr(tuning, "TRIES", 6)  # whatever it reaches by then
        found = tune(football, target, [match])
    rng = np.random.default_rng(0)
    judged = [match, *(rearranged(match, rng) for _ in range(2))]
    gaps = gaps_of(found.preset, target, judged)
    assert found.least_jnds == pytest.approx(min(gap.jnds + (gap.second == REST) for gap in gaps))
    assert found.reached == (not found.unreached) == (found.least_jnds >= 2.0)
    assert found.missing_jnds <= found.missing_before
    same = ["goal", "own_goal"]
    limited = tune(
        preset_of(goal=20.0, own_goal=20.0), same, [timeline_of(*["goal", "own_goal"] * 2)]
    )
    assert limited.reached
    heights = [limited.preset.kinds[kind].height for kind in same]
    assert heights[0] > 1.5 * heights[1]


@pytest.mark.usefixtures("few_strokes")
def test_unreached_requirements_name_kind_gesture_and_timeline():
    # the strongest event lies so near to the other that this gets its level
    crowd = ov.Timeline("crowd", duration_s=10.0, events=(ov.Event(5.0, "a"), ov.Event(5.0, "b")))
    found = tune(preset_of(a=20.0, b=19.0), ["a", "b"], [crowd])
    assert not found.reached
    assert all("a is " in line or "b is " in line for line in found.unreached)
    assert any(
        "JNDs above b in " in line and " on crowd, rearranged, 2 required: a at 0:05" in line
        for line in found.unreached
    )
    assert all("is struck within 30 ms of" in line or " dB" in line for line in found.unreached)
    assert any(" recoil on " in line for line in found.unreached)


def test_timelines_with_equal_titles_are_measured_separately():
    far, near = timeline_of("a", "b", "b", "a"), timeline_of("a", "b", spacing=0.1)
    gaps = gaps_of(preset_of(a=60.0, b=6.0), ["a", "b"], [far, near])
    assert [(gap.first, gap.second) for gap in gaps] == [("a", "b"), ("b", REST)] * 2 * 2 * len(
        JUDGED
    )
    assert len({gap.jnds for gap in gaps if gap.second == "b" and gap.stroke == "1 s"}) == 2
    # what one of them gains can't hide what the other loses
    judge = tuning._Search(preset_of(a=60.0, b=6.0), ("a", "b"), (far, near), JUDGED)
    judged = judge.judged(judge.preset)
    assert set(judged.missing) == {0, 1}
    traded = judged._replace(missing={0: 1.0, 1: 2.0})
    assert not traded.is_not_worse_than(judged._replace(missing={0: 3.0, 1: 1.0}))


@pytest.mark.usefixtures("few_strokes")
def test_a_result_is_the_start_where_no_change_helps_and_never_at_a_limit():
    # a kind without friction is under each other
    preset = preset_of(a=20.0, b=900.0)
    found = tune(preset, ("a", "b"), seed=1)
    assert not found.reached
    assert found.missing_jnds <= found.missing_before
    for name, kind in found.preset.kinds.items():
        before = preset.kinds[name].height
        assert kind.height == before or before / 8.0 < kind.height < min(8.0 * before, 1000.0)
    assert all(
        ", 2 required: a at " in line and ", b at " in line
        for line in found.unreached
        if " b " in line
    )


def test_every_second_timeline_is_held_out_of_the_search_and_others_confirm_the_result(monkeypatch):
    one, other = timeline_of("a", "b", "b", "a"), timeline_of("b", "a", "a", "b")
    seen = []
    measured = tuning._Search.measured
    monkeypatch.setattr(
        tuning._Search,
        "measured",
        lambda self, *rest: (
            seen.append((frozenset(self.gestures), self.timelines)),
            measured(self, *rest),
        )[1],
    )
    assert tune(preset_of(a=20.0, b=18.0), ("a", "b"), [one, other], seed=1).reached
    further = seen[-1][1]
    assert len(further) == 6
    assert all(timeline.title.endswith("rearranged") for timeline in further)
    assert set(seen) == {
        (frozenset(JUDGED), (one, other)),
        (frozenset(tuning.SEARCHED), (one,)),
        (frozenset(JUDGED), further),
    }


@pytest.mark.usefixtures("few_strokes")
def test_a_change_that_others_do_not_confirm_is_no_result(monkeypatch):
    preset = preset_of(a=20.0, b=18.0)
    assert tune(preset, ("a", "b"), [timeline_of("a", "b", "b", "a")], seed=1).reached
    judged = tuning._Search.judged

    def worse_elsewhere(self, tried):
        found = judged(self, tried)
        is_further = all(one.title.endswith("rearranged") for one in self.timelines)
        return found._replace(unfelt=1) if is_further and tried is not preset else found

    monkeypatch.setattr(tuning._Search, "judged", worse_elsewhere)
    found = tune(preset, ("a", "b"), [timeline_of("a", "b", "b", "a")], seed=1)
    assert found.preset.kinds == preset.kinds
    assert not found.reached
    assert found.missing_jnds == found.missing_before > 0.0


def test_a_kind_that_no_timeline_has_gives_a_one_line_error(match, football):
    with pytest.raises(ov.InputError, match="no event of kind 'shot' is on the given timelines"):
        tune(football, ["goal", "shot"], [match])


@pytest.mark.usefixtures("few_strokes")
def test_the_command_tunes_on_timelines_and_keeps_the_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "child.toml").write_text(CHILD)
    done = overview(
        *("presets", "tune", "child.toml", MATCH, "--order", "goal>yellow_card>foul"),
        *("-o", "out.toml", "--json"),
    )
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["reached"] == (report["unreached"] == [])
    text = (tmp_path / "out.toml").read_text()
    assert text.startswith("# my match, kept as it is\n")
    assert 'extends = "football"' in text
    assert "hard = 40.0  # how hard" in text
    made = ov.load_preset("out.toml")
    for name, kind in report["kinds"].items():
        assert np.isclose(made.kinds[name].height, kind["height"])


@pytest.mark.usefixtures("few_strokes")
def test_a_change_that_is_worse_where_it_was_not_searched_is_not_taken(monkeypatch):
    preset = preset_of(strong=20.0, weak=18.0)
    worse = np.log([0.5, 2.0, 1.0, 1.0])  # heights, then widths: strong below weak
    monkeypatch.setattr(tuning._Search, "improved", lambda *_: worse)
    found = tune(preset, ("strong", "weak"), seed=1)
    assert found.preset.kinds == preset.kinds
    assert found.missing_jnds == found.missing_before > 0.0
    monkeypatch.setattr(tuning._Search, "improved", lambda *_: 4.0 * np.log([2.0, 1.0, 1.0, 1.0]))
    # the whole change is at a limit; a smaller one is enough
    made = tune(preset, ("strong", "weak"), seed=1).preset.kinds["strong"].height
    assert 20.0 < made <= 80.0
