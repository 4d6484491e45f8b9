"""Auditions through the player of a haptic format: what it plays, and a blind comparison."""

from __future__ import annotations

import json

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.cli.presets import through_player
from overview_dsp.measure.pictures import audition
from tests.cli.running import overview, refused

PLAYERS = ("ahap", "haptic", "hjif", "android")


@pytest.mark.parametrize("player", PLAYERS)
def test_a_players_vibration_has_the_level_of_its_own_decoded_clip(player, football, tmp_path):
    """The written clip is read again, and its level is that of the sound in each 10 ms."""
    result = audition(football)
    original, played = through_player.original_and_played(result, player)
    ov.export.export(result, player, tmp_path / f"clip.{player}")
    suffix = ".json" if player == "android" else f".{player}"
    (tmp_path / f"clip.{player}").rename(tmp_path / f"clip{suffix}")
    level = ov.export.read_clip(tmp_path / f"clip{suffix}").played
    width = round(0.01 * result.sample_rate)
    count = min(len(level) // 10, len(played) // width)
    heard = np.sqrt(2.0 * np.mean(played[: count * width].reshape(count, width) ** 2, axis=1))
    expected = np.sqrt(np.mean(level[: 10 * count].reshape(count, 10) ** 2, axis=1))
    assert np.abs(heard - expected).max() < 0.06
    assert np.corrcoef(heard, expected)[0, 1] > 0.995
    both = [np.sqrt(np.mean(side**2)) for side in (original, played)]
    assert both[1] == pytest.approx(both[0], rel=0.35)


def test_the_file_has_the_original_and_then_the_players(folder, football):
    done = overview(
        "presets", "audition", "football", "--player", "haptic", "-o", "a.wav", "--json"
    )
    report = json.loads(done.out)
    samples, rate = soundfile.read(folder / "a.wav")
    original, played = through_player.original_and_played(audition(football), "haptic")
    begins = round(report["player_from_s"] * rate)
    assert np.array_equal(samples[:, 0], samples[:, 1])
    np.testing.assert_allclose(samples[: len(original), 0], original, atol=2**-15)
    np.testing.assert_allclose(samples[begins : begins + len(played), 0], played, atol=2**-15)
    assert not samples[len(original) : begins].any()
    refused(overview("presets", "audition", "football", "--blind-trials", 3), "need a --player")


@pytest.mark.parametrize("hears", [True, False])
def test_a_robot_that_hears_is_right_each_time(hears, football, tmp_path, monkeypatch):
    pair = through_player.original_and_played(audition(football), "android")
    heard = {}
    random = np.random.default_rng(3)

    class Sound(through_player.NullSamplePlayer):
        def __init__(self, samples, sample_rate):
            super().__init__(samples, sample_rate)
            heard["latest"] = samples
            assert samples.shape[1] == 2

    class Robot:
        def __init__(self):
            self.keys = []

        def next(self):
            if not self.keys:
                self.keys = ["a", "?", "b", "x", "answer"]
            key = self.keys.pop(0)
            if key == "a" or "a" not in heard:
                heard["a"] = heard.get("latest")
            if key != "answer":
                heard["key"] = key
                return key
            is_a = np.array_equal(heard["latest"][:, 1], pair[0].astype(np.float32))
            if not hears:
                is_a = random.random() < 0.5
            return "A" if is_a else "B"

    monkeypatch.setattr(through_player, "NullSamplePlayer", Sound)
    monkeypatch.setattr(through_player, "LineReader", Robot)
    answers = through_player.compare_blind(pair, 48_000.0, "none", 20, tmp_path / "answers.csv")
    assert answers.trials == 20
    assert answers.hits == 20 if hears else 3 <= answers.hits <= 17
    assert len((tmp_path / "answers.csv").read_text().splitlines()) == 21
