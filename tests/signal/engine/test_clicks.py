"""The clicks: one strike for each event passed, placed between samples, ringing as stated."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.click import PULSE_SPACING
from overview_dsp.kernels.modal_bank import ring
from overview_dsp.measure.onset_detector import onsets
from tests.examples import preset_with, timeline_of
from tests.feel.test_football import MATCHES, SWEEPS, busy_match, timeline_named  # noqa: F401
from tests.kernels.deriving import mode_coefficients, ring_samples, write_click


@numba.njit
def rung(m, w, samples, frames):
    out = np.zeros(frames)
    for start in range(0, frames, layout.CHUNK):
        length = min(layout.CHUNK, frames - start)
        while w[layout.M_STRIKES] < samples.size and samples[w[layout.M_STRIKES]] < start + length:
            w[layout.M_STRIKES] += 1
        w[layout.CLOCK] = start
        ring(m, w, length)
        out[start : start + length] = m[layout.D_RING : layout.D_RING + length]
    return out


# a raised cosine of four samples
PULSES = np.sin(np.pi * (np.arange(8) + 0.5) / 8) ** 2 / 4


def struck(mode, times, rate, frames, level=1.0):
    """What the modal bank alone sounds for strikes at these times (samples, with fractions)."""
    m = np.zeros(layout.TOTAL)
    w = m.view(np.int64)
    write_click(m, mode, rate)
    for at, time in enumerate(times):
        m[layout.LOG_TIME + at] = time
        m[layout.LOG_LEVEL + at] = level
    return rung(m, w, np.array([int(time) for time in times], dtype=np.int64), frames)


def continuous(mode, time_s):
    """The mode in continuous time, struck at 0."""
    after = np.maximum(time_s, 0.0)
    fall = np.exp(-math.log(1000.0) * after / (mode.decay_ms * 1e-3))
    return 10 ** (mode.gain_db / 20) * fall * np.sin(2 * np.pi * mode.frequency_hz * after)


@pytest.mark.parametrize("time", [100.0, 100.25, 100.5, 100.999, 101.0])
def test_a_strike_between_samples_gives_the_samples_of_the_continuous_mode(time):
    mode, rate = ov.ClickMode(3250.0, 30.0, -5.0), 48_000.0
    # the log counts time from frame 0's start; frame n is heard at its end, n + 1
    expected = sum(
        weight * continuous(mode, (np.arange(4000) + 1 - time - number * PULSE_SPACING) / rate)
        for number, weight in enumerate(PULSES)
    )
    assert np.abs(struck(mode, [time], rate, 4000) - expected).max() < 2e-8  # it ends at -160 dB


def test_a_mode_falls_by_60_db_in_its_decay_time_and_ends_in_exact_zero():
    mode, rate = ov.ClickMode(1000.0, 50.0), 48_000.0
    out = struck(mode, [0.0], rate, 48_000)
    first = np.abs(out[:480]).max()
    later = np.abs(out[2400:2880]).max()
    assert 20 * math.log10(later / first) == pytest.approx(-60.0, abs=0.3)
    last = int(np.flatnonzero(out)[-1])
    assert abs(last - ring_samples(mode, rate)) <= 5
    assert np.abs(out[last - 200 :]).max() < 1e-7


def test_strikes_add_up():
    mode, rate = ov.ClickMode(2000.0, 20.0), 48_000.0
    both = struck(mode, [10.3, 300.7], rate, 3000)
    apart = struck(mode, [10.3], rate, 3000) + struck(mode, [300.7], rate, 3000)
    assert np.abs(both - apart).max() < 2e-8  # it ends at -160 dB


def test_a_mode_that_would_fold_back_is_left_out():
    edge = 4900.0  # 0.49 of the rate, and not a bit more
    assert mode_coefficients(ov.ClickMode(edge, 20.0), 10_000.0) is not None
    assert mode_coefficients(ov.ClickMode(math.nextafter(edge, 5000.0), 20.0), 10_000.0) is None
    assert np.all(struck(ov.ClickMode(4500.0, 20.0), [3.5], 8000.0, 200) == 0.0)


def test_no_preset_click_folds_back_above_minus_60_db(football):
    """Against the same click at 16 times the rate, within the band both have."""
    low, factor, frames = 48_000.0, 16, 1 << 13
    for kind in football.kinds.values():
        coarse, fine = np.zeros(frames), np.zeros(frames * factor)
        for mode in kind.modes:
            coarse += struck(mode, [40.37], low, frames)
            for number, weight in enumerate(PULSES):
                # the fine one's own contact is centred on the pulse
                time = (40.37 + number * PULSE_SPACING) * factor - 7 / 2 * PULSE_SPACING
                fine += weight * struck(mode, [time], low * factor, frames * factor)
        band = np.arange(frames // 2)
        # frame n of the coarse one is heard at n + 1, frame m of the fine one at (m + 1)/16
        turn = np.exp(-2j * np.pi * band / frames)
        turn_fine = np.exp(-2j * np.pi * band / (frames * factor))
        one = np.fft.rfft(coarse)[band] * turn
        other = np.fft.rfft(fine)[band] / factor * turn_fine
        folded = np.abs(one - other) ** 2
        assert 10 * np.log10(folded.max() / (np.abs(one) ** 2).max()) < -60.0
        assert 10 * np.log10(folded.sum() / (np.abs(one) ** 2).sum()) < -60.0


def entries(cursor, edges):
    """(trace frame, event) of each time a trace passes an event's lower edge up, its upper down."""
    path = np.concatenate([[0.0], cursor])
    found = []
    for event, (lower, upper) in enumerate(edges):
        up = (path[1:] >= lower) & (path[:-1] < lower)
        down = (path[1:] < upper) & (path[:-1] >= upper)
        found += [(int(frame), event) for frame in np.flatnonzero(up | down)]
    return sorted(found)


