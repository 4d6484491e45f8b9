"""The players' models beside what the renderers' sources and measurements say they do."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.offline.export import ahap, android, breakpoints
from overview_dsp.offline.export import haptic as meta
from overview_dsp.offline.export import hjif as mpeg
from overview_dsp.offline.export.clip import Clip, Transient
from overview_dsp.offline.export.document import read


def haptic(*points):
    amplitude = [
        {"time": time, "amplitude": level}
        | ({"emphasis": {"amplitude": strike[0], "frequency": strike[1]}} if strike else {})
        for time, level, strike in points
    ]
    signals = {"continuous": {"envelopes": {"amplitude": amplitude, "frequency": []}}}
    return read(meta.Haptic, {"signals": signals})


def quest(*points):
    return meta.on_quest(haptic(*points))


def test_meta_ramps_between_points():
    level = quest((0.0, 0.0, None), (1.0, 1.0, None))
    np.testing.assert_allclose(level[:-1], np.linspace(0.0, 1.0, 1001)[:-1], atol=6e-4)


@pytest.mark.parametrize(("frequency", "length_ms"), [(0.0, 36.0), (0.5, 24.0), (1.0, 12.0)])
def test_meta_ducks_to_a_half_for_as_long_as_an_emphasis_lasts(frequency, length_ms):
    level = quest((0.0, 0.4, None), (0.5, 0.4, (0.6, frequency)), (1.0, 0.4, None))
    struck = np.flatnonzero(np.abs(level - 0.4) > 1e-6)
    assert struck[0] == 500
    # half a millisecond at both ends
    assert len(struck) == length_ms + 1
    np.testing.assert_allclose(level[struck[1:-1]], 0.5 * 0.4 + 0.6)


def test_metas_next_emphasis_takes_the_place_of_one_that_lasts():
    level = quest((0.0, 0.0, (0.9, 0.0)), (0.01, 0.0, (0.3, 0.0)), (0.2, 0.0, None))
    assert level[9] == pytest.approx(0.9)
    assert level[11] == pytest.approx(0.3)
    assert level[10 + 37] == 0.0


def test_meta_never_passes_full_scale():
    assert quest((0.0, 1.0, (1.0, 1.0)), (0.1, 1.0, None)).max() == 1.0


PLAYED_BY_META = (
    (0.0, 0.2, None), (0.031, 0.6, None), (0.032, 0.0, (0.8, 0.5)), (0.055, 0.0, None),
    (0.056, 0.4, None), (0.09, 0.5, (0.9, 1.0)), (0.125, 0.1, None),
)  # fmt: skip


def test_metas_amplitude_curve_is_what_its_renderer_plays():
    """The numbers are from ParametricHapticRenderer at 2 kHz, as amplitude curve."""
    level = meta.curve(haptic(*PLAYED_BY_META), 2000, catch_up=True)
    assert len(level) == 250
    places = [0, 1, 30, 60, 61, 62, 63, 64, 65, 110, 111, 112, 180, 203, 249]
    # the renderer's 1.0853 at 203 is over full scale
    played = [0.2, 0.2066, 0.3967, 0.5934, 0.6, 0.6, 0.0, 0.0, 0.8, 0.8, 1.0, 1.0, 0.5, 1.0, 0.1]
    np.testing.assert_allclose(level[places], played, atol=1e-4)


def test_metas_steps_on_android_are_what_its_renderer_plays():
    """The numbers are from render_waveform: 10 ms late ramps, and whole steps of emphases."""
    level = meta.on_android(haptic(*PLAYED_BY_META))
    steps = [51, 99, 148, 153, 204, 204, 102, 112, 123, 127, 255, 86, 45]
    assert len(level) == 125
    assert np.rint(255.0 * level[::10]).tolist() == steps


def hjif(*bands, gains=(1.0, 1.0)):
    limits = {"lower_frequency_limit": 0, "upper_frequency_limit": 500}
    channel = {"id": 0, "description": "", "mixing_coefficient": 1.0, "body_part_mask": 0}
    channels = [
        mpeg.Channel(
            **channel, gain=gain, bands=[mpeg.Band(band_type=kind, effects=effects, **limits)]
        )
        for (kind, effects), gain in zip(bands, gains, strict=False)
    ]
    perception = mpeg.Perception(
        id=0,
        avatar_id=0,
        description="",
        perception_modality="Vibrotactile",
        channels=channels,
        effect_library=[],
    )
    return mpeg.Hjif(
        version="2023",
        profile="Main",
        level=1,
        date="2026-07-01",
        description="",
        timescale=1000,
        perceptions=[perception],
        avatars=[],
        syncs=[],
    )


def mpeg_level(document):
    return mpeg.decoded(document)[2]


def wave(position, *frames, hz=250, phase=0.0):
    keyframes = [
        mpeg.Keyframe(relative_position=at, amplitude_modulation=level, frequency_modulation=hz)
        for at, level in frames
    ]
    return mpeg.Effect(
        effect_type="Basis", position=position, phase=phase, base_signal="Sine", keyframes=keyframes
    )


def test_the_mpeg_reference_plays_a_wave_as_its_keyframes_say():
    # measured: 250 Hz, 0 -> 1 -> 0 has a peak of 0.995
    level = mpeg_level(hjif(("VectorialWave", [wave(0, (0, 0.0), (500, 1.0), (1000, 0.0))])))
    assert 20.0 * np.log10(level.max() / 0.995) == pytest.approx(0.0, abs=0.1)
    assert level[250] == pytest.approx(0.5)


def test_the_mpeg_reference_plays_a_transient_of_22_ms_whatever_is_asked():
    silence = wave(0, (0, 0.0), (200, 0.0))
    level = mpeg_level(
        hjif(("Transient", [wave(100, (0, 0.7), hz=180)]), ("VectorialWave", [silence]))
    )
    # a millisecond is around its moment: half of the first and last
    assert np.flatnonzero(level).tolist() == list(range(100, 123))
    assert level[[100, 122]] == pytest.approx(0.7 / np.sqrt(2.0))
    assert level.max() == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("position", "phase", "summed"),
    [(4, 0.0, 1.0), (2, 0.0, 0.2), (1, 0.0, np.hypot(0.6, 0.4)), (4, np.pi, 0.2)],
)
def test_the_mpeg_reference_adds_channels_of_one_frequency_by_their_phase(position, phase, summed):
    # a period is 4 ms
    first = wave(0, (0, 0.6), (50, 0.6), (100, 0.6))
    second = wave(position, (0, 0.4), (20, 0.4), (40, 0.4), phase=phase)
    level = mpeg_level(hjif(("VectorialWave", [first]), ("VectorialWave", [second])))
    assert level[20] == pytest.approx(summed)
    time = np.arange(0.0, 0.1, 1e-5)
    carrier = 0.6 * np.sin(2 * np.pi * 250 * time)
    late = time - position / 1000.0
    inside = (late >= 0) & (late < 0.04)
    carrier += inside * 0.4 * np.sin(2 * np.pi * 250 * late + phase)
    heard = np.abs(carrier[(time > 0.01) & (time < 0.03)]).max()
    assert level[20] == pytest.approx(heard, abs=0.002)


def test_the_mpeg_reference_multiplies_by_a_channels_gain_and_adds_other_pitches_in_energy():
    first = wave(0, (0, 0.6), (50, 0.6), (100, 0.6))
    second = wave(0, (0, 0.8), (50, 0.8), (100, 0.8), hz=180)
    level = mpeg_level(
        hjif(("VectorialWave", [first]), ("VectorialWave", [second]), gains=(0.5, 1.0))
    )
    assert level[10] == pytest.approx(np.hypot(0.3, 0.8))


@pytest.mark.parametrize("length", ahap.TRANSIENTS_MS)
def test_a_core_haptics_transient_is_a_burst_that_adds_in_energy(length):
    level = ahap.with_transients(
        np.full(100, 0.3), [ov.export.Transient(0.05, 0.4, 0.5, "")], length
    )
    np.testing.assert_allclose(level[51 : 50 + length], 0.5)
    half = np.sqrt(0.3**2 + 0.5 * 0.4**2)  # a millisecond is around its moment
    np.testing.assert_allclose(level[[50, 50 + length]], half)
    np.testing.assert_allclose(np.delete(level, np.arange(50, 51 + length)), 0.3)


def test_an_envelope_effect_starts_from_nothing_and_ramps_to_each_point():
    points = [
        android.ControlPoint(amplitude=amplitude, frequencyHz=250.0, durationMs=length)
        for amplitude, length in ((0.5, 50), (0.0, 100))
    ]
    effect = android.EnvelopeEffect(startMs=100, initialFrequencyHz=250.0, controlPoints=points)
    level = android.envelopes_played([effect])
    assert level[100] == 0.0
    assert level[125] == pytest.approx(0.25)
    assert level[150] == pytest.approx(0.5)
    assert level[200] == pytest.approx(0.25)
    assert len(level) == 251


def test_a_waveform_holds_each_amplitude():
    wave = android.Waveform(amplitudes=[255, 51], timings=[10, 25], repeat=-1)
    assert android.waveform_played(wave).tolist() == [1.0] * 10 + [0.2] * 25 + [0.0]


def test_strikes_of_later_android_effects_are_relative_to_their_effect(monkeypatch):
    """The effect of a strike after 1.5 s spends its points on that strike."""
    strike_s, surface = 2.3, None
    transients = (Transient(0.4, 0.8, 0.5, "goal"), Transient(strike_s, 0.8, 0.5, "goal"))
    clip = Clip("made", np.append(np.full(3000, 0.4), 0.0), 250.0, transients, surface)
    strikes_ms = []

    def control_points(level, strikes, *limits):
        assert all(0 <= at < len(level) for at in strikes)
        strikes_ms.append(list(strikes))
        return breakpoints.control_points(level, strikes, *limits)

    monkeypatch.setattr(android, "control_points", control_points)
    effects = android.envelopes(clip)
    found = [
        (effect.startMs + at) / 1000.0
        for effect, strikes in zip(effects, strikes_ms, strict=True)
        for at in strikes
    ]
    assert len(effects) > 1
    assert found == pytest.approx([0.4, strike_s])
