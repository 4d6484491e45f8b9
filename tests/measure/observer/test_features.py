"""What is noticed of made-up signals whose pulses are known."""

from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.measure.observer.features import (
    SOUND_FEATURES,
    TOUCH_FEATURES,
    stroke_features,
)
from overview_dsp.measure.observer.observing import add_sensory_noise
from overview_dsp.measure.perception import touch_pulses

RATE = 16_000
SECONDS = 1.5
QUIET_DB = -45.0


def signal(touch=(), clicks=(), rate=RATE):
    """Bursts of 250 Hz (at s, dB RMS, ms) on a quiet hum, and decaying 2 kHz clicks (at s, dB)."""
    time = np.arange(int(SECONDS * rate)) / rate
    level = np.full(len(time), QUIET_DB)
    for at, db, ms in touch:
        level[(time >= at) & (time < at + ms / 1000.0)] = db
    felt = np.sqrt(2.0) * 10.0 ** (level / 20.0) * np.sin(2.0 * np.pi * 250.0 * time)
    heard = np.zeros(len(time))
    for at, db in clicks:
        since = np.maximum(time - at, 0.0)
        ring = np.sin(2.0 * np.pi * 2000.0 * since) * np.exp(-since / 0.006) * (time >= at)
        heard += np.sqrt(2.0) * 10.0 ** (db / 20.0) * ring
    return np.stack([heard, felt], axis=1).astype(np.float32)


def named(found):
    return [dict(zip(found.names, row, strict=True)) for row in found.features]


def test_a_burst_is_noticed_where_it_is_with_its_level_rise_and_duration():
    found = stroke_features(signal([(0.5, -20.0, 60.0)]), RATE, ["touch"])["touch"]
    (one,) = named(found)
    assert 495 <= found.at_ms[0] <= 560
    assert one["level_db"] == pytest.approx(-20.0, abs=0.5)
    for name in ("over_surroundings_db", "rise_db"):
        assert one[name] == pytest.approx(25.0, abs=1.5)
    assert one["duration_ms"] == pytest.approx(60.0, abs=12.0)
    assert one["pulses_after"] == one["next_ms"] == one["last_ms"] == 0.0
    assert one["next_db"] == one["last_db"] == -30.0


def test_a_rise_is_an_onset_only_above_one_jnd():
    assert not len(
        stroke_features(signal([(0.5, QUIET_DB + 1.5, 60.0)]), RATE, ["touch"])["touch"].at_ms
    )
    assert (
        len(stroke_features(signal([(0.5, QUIET_DB + 4.0, 60.0)]), RATE, ["touch"])["touch"].at_ms)
        == 1
    )


def test_pulses_nearer_than_30_ms_are_one():
    near = stroke_features(signal([(0.5, -22.0, 8.0), (0.52, -20.0, 8.0)]), RATE, ["touch"])[
        "touch"
    ]
    apart = stroke_features(signal([(0.5, -22.0, 8.0), (0.55, -20.0, 8.0)]), RATE, ["touch"])[
        "touch"
    ]
    assert (len(near.at_ms), len(apart.at_ms)) == (1, 2)


def test_a_pulse_is_not_hidden_by_a_higher_level_that_is_no_pulse():
    # the last rise is cut off before it has fallen by a step
    at = ((0, -45.0), (100, -45.0), (110, -25.8), (125, -30.7), (136, -24.6), (140, -25.2))
    level = np.interp(np.arange(141.0), *np.transpose(at))
    assert touch_pulses(level).tolist() == [110]
    # where it falls, it is the pulse
    whole = np.interp(np.arange(200.0), *np.transpose([*at, (150, -45.0)]))
    assert touch_pulses(whole).tolist() == [136]


def test_a_neighbour_within_120_ms_is_part_of_the_figure_and_a_later_one_is_not():
    near = stroke_features(signal([(0.5, -20.0, 8.0), (0.58, -26.0, 8.0)]), RATE, ["touch"])[
        "touch"
    ]
    first, second = named(near)
    assert first["pulses_after"] == 1.0
    assert first["next_ms"] == pytest.approx(80.0, abs=4.0)
    assert second["last_ms"] == pytest.approx(80.0, abs=4.0)
    assert first["next_db"] == pytest.approx(-6.0, abs=1.0)
    assert second["last_db"] == pytest.approx(6.0, abs=1.0)
    later = stroke_features(signal([(0.5, -20.0, 8.0), (0.7, -26.0, 8.0)]), RATE, ["touch"])[
        "touch"
    ]
    assert [one["pulses_after"] for one in named(later)] == [0.0, 0.0]