@pytest.mark.parametrize("name", MATCHES)
def test_there_is_exactly_one_strike_for_each_event_entered(timeline_named, football, name):  # noqa: F811
    timeline = timeline_named(name)
    for gesture in [ov.sweep(seconds) for seconds in SWEEPS] + [
        ov.tap(1.0, 1.5),
        ov.tap(0.4, 1.0),
        ov.sweep(1.0, 1.0, 0.0),
    ]:
        result = ov.render(timeline, football, gesture)
        surface = result.engine.surface
        expected = entries(result.trace.cursor, surface.edges)
        # one list sorted by sample, the other by time: the same set of passings
        frames = np.floor(result.strikes.time_s * result.sample_rate + 1e-9).astype(int)
        mine = sorted(zip(frames.tolist(), result.strikes.event.tolist(), strict=True))
        theirs = sorted((frame, int(surface.event[event])) for frame, event in expected)
        assert len(mine) == len(theirs)
        for (frame, event), (other_frame, other_event) in zip(mine, theirs, strict=True):
            assert abs(frame - other_frame) <= 1
            assert event == other_event


@pytest.mark.parametrize("name", MATCHES)
def test_a_full_sweep_strikes_every_event_once_out_and_once_back(timeline_named, football, name):  # noqa: F811
    timeline = timeline_named(name)
    result = ov.render(timeline, football, ov.sweep(2.0), trace=False)
    counts = np.bincount(result.strikes.event, minlength=len(timeline.events))
    assert np.all(counts == 2)


def test_events_at_the_very_ends_are_struck(football):
    timeline = timeline_of(0.0, 100.0)
    result = ov.render(timeline, preset_with(height=3.0, width=0.3), ov.sweep(1.0) + ov.pause(8.0))
    assert result.strikes.event.tolist() == [0, 1, 1, 0]


