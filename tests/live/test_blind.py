"""A blind comparison: who hears is right each time, who guesses is not, and nothing tells."""

from __future__ import annotations

import csv
import math
import random
import sys
from fractions import Fraction

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures.scripts import pause
from overview_dsp.live.session.blind import COLUMNS, BlindComparison, abx_d_prime, abx_p
from overview_dsp.live.session.commands import execute
from overview_dsp.measure.level_matching import MATCHED_DB, match_levels
from tests.cli.running import MATCH, environment, overview, refused
from tests.live.test_replay import session, wait
from tests.parameters import first_in_gate

__all__ = ["session"]  # a fixture

if sys.platform == "linux":
    from tests.live.terminal import Terminal

STROKE = ov.tap(0.4, 0.3)
HEARD = 24_000
"""Samples of a stroke that are compared."""


def presets_of(player):
    pair = player.active_window.presets
    return [pair.choose(index) for index in (1, 0)][::-1]


def feel(player, sound, name):
    """What one hears of a choice: a pass of the stroke, from its first sample."""
    execute(player, "blind", name)
    wait(player, lambda: not player.loop.playing, sound)
    return sound.passes[-1][:HEARD]


@pytest.mark.parametrize("other", first_in_gate(["football", "plain"]))
def test_a_robot_that_hears_is_right_each_time_and_each_stroke_is_its_render(
    session, match, tmp_path, other
):
    player, sound = session(other=other)
    presets = presets_of(player)
    if other == "football":  # a difference of 1 dB, which its bits have
        presets[1] = presets[1].with_value("tactor.gain_db", -1.0)
    path = tmp_path / "take.blind.csv"
    player.blind = BlindComparison(player, presets, path, STROKE, repeats=False, seed=5)
    renders = [ov.render(match, one, STROKE, trace=False).samples[:HEARD] for one in presets]
    order = []
    for _ in range(20):
        known = {name: feel(player, sound, name) for name in "ab"}
        np.testing.assert_array_equal(known["a"], renders[0])
        np.testing.assert_array_equal(known["b"], renders[1])
        unknown = feel(player, sound, "x")
        (same,) = [name for name in "ab" if np.array_equal(unknown, known[name])]
        order.append(same)
        execute(player, "blind", f"is-{same}")
    assert player.blind.hits == player.blind.trials == 20
    assert {*order} == {"a", "b"}
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert [row["x"].lower() for row in rows] == order
    assert [int(row["is_right"]) for row in rows] == [1] * 20
    assert float(rows[-1]["p"]) == pytest.approx(2.0**-20, rel=1e-3)
    assert "20 of 20 right" in player.blind.result_text


def test_a_robot_that_guesses_is_right_half_the_time_with_uniform_p(session, tmp_path):
    player, _ = session(other="plain")
    presets, dice = presets_of(player), random.Random(2)
    first = BlindComparison(player, presets, tmp_path / "all.csv", seed=1)
    ps = []
    for number in range(60):
        one = BlindComparison(player, presets, tmp_path / f"{number}.csv", seed=number)
        one._choose = lambda name, one=one: setattr(one, "felt_x", True)  # nothing is heard
        for _ in range(16):
            one.run("x")
            one.run(dice.choice(("is-a", "is-b")))
        first.hits, first.trials = first.hits + one.hits, first.trials + one.trials
        # uniform where each value has its own weight
        ps.append(abx_p(one.hits + 1, 16) + dice.random() * math.comb(16, one.hits) / 2**16)
    assert first.trials == 960
    assert abs(first.hits - 480) < 4.0 * math.sqrt(240.0)
    steps = np.arange(1, 61) / 60.0
    distance = np.abs(np.sort(ps) - steps).max()
    assert distance < 1.95 / math.sqrt(60.0)  # Kolmogorov and Smirnov, p = 0.001


def test_the_figures_of_an_abx_test_are_those_of_its_definition():
    for hits, trials in ((0, 5), (9, 12), (16, 16), (20, 31)):
        exact = sum(Fraction(math.comb(trials, k), 2**trials) for k in range(hits, trials + 1))
        assert abx_p(hits, trials) == pytest.approx(float(exact), rel=1e-12)
    # an observer who compares: likelier is the order of A and B, and then of X
    dice = np.random.default_rng(3)
    for d_prime in (0.8, 1.5, 2.5):
        a, b, x = (dice.normal(mean, 1.0, 400_000) for mean in (0.0, d_prime, d_prime))
        says_b = (x > d_prime / 2.0) == (b > a)
        assert abx_d_prime(int(says_b.sum()), len(x)) == pytest.approx(d_prime, abs=0.02)
    assert abx_d_prime(5, 10) == abx_d_prime(2, 10) == 0.0
    assert 0.0 < abx_d_prime(9, 10) < abx_d_prime(10, 10) < abx_d_prime(100, 100) < 10.0