def test_a_click_has_its_level_its_pitch_and_its_decay():
    samples = signal(clicks=[(0.5, -20.0), (1.0, -32.0)], rate=48_000)
    found = stroke_features(samples, 48_000, ["sound"])["sound"]
    loud, soft = named(found)
    assert found.names == SOUND_FEATURES
    assert loud["click_db"] - soft["click_db"] == pytest.approx(12.0, abs=0.5)
    for one in (loud, soft):
        assert 1800.0 < one["centroid_hz"] < 2600.0
        # 15 dB of an amplitude that falls by e in 6 ms
        assert one["click_decay_ms"] == pytest.approx(10.4, abs=3.0)


def test_the_modality_both_has_felt_onsets_with_clicks_and_heard_onsets():
    samples = signal([(0.3, -20.0, 20.0)], [(0.31, -20.0), (0.9, -20.0)])
    found = stroke_features(samples, RATE, ["touch", "sound", "both"])
    assert [len(one.at_ms) for one in found.values()] == [1, 2, 2]
    assert found["both"].names == TOUCH_FEATURES + SOUND_FEATURES
    with_click, alone = named(found["both"])
    assert with_click["click_db"] > -30.0
    assert abs(with_click["click_delay_ms"]) <= 30.0
    assert alone["level_db"] == pytest.approx(QUIET_DB, abs=1.0)


def test_silence_has_no_onsets():
    for found in stroke_features(np.zeros((RATE, 2), np.float32), RATE).values():
        assert found.features.shape == (0, len(found.names))


def test_a_given_pace_is_a_feature():
    pace = np.linspace(-3.0, 0.0, int(SECONDS * 1000))
    found = stroke_features(signal([(0.5, -20.0, 60.0)]), RATE, ["touch"], pace)["touch"]
    assert found.names == (*TOUCH_FEATURES, "pace")
    assert found.features[0, -1] == pace[found.at_ms[0]]


@pytest.mark.parametrize(
    ("name", "value", "deviation"),
    [
        ("level_db", -20.0, 1.6),
        ("over_surroundings_db", 12.0, 1.6),
        ("rise_db", 12.0, 1.6),
        ("fall_db", 12.0, 1.6),
        ("slope_db", 8.0, 0.30 * 8.0),
        ("duration_ms", 40.0, 0.18 * 40.0),
        ("next_ms", 60.0, 5.0),
        ("next_db", -3.0, 1.6),
        ("pulses_after", 1.0, 0.0),
        ("click_db", -30.0, 0.8),
        ("centroid_hz", 2000.0, 0.07 * 2000.0),
        ("click_decay_ms", 20.0, 0.18 * 20.0),
        ("click_delay_ms", 0.0, 8.0),
        ("pace", -1.0, 0.15),
    ],
)
def test_each_feature_is_blurred_by_what_a_person_cannot_know_better(name, value, deviation):
    names = (*TOUCH_FEATURES, *SOUND_FEATURES, "pace")
    features = np.zeros((20_000, len(names)))
    features[:, names.index("next_ms")] = 60.0
    features[:, names.index(name)] = value
    before = features.copy()
    found = add_sensory_noise(features, names, np.random.default_rng(0))[:, names.index(name)]
    assert found.std() == pytest.approx(deviation, rel=0.08)
    assert np.median(found) == pytest.approx(value, abs=0.1 * max(deviation, 0.01))
    assert np.array_equal(features, before)


def test_noise_does_not_change_features_of_a_missing_neighbour():
    names = TOUCH_FEATURES
    features = np.zeros((100, len(names)))
    features[:, names.index("next_db")] = -30.0
    found = add_sensory_noise(features, names, np.random.default_rng(0))
    assert (found[:, names.index("next_ms")] == 0.0).all()
    assert (found[:, names.index("next_db")] == -30.0).all()
