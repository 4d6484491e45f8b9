"""Auditions through the player of a haptic format: what it plays, and a blind comparison."""

from __future__ import annotations

import csv
import itertools
import json

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.cli.options.output import sample_player
from overview_dsp.cli.presets import through_player
from overview_dsp.measure.pictures import audition
from tests.cli.running import overview, refused

PLAYERS = ("ahap", "haptic", "hjif", "android")


@pytest.mark.parametrize("player", PLAYERS)
def test_a_players_vibration_has_the_level_of_its_own_decoded_clip(player, football, tmp_path):
    """The written clip is read again, and its level is that of the sound in each 10 ms."""
    result = audition(football)
    original, played = through_player.original_and_played(result, player)
    path = tmp_path / ("clip.json" if player == "android" else f"clip.{player}")
    ov.export.export(result, player, path)
    level = ov.export.read_clip(path).played
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
    refused(
        overview("presets", "audition", "football", "--blind-trials", 3),
        "--blind-trials needs a --player",
    )


@pytest.mark.parametrize("hears", [True, False])
def test_a_robot_that_hears_is_right_each_time(hears, football, tmp_path, monkeypatch):
    """One that answers A always is right as often as X was A."""
    pair = through_player.original_and_played(audition(football), "android")
    played = []

    def player(samples, sample_rate, index):
        played.append(samples)
        return sample_player(samples, sample_rate, index)

    class Robot:
        def __init__(self):
            self.keys = itertools.cycle(("A", "a", "?", "b", "x", "answer"))

        def next(self):
            key = next(self.keys)
            if key != "answer":
                return key
            a, b, x = played[-3:]
            assert not np.array_equal(a, b)
            assert np.array_equal(a[:, 0], pair[0].astype(np.float32))
            return "B" if hears and np.array_equal(x, b) else "A"

    monkeypatch.setattr(through_player, "sample_player", player)
    monkeypatch.setattr(through_player, "LineReader", Robot)
    path = tmp_path / "answers.csv"
    answers = through_player.compare_blind(pair, 48_000.0, "none", 20, path)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert answers.trials == len(rows) == 20  # "A" before X was felt is no answer
    assert answers.hits == (20 if hears else sum(row["x"] == "A" for row in rows))