def test_nothing_tells_which_preset_x_is(session, tmp_path):
    said = {}
    for seed in range(4):
        player, sound = session(other="plain")
        presets = presets_of(player)
        player.blind = BlindComparison(player, presets, tmp_path / f"{seed}.csv", seed=seed)
        for words in (("blind", "is-a"), ("blind", "x"), ("preset", "1"), ("preset", "plain"),
                      ("blind", "y")):  # fmt: skip
            execute(player, *words)
        player.choose_preset(1)
        said[player.blind.x] = wait(player, lambda: True, sound)
    assert said[0] == said[1]
    assert said[0][:2] == ["X was not felt yet; press x", "now X"]
    assert len([line for line in said[0] if "blind comparison chooses the preset" in line]) == 3
    assert said[0][-2].endswith("'y' must be a, b, x, is-a or is-b")


def test_answers_that_found_no_room_are_written_with_the_next(session, tmp_path):
    player, sound = session(other="plain")
    path = tmp_path / "gone" / "a.csv"
    player.blind = BlindComparison(player, presets_of(player), path, seed=1)
    for _ in range(2):
        execute(player, "blind", "x")
        execute(player, "blind", "is-a")
    said = wait(player, lambda: True, sound)
    assert len([line for line in said if str(path) in line]) == 2  # each is reported
    assert player.blind.trials == 2
    path.parent.mkdir()
    execute(player, "blind", "x")
    execute(player, "blind", "is-b")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert [row["trial"] for row in rows] == ["1", "2", "3"]
    assert [row["answer"] for row in rows] == ["A", "A", "B"]


def test_by_the_hand_each_choice_begins_at_rest(session, tmp_path):
    player, sound = session(other="plain")
    presets = presets_of(player)
    player.blind = BlindComparison(player, presets, tmp_path / "a.csv", seed=1)
    heard = []
    for name in "abab":
        execute(player, "blind", name)
        player.touch(0.5)
        sound.play(0.3)
        player.release()
        heard.append(sound.passes[-1])
        assert player.engine.preset == presets["ab".index(name)]
    np.testing.assert_array_equal(heard[0], heard[2])
    np.testing.assert_array_equal(heard[1], heard[3])
    assert not np.array_equal(heard[0], heard[1])


def test_the_command_belongs_to_a_blind_session_only(session):
    player, sound = session(other="plain")
    execute(player, "blind", "a")
    (line,) = wait(player, lambda: True, sound)
    assert "start it with --compare --blind" in line


def test_levels_are_matched_by_lowering_the_stronger_preset(match, football):
    plain, stroke = ov.load_preset("plain"), ov.sweep(2.0)
    first, second, report = match_levels(football, plain, match, stroke)
    samples = [ov.render(match, one, stroke, trace=False).samples for one in (first, second)]
    levels = [10.0 * np.log10(np.mean(one.astype(float) ** 2, axis=0)) for one in samples]
    assert np.abs(levels[0] - levels[1]).max() < 0.2 * MATCHED_DB
    for new, old in ((first, football), (second, plain)):
        for id in ("tactor.gain_db", "click.gain_db"):
            assert new.number(id) <= old.number(id)
    assert report.startswith("levels matched: ")
    with pytest.raises(ov.InputError, match=r"levels can't be matched: .* silent"):
        match_levels(football, plain, match, pause(0.2))  # nothing moves


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ((), "--blind needs a second preset: --compare PRESET"),
        (("--compare", "plain", "--record", "a.csv"), "remove --record"),
        (("--compare", "plain", "--remote"), "whose page shows the preset"),
        (("--compare", "plain", "--screen", "full"), "which shows the presets"),
        (("--compare", "plain"), "--blind needs a terminal"),
    ],
)
def test_options_that_would_show_the_preset_are_refused(options, reason):
    refused(overview("play", MATCH, "--device", "none", "--blind", *options), reason)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a pseudo-terminal of Linux")
def test_keys_of_a_session_in_a_terminal(tmp_path):
    ov.save_gesture(STROKE, tmp_path / "take.csv")
    surroundings = {**environment(), "XDG_STATE_HOME": str(tmp_path)}
    terminal = Terminal(
        ["play", MATCH, "--compare", "plain", "--blind", "--device", "none", "--replay",
         tmp_path / "take.csv"], surroundings,
    )  # fmt: skip
    terminal.wait_for(lambda: b"q to quit" in terminal.shown)
    terminal.wait_for(lambda: not terminal.echoes)
    for key in "axbA":
        terminal.press(key)
        expected = b"answer 1; X is drawn" if key == "A" else f"now {key.upper()}".encode()
        terminal.wait_for(lambda text=expected: text in terminal.shown)
    terminal.press("?")
    terminal.wait_for(lambda: b"X is A" in terminal.shown)
    terminal.press("q")
    assert terminal.end()[1] == 0
    (path,) = tmp_path.glob("take.blind-*.csv")
    (row,) = csv.DictReader(path.read_text().splitlines())
    assert row["answer"] == "A"
    assert f"of 1 right, p {'1' if row['is_right'] == '0' else '0.5'}".encode() in terminal.shown
