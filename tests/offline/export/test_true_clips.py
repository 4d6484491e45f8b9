"""On real matches, what a player makes of a clip is what was rendered, strikes included."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.offline.export import haptic
from overview_dsp.offline.export.clip import Transient, clip_of, perceptual_error
from overview_dsp.offline.export.document import read
from overview_dsp.offline.export.writing import export

MATCHES = {
    "bundled": None,
    "statsbomb-22936": "statsbomb/22936.json",
    "statsbomb-15986": "statsbomb/15986.json",
    "statsbomb-69321": "statsbomb/69321.json",
    "metrica": "metrica/Sample_Game_1_RawEventsData.csv",
    "wyscout": "wyscout/wyscout_v2_match_2499773.json",
}
PLAYERS = {
    "ahap": "Core Haptics, strikes of 12 ms",
    "haptic": "Quest",
    "hjif": "MPEG reference",
    "android": "Android waveform",
}


@pytest.fixture(scope="module", params=MATCHES)
def real_match(request, match):
    if MATCHES[request.param] is None:
        return match
    return ov.load_timeline(
        request.getfixturevalue("data_folder") / "football" / MATCHES[request.param]
    )


@pytest.fixture(
    scope="module",
    params=[ov.sweep(4.0), ov.sweep(1.0), ov.tap(0.8, 1.5)],
    ids=["sweep", "fast", "tap"],
)
def result(request, real_match, football):
    return ov.render(real_match, football, request.param)


@pytest.mark.parametrize("to", PLAYERS)
def test_strikes_included_nine_tenths_of_a_clip_are_within_a_step(result, tmp_path, to):
    done = export(result, to, tmp_path / "clip")
    error = done.players[PLAYERS[to]]
    assert error == done.error
    assert error.median_db <= 1.5
    assert error.within_percent >= 90.0


def test_other_lengths_of_apples_transients_and_androids_envelopes_are_told(result, tmp_path):
    ahap = export(result, "ahap", tmp_path / "clip").players
    assert set(ahap) == {f"Core Haptics, strikes of {length} ms" for length in (12, 6, 22)}
    assert min(error.within_percent for error in ahap.values()) >= 85.0
    envelope = export(result, "android", tmp_path / "clip").players["Android envelope effects"]
    assert envelope.within_percent >= 65.0


def test_each_goal_strikes_at_its_place_as_strong_as_it_is_felt_and_above_every_foul(result):
    clip = clip_of(result)
    events = result.engine.timeline.events
    goals = [
        time
        for time, event in zip(result.strikes.time_s, result.strikes.event, strict=True)
        if events[event].kind in ("goal", "own_goal") and time < clip.duration_s - 0.005
    ]
    assert goals
    struck = {
        kinds: [strike for strike in clip.transients if strike.kind in kinds]
        for kinds in (("goal", "own_goal"), ("foul",))
    }
    own, fouls = struck.values()
    for time in goals:
        nearest = min(own, key=lambda strike: abs(strike.time_s - time))
        assert abs(nearest.time_s - time) <= 0.005
        at = round(time * 1000)
        assert nearest.amplitude == pytest.approx(clip.felt[at : at + 20].max(), rel=0.02)
    assert min(strike.amplitude for strike in own) > max(
        (strike.amplitude for strike in fouls), default=0.0
    )


def test_a_strike_stands_out_of_what_is_around_it(result):
    clip = clip_of(result)
    for strike in clip.transients:
        at = round(strike.time_s * 1000)
        around = np.concatenate([clip.felt[max(0, at - 12) : at - 3], clip.felt[at + 25 : at + 80]])
        assert strike.amplitude > 1.3 * around.min()


def test_errors_are_over_the_felt_time_and_name_the_event_with_the_largest():
    rendered, played = np.zeros(1000), np.zeros(1000)
    rendered[:100], played[:100] = 0.5, 0.5 * 10.0 ** (-1.0 / 20.0)
    played[60:70] = 0.05  # 20 dB less after the second strike
    strikes = [Transient(0.0, 0.5, 0.5, "foul"), Transient(0.055, 0.5, 0.5, "goal")]
    error = perceptual_error(played, rendered, strikes)
    assert error.median_db == pytest.approx(1.0)  # silence agrees for 900 ms, and doesn't count
    assert error.within_percent == pytest.approx(90.0)
    assert error.worst_event == strikes[1]
    assert error.worst_db == error.largest_db == pytest.approx(20.0)
    silent = perceptual_error(np.zeros(50), np.zeros(50), strikes)
    assert (silent.within_percent, silent.worst_event) == (100.0, None)


def test_metas_player_on_android_holds_amplitudes_for_10_ms_and_never_stops():
    points = [{"time": 0.0, "amplitude": 0.0}, {"time": 0.026, "amplitude": 1.0}]
    signals = {"continuous": {"envelopes": {"amplitude": points, "frequency": []}}}
    played = haptic.on_android(read(haptic.Haptic, {"signals": signals}))
    assert len(played) == 26
    assert played[:10] == pytest.approx(1.0 / 255.0)
    # a ramp of 2.6 steps reaches its end 1.6 steps later
    assert played[10:20] == pytest.approx(np.floor(255.0 / 1.6) / 255.0)
    assert played[20:] == pytest.approx(1.0)


def test_a_reader_that_rounds_times_down_finds_each_ahap_point_at_its_millisecond(result, tmp_path):
    (path, *_) = export(result, "ahap", tmp_path / "clip.ahap").files
    curves = [entry.get("ParameterCurve") for entry in json.loads(path.read_text())["Pattern"]]
    times = [
        (one["Time"] + point["Time"]) * 1000.0
        for one in curves
        if one
        for point in one["ParameterCurveControlPoints"]
    ]
    assert [int(time) for time in times] == [round(time) for time in times]