def test_a_strike_is_placed_between_samples_where_the_disk_enters():
    timeline = timeline_of(37.123)
    result = ov.render(timeline, preset_with(height=5.0), ov.tap(1.0, 0.5), tail=0.0)
    (time,) = result.strikes.time_s
    path = np.concatenate([[0.0], result.trace.cursor])
    clock = np.concatenate([[0.0], result.trace.time])
    lower = result.engine.surface.edges[0, 0]
    assert 0.35 < lower < 0.37123
    frame = int(np.flatnonzero(path >= lower)[0])
    part = (lower - path[frame - 1]) / (path[frame] - path[frame - 1])
    assert time == pytest.approx(clock[frame - 1] + part / result.sample_rate, abs=1e-9)
    fine = ov.render(timeline, preset_with(height=5.0), ov.tap(1.0, 0.5), 384_000, tail=0.0)
    assert time == pytest.approx(fine.strikes.time_s[0], abs=0.2 / result.sample_rate)


@pytest.mark.parametrize("name", MATCHES)
def test_every_strike_is_heard_as_an_onset_and_nothing_else_is(timeline_named, football, name):  # noqa: F811
    timeline = timeline_named(name)
    for gesture in [ov.sweep(seconds) for seconds in (*SWEEPS, 4.0)] + [
        ov.tap(1.0, 1.5),
        ov.tap(0.5, 1.0),
    ]:
        result = ov.render(timeline, football, gesture, trace=False)
        found = onsets(result.samples[:, 0], result.sample_rate)
        time = result.strikes.time_s
        near = np.abs(found.time_s[None, :] - time[:, None])
        heard = near.min(axis=1) < 4e-3
        alone = np.minimum(np.diff(time, prepend=-1.0), np.diff(time, append=1e9)) >= 0.030
        assert heard[alone].all()
        level = np.median(found.level_db[near.argmin(axis=1)[heard]])
        stray = near.min(axis=0) >= 4e-3
        assert not (found.level_db[stray] > level - 30.0).any()


def test_a_harder_passing_is_a_louder_strike():
    timeline = timeline_of(40.0)
    levels = []
    for seconds in (4.0, 2.0, 1.0, 0.5):
        result = ov.render(timeline, preset_with(height=5.0), ov.sweep(seconds), trace=False)
        levels.append((result.strikes.torque[0], result.strikes.level[0]))
    assert np.all(np.diff(np.array(levels), axis=0) > 0.0)


def test_a_disk_resting_on_an_event_does_not_rattle():
    timeline = timeline_of(50.0)
    gesture = ov.tap(0.5, 20.0)
    result = ov.render(timeline, preset_with(height=20.0), gesture, tail=0.0, trace=False)
    assert len(result.strikes) <= 1


def test_the_grain_follows_torque_and_speed_and_is_silent_at_rest(football):
    bare = timeline_of()
    football = football.with_changes({"tactor.slow_gain_exponent": 0.0})
    levels = []
    for seconds in (4.0, 2.0, 1.0):
        result = ov.render(bare, football, ov.sweep(seconds), trace=False)
        moving = result.samples[round(0.4 * seconds * 48_000) : round(0.9 * seconds * 48_000), 0]
        levels.append(float(np.sqrt(np.mean(moving.astype(float) ** 2))))
        assert np.all(result.samples[-1000:] == 0.0)
    assert levels[0] > 1e-5
    # power goes with the square of speed, so the level at least doubles
    assert levels[1] >= 2.0 * levels[0]
    assert levels[2] >= 2.0 * levels[1]


def test_a_slow_hands_grain_is_as_loud_as_a_faster_ones(football):
    levels = []
    for seconds in (4.0, 8.0, 16.0):
        result = ov.render(timeline_of(), football, ov.sweep(seconds), trace=False)
        moving = result.samples[round(0.4 * seconds * 48_000) : round(0.9 * seconds * 48_000), 0]
        levels.append(float(np.sqrt(np.mean(moving.astype(float) ** 2))))
    assert max(levels) / min(levels) < 1.6


def test_the_busy_match_is_really_busy():
    kinds = busy_match().kinds()
    assert kinds["goal"] == 4
    assert sum(kinds.values()) > 40
