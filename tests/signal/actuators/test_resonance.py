"""A resonance from a recording of a sweep, and overdrive that is never worse than none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from scipy.signal import lfilter

import overview_dsp as ov
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
from overview_dsp.signal.actuators.model import ONE_OF, error_limit
from overview_dsp.signal.actuators.resonance import QUANTITIES, fit_resonance
from overview_dsp.signal.actuators.sweep import log_sweep
from tests.cli.running import overview, refused
from tests.signal.actuators.driving import (
    RATE,
    burst,
    changed,
    driven,
    envelope,
    motion,
    rise_ms,
)

LOW, HIGH, SECONDS = 20.0, 1000.0, 10.0
SMALL_RATE = 8000


def recorded(actuator, rate=SMALL_RATE, quantity="acceleration", noise=0.0, seed=1):
    """A recording of a sweep: late, distorted, with noise of this part of its RMS."""
    sweep = log_sweep(LOW, HIGH, SECONDS, -9.0, rate)
    drive = np.pad(sweep + 0.05 * sweep**2 + 0.05 * sweep**3, (round(0.37 * rate), rate))
    u = 1j * np.fft.rfftfreq(len(drive), 1.0 / rate) / actuator.resonance_hz
    power = ("displacement", "velocity", "acceleration").index(quantity)
    moved = np.fft.irfft(np.fft.rfft(drive) * u**power / (1.0 + u / actuator.q + u * u), len(drive))
    random = np.random.default_rng(seed)
    moved = moved / np.sqrt(np.mean(np.square(moved)))
    return 0.05 * (moved + noise * random.standard_normal(len(moved)))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_frequency_and_q_are_found_within_the_stated_tolerance(quantity, seed):
    random = np.random.default_rng(seed)
    hertz, q = np.exp(random.uniform(np.log([60.0, 1.2]), np.log([400.0, 30.0]))).tolist()
    noise = random.choice([0.0, 0.1, 0.5])
    coil = changed(load_actuator("voice_coil"), resonance__frequency_hz=hertz, resonance__q=q)
    recording = recorded(coil, quantity=quantity, noise=noise, seed=seed)
    fit = fit_resonance(recording, SMALL_RATE, LOW, HIGH, SECONDS, quantity)
    assert fit.frequency_hz == pytest.approx(hertz, rel=0.01 * fit.tolerance_percent)
    assert fit.q == pytest.approx(q, rel=0.05)
    assert fit.residual_db < 1.0


def test_noise_and_another_quantity_are_refused_with_what_to_do():
    random = np.random.default_rng(1)
    hiss = 0.1 * random.standard_normal(13 * SMALL_RATE)
    with pytest.raises(ov.InputError, match="mostly something else than this sweep; record closer"):
        fit_resonance(hiss, SMALL_RATE, LOW, HIGH, SECONDS)
    c2 = load_actuator("c2")
    with pytest.raises(ov.InputError, match="quantity is 'loudness'; must be one of displacement"):
        fit_resonance(recorded(c2), SMALL_RATE, LOW, HIGH, SECONDS, "loudness")
    with pytest.raises(ov.InputError, match=r"lasts 5.00 s; must contain the whole sweep of 10.00"):
        fit_resonance(recorded(c2)[: 5 * SMALL_RATE], SMALL_RATE, LOW, HIGH, SECONDS)
    sweep = log_sweep(LOW, HIGH, SECONDS, -9.0, SMALL_RATE)
    with pytest.raises(ov.InputError, match="no resonance between 21 and 952 Hz explains"):
        fit_resonance(sweep, SMALL_RATE, LOW, HIGH, SECONDS)


@pytest.mark.parametrize("share", [0.9, 0.5, 0.2])
def test_a_clipped_recording_whose_q_would_be_too_low_is_refused(share):
    clean = recorded(load_actuator("c2"), noise=0.02)
    limit = share * np.abs(clean).max()
    with pytest.raises(
        ov.InputError, match=r"is clipped \(\d+ samples at its highest level\); lower"
    ):
        fit_resonance(np.clip(clean, -limit, limit), SMALL_RATE, LOW, HIGH, SECONDS)
    coarse = np.round(clean / np.abs(clean).max() * 300.0) / 32768.0  # low, but not clipped
    assert fit_resonance(coarse, SMALL_RATE, LOW, HIGH, SECONDS).q == pytest.approx(11.8, rel=0.1)


@pytest.mark.parametrize("seconds", [4.0, 7.0, 20.0])
@pytest.mark.parametrize("what", ["offset", "white", "brown", "hum", "coloured", "click", "none"])
def test_a_recording_of_something_else_is_refused(what, seconds):
    random = np.random.default_rng(2)
    count = round(SMALL_RATE * (seconds + 1.5))
    noise, time_s = random.standard_normal(count), np.arange(count) / SMALL_RATE
    sound = {
        "offset": 1.0 + 1e-3 * noise,
        "white": noise,
        "brown": np.cumsum(noise),
        "hum": np.sin(2.0 * np.pi * 100.0 * time_s) + 0.3 * np.sin(2.0 * np.pi * 200.0 * time_s),
        "coloured": lfilter([1.0], [1.0, -1.8, 0.9], noise),
        "click": np.eye(1, count, count // 2)[0],
        "none": 0.0 * noise,
    }[what]
    with pytest.raises(ov.InputError):
        fit_resonance(sound, SMALL_RATE, LOW, HIGH, seconds)


@pytest.mark.parametrize(
    ("high", "seconds"), [(105.0, 5.0), (140.0, 5.0), (200.0, 5.0), (800.0, 3.9)]
)
def test_a_sweep_that_is_too_short_to_be_measured_is_refused(high, seconds):
    words = f"100 to {high:g} Hz in {seconds:g} s; must span over an octave, and last 4 s or more"
    with pytest.raises(ov.InputError, match=words):
        fit_resonance(np.zeros(6 * SMALL_RATE), SMALL_RATE, 100.0, high, seconds)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_samples_that_are_not_finite_are_refused(value):
    sound = recorded(load_actuator("c2"))
    sound[100] = value
    with pytest.raises(ov.InputError, match="has samples that are not finite; record it again"):
        fit_resonance(sound, SMALL_RATE, LOW, HIGH, SECONDS)


def test_the_command_writes_a_profile_with_the_measured_resonance(tmp_path, monkeypatch):
    """A C-2 whose resonance is 6 % higher than its profile says, recorded in the right channel."""
    monkeypatch.chdir(tmp_path)
    true = changed(load_actuator("c2"), resonance__frequency_hz=265.0)
    channels = np.stack([np.zeros(len(recorded(true))), recorded(true, noise=0.05)], axis=1)
    soundfile.write("recording.wav", channels, SMALL_RATE, subtype="PCM_16")
    done = overview("actuators", "measure", "c2", "recording.wav", "--input-channel", "2",
                    "--duration", f"{SECONDS:g}")  # fmt: skip
    assert done.code == 0, done.err
    assert done.out.startswith("c2-measured.toml: resonance 26")
    measured = load_actuator(tmp_path / "c2-measured.toml")
    assert measured.resonance_hz == pytest.approx(265.0, rel=0.005)
    assert measured.q == pytest.approx(true.q, rel=0.05)
    assert measured.values["resonance.tolerance_percent"] < 0.5
    assert measured.values["drive.peak"] == true.values["drive.peak"]
    assert measured.overdrive_q == pytest.approx(measured.q / 3.0)
    assert "from memory and not from a data sheet" in (tmp_path / "c2-measured.toml").read_text()
    assert overview("actuators", "show", "c2-measured.toml").code == 0
    refused(overview("actuators", "measure", "c2", "nothing.wav"), "nothing.wav: can't be read")
    refused(
        overview("actuators", "measure", "c2", "recording.wav", "--duration", "10"),
        "recording.wav: the recording is mostly something else than this sweep",
    )
    again = ("actuators", "measure", "c2-measured.toml", "recording.wav", "--input-channel", "2",
             "--duration", "10", "-o")  # fmt: skip
    for kept in ("c2-measured.toml", "recording.wav"):
        refused(overview(*again, kept), f"{kept}: is an input of this command")
    assert overview(*again, "again.toml").code == 0
    refused(
        overview("actuators", "measure", "c2", "recording.wav", "--input-channel", "3"),
        "recording.wav has 2 channels; --input-channel is 3",
    )


def edges(actuator, true):
    """Rise and last time above a tenth after the end, ms, and highest level, of the motion."""
    hertz = actuator.resonance_hz
    drive, _ = driven(actuator, burst(hertz, 0.4, 0.4, 0.3))
    level = envelope(motion(true, drive), hertz)
    end = round(0.4 * RATE)
    full = np.median(level[end - RATE // 50 : end])
    last = np.flatnonzero(level[end:] > 0.1 * full)
    return rise_ms(level, full), 1e3 / RATE * last[-1], level.max() / full


def never_worse(actuator, error):
    """Whether a drive is no worse than a plain one if the resonance is off by so much."""
    plain = changed(actuator, shaping__overdrive=1.0)
    values = {id: value for id, value in plain.values.items() if id not in ONE_OF}
    moved = {"resonance.frequency_hz": (1.0 + error) * actuator.resonance_hz}
    true = replace(plain, values={**values, **moved, "resonance.q": actuator.q})
    pairs = zip(edges(actuator, true), edges(plain, true), strict=True)
    return all(with_drive <= 1.02 * without for with_drive, without in pairs)


@pytest.mark.parametrize("error", [-0.1, -0.05, 0.0, 0.05, 0.1])
@pytest.mark.parametrize("name", actuator_names())
def test_a_bundled_actuator_is_driven_no_worse_where_its_resonance_is_elsewhere(name, error):
    actuator = load_actuator(name)
    assert never_worse(actuator, error)
    assert never_worse(changed(actuator, shaping__overdrive=4.0), error)


@pytest.mark.parametrize("q", [3.5, 5.0, 8.0, 11.8, 20.0, 40.0])
@pytest.mark.parametrize("side", [-1.0, 0.0, 1.0])
def test_overdrive_is_never_worse_within_the_highest_tolerance(q, side):
    values = {**load_actuator("c2").values, "resonance.q": q, "shaping.overdrive": min(3.0, q)}
    del values["resonance.rise_ms"]
    c2 = ov.actuators.Actuator("c2", "C-2", "a C-2", values)
    measured = changed(c2, resonance__tolerance_percent=0.99 * error_limit(c2.q))
    assert measured.overdrive_q < 0.7 * q
    assert never_worse(measured, side * 0.01 * error_limit(c2.q))
    assert edges(measured, measured)[0] < 0.7 * edges(c2, c2)[0]


def test_overdrive_without_a_measured_resonance_is_off_and_reported(tmp_path):
    path = tmp_path / "mine.toml"
    c2 = Path(load_actuator("c2").source).read_text()
    text = c2.replace("overdrive = 1", "overdrive = 4")
    path.write_text(text)
    with pytest.warns(
        ov.OverviewWarning, match=r"mine.toml: overdrive is off: .* most 0.85, not 10"
    ):
        mine = load_actuator(path)
    assert mine.overdrive_q == mine.q
    path.write_text(text.replace("rise_ms = 33", "rise_ms = 33\ntolerance_percent = 0.5"))
    assert load_actuator(path).overdrive_q == pytest.approx(mine.q / 4.0)
