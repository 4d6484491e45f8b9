"""What a preset's numbers mean to the kernel: each coefficient against its definition."""

from __future__ import annotations

import cmath
import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import clutch, layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.derive import PACE_MOST, derive, derive_clicks, push_parameters
from overview_dsp.signal.engine.coefficients import changes, check_carrier, coefficients
from tests.examples import K1, K2, plain_preset
from tests.kernels.deriving import mode_coefficients, one_pole, ring_samples

RATES = [1000.0, 44_100.0, 48_000.0, 192_000.0]
VALUES = {
    "disk.inertia": 2e-5,
    "disk.k1": 3e-3,
    "disk.k2": 2e-2,
    "clutch.max_speed_ratio": 1.2,
    "clutch.tap_duration_s": 1.5,
    "clutch.time_constant_s": 0.06,
    "clutch.windup_ratio": 2.5,
    "clutch.max_speed": 0.9,
    "clutch.backlash_percent": 0.3,
    "tactor.slow_gain_exponent": 0.5,
    "tactor.recoil_gain_exponent": 0.6,
    "input.smoothing_ms": 5.0,
    "tactor.reference_torque_mnm": 40.0,
    "tactor.compression": 0.6,
    "tactor.threshold_db": -50.0,
    "tactor.rise_ms": 2.0,
    "tactor.decay_ms": 12.0,
    "tactor.frequency_hz": 180.0,
    "tactor.gain_db": -6.0,
    "click.reference_torque_mnm": 25.0,
    "click.compression": 0.4,
    "click.gain_db": 3.0,
    "texture.gain_db": -40.0,
    "texture.brightness_hz": 800.0,
    "output.ceiling_db": -2.0,
}


def db(level):
    return 10.0 ** (level / 20.0)


@pytest.mark.parametrize("rate", RATES)
def test_every_coefficient_is_what_its_parameter_says(rate):
    given = plain_preset().with_changes(VALUES)
    found = coefficients(given, rate)
    ratio = 2e-2 / (3e-3 + 2e-2)  # of the springs: how far disk 1 follows the hand
    expected = {
        layout.C_SPRING_HELD: (math.sqrt(2.3e-2 / 2e-5) / rate) ** 2,  # natural frequencies
        layout.C_SPRING_FREE: (math.sqrt(3e-3 / 2e-5) / rate) ** 2,
        layout.C_INERTIA: 2e-5 * rate,
        layout.C_THETA: math.pi * ratio / layout.CELLS,
        layout.C_OMEGA: math.pi * ratio / layout.CELLS * rate,
        layout.C_TORQUE: 1.0 / 40e-3,
        layout.C_GATE: db(-50.0),
        layout.C_EXPONENT: 0.6,
        layout.C_CARRIER: 180.0 / rate,
        layout.C_TACTOR_GAIN: db(-6.0),
        layout.C_CLICK_GAIN: db(3.0),
        layout.C_STRIKE_TORQUE: 1.0 / 25e-3,
        layout.C_STRIKE_EXPONENT: 0.4,
        # at 1 mW, of white noise with variance 1/3 in a band of half of 48 kHz
        layout.C_TEXTURE_GAIN: db(-40.0) * math.sqrt(3.0 / 1e-3 * rate / 48e3),
        layout.C_TEXTURE_CUTOFF: 2.0 * math.pi * 800.0 / rate,
        layout.C_CEILING: db(-2.0),
        layout.C_SPEED_RATIO: 1.2,
        layout.C_REACH: 1.0 / (2.3e-2 / rate),
        layout.C_LAG_RATE: 1.0 / (0.06 * rate),
        layout.C_WINDUP: 2.5,
        layout.C_MAX_SPEED: 0.9 * layout.CELLS / rate,
        layout.C_BACKLASH: 0.003 * layout.CELLS,
        layout.C_SLOW_EXPONENT: 0.5,
        layout.C_RECOIL_EXPONENT: 0.6,
        layout.C_TAP_RATE: 1.0 / (1.5 * rate),
        layout.C_PACE_LEAST: 0.02 * layout.CELLS / rate,
        layout.C_PACE_MOST: 6.0 * layout.CELLS / rate,
    }
    falls = {  # what is left after a time constant is 1/e
        layout.C_SMOOTH: (1.0 - found[layout.C_SMOOTH], 5e-3),
        layout.C_RISE: (1.0 - found[layout.C_RISE], 2e-3),
        layout.C_DECAY: (1.0 - found[layout.C_DECAY], 12e-3),
        layout.C_PACE: (1.0 - found[layout.C_PACE], 80e-3),
        layout.C_TEXTURE_LEVEL: (1.0 - found[layout.C_TEXTURE_LEVEL], 50e-3),
        layout.C_FORGET: (found[layout.C_FORGET], 200e-3),
        layout.C_DC_POLE: (found[layout.C_DC_POLE], 1.0 / (2.0 * math.pi * 20.0)),
    }
    assert found.keys() == expected.keys() | falls.keys()
    for column, value in expected.items():
        assert found[column] == pytest.approx(value, rel=1e-12), column
    for column, (left, time_s) in falls.items():
        assert left ** (time_s * rate) == pytest.approx(math.exp(-1.0), rel=1e-9), column


@pytest.mark.parametrize("rate", RATES)
def test_each_limit_of_the_clutch_is_off_at_0_and_all_are_with_a_rigid_shaft(rate):
    rigid = coefficients(plain_preset(clutch__windup_ratio=2.0, clutch__backlash_percent=1.0), rate)
    assert rigid[layout.C_REACH] == rigid[layout.C_WINDUP] == clutch.OFF
    assert rigid[layout.C_BACKLASH] == 0.0
    bare = coefficients(plain_preset(clutch__max_speed_ratio=0.25), rate)
    assert bare[layout.C_REACH] == pytest.approx(rate / (K1 + K2))
    assert bare[layout.C_TAP_RATE] == pytest.approx(PACE_MOST / rate)
    for column in (layout.C_LAG_RATE, layout.C_WINDUP, layout.C_MAX_SPEED):
        assert bare[column] == clutch.OFF


@pytest.mark.parametrize("signal", ["tactor", "click"])
def test_mute_is_no_gain_at_any_level(signal):
    column = layout.C_TACTOR_GAIN if signal == "tactor" else layout.C_CLICK_GAIN
    muted = plain_preset().with_changes({f"{signal}.mute": True, f"{signal}.gain_db": 12.0})
    assert coefficients(muted, 48_000.0)[column] == 0.0


@pytest.mark.parametrize("tau", [1e-4, 1e-2, 1.0])
def test_a_one_pole_rises_by_1_minus_1_over_e_in_its_time_constant(tau):
    a = one_pole(tau, 48_000.0)
    assert (1.0 - a) ** (tau * 48_000.0) == pytest.approx(math.exp(-1.0), rel=1e-9)


def test_only_what_differs_is_reported():
    base = plain_preset()
    assert changes(base, base, 48_000.0) == []
    quiet = base.with_changes({"tactor.gain_db": -20.0})
    assert changes(base, quiet, 48_000.0) == [(layout.C_TACTOR_GAIN, pytest.approx(0.1))]
    back = base.with_changes({"disk.release": "return"})
    assert changes(base, back, 48_000.0) == [(layout.COMMAND_RELEASE_RETURNS, 1.0)]
    assert changes(back, base, 48_000.0) == [(layout.COMMAND_RELEASE_RETURNS, 0.0)]
    assert changes(back, back, 48_000.0) == []


def test_a_carrier_stays_below_0_45_of_the_rate():
    rate = 1000.0
    check_carrier(plain_preset(tactor__frequency_hz=449.0), rate)
    with pytest.raises(ov.InputError, match=r"450, too high for 1000 Hz.*below 450 Hz"):
        check_carrier(plain_preset(tactor__frequency_hz=450.0), rate)


def test_a_mode_falls_by_160_db_while_it_rings_and_by_60_in_its_decay():
    mode, rate = ov.ClickMode(1000.0, 60.0, -6.0), 48_000.0
    assert ring_samples(mode, rate) == 7680  # 160/60 of 60 ms
    columns = mode_coefficients(mode, rate)
    assert math.exp(columns[layout.MODE_DECAY] * 0.060 * rate) == pytest.approx(1e-3)
    assert columns[layout.MODE_TURNS] == 1000.0 / rate
    assert columns[layout.MODE_GAIN] == pytest.approx(db(-6.0))
    # turned on by n samples, each twice over, and by all of them at once
    turn = cmath.exp(complex(-math.log(1000.0) / (0.060 * rate), 2.0 * math.pi * 1000.0 / rate))
    for n in range(2 * layout.PHASES):
        found = complex(columns[layout.MODE_RE + n], columns[layout.MODE_IM + n])
        assert found == pytest.approx(turn ** (n % layout.PHASES), rel=1e-12)
    whole = complex(columns[layout.MODE_COS], columns[layout.MODE_SIN])
    assert whole == pytest.approx(turn**layout.PHASES, rel=1e-12)


@given(st.floats(-150.0, 60.0))
def test_a_level_in_db_is_a_correctly_rounded_power_of_ten(level):
    with localcontext(prec=50):
        assert gain_of_db(level) == float(Decimal(10) ** Decimal(level / 20.0))


def test_every_parameter_of_the_voice_has_a_column():
    elsewhere = {
        id
        for id, known in PARAMETERS.items()
        if known.surface or id.startswith(("twist.", "follow."))
    }
    of_the_voice = {
        f"PARAM_{id.upper().replace('.', '_')}" for id in PARAMETERS if id not in elsewhere
    }
    assert of_the_voice == {name for name in vars(layout) if name.startswith("PARAM_")}


@pytest.mark.parametrize("name", ["football", "creaking-door", "clock-key"])
@pytest.mark.parametrize("rate", [1000.0, 44_100.0, 1234.5678, 96_000.0, 768_000.0])
def test_a_memory_goes_to_another_rate_by_itself(match, name, rate):
    """Of one that was prepared at 48 kHz the kernel makes the very one of another rate."""
    engines = [ov.Engine(ov.load_preset(name), match, seed=2) for _ in range(2)]
    engines[0].prepare(48_000)
    engines[1].prepare(rate)
    moved, made = (engine.memory for engine in engines)
    moved[layout.S_SAMPLE_RATE] = rate
    derive(moved, moved.view(np.int64))
    derive_clicks(moved, moved.view(np.int64), layout.SURFACES)
    heard = made.view(np.int64)[layout.SURFACES + layout.KIND_MODES :][: layout.BANKS]
    for m in (moved, made):  # modes that no kind has any more
        modes = m[layout.SURFACES + layout.MODES :][
            : layout.BANKS * layout.MAX_MODES * layout.MODE_SIZE
        ]
        modes = modes.reshape(layout.BANKS, layout.MAX_MODES, layout.MODE_SIZE)
        modes[np.arange(layout.MAX_MODES) >= heard[:, None]] = 0.0
    assert np.array_equal(moved.view(np.int64), made.view(np.int64))


def test_parameters_changed_in_the_memory_are_those_changed_by_the_engine(match, football):
    wanted = football.with_changes({"tactor.gain_db": -9.0, "disk.release": "return"})
    outs = []
    for by_engine in (True, False):
        engine = ov.Engine(football, match)
        engine.prepare(8000, 4000)
        engine.control(2.0, True)
        engine.control(2.0, False, 2000)
        if by_engine:
            engine.set_preset(wanted, sample_time=1001)
        else:
            engine.memory[layout.PARAM_TACTOR_GAIN_DB] = -9.0
            engine.memory[layout.PARAM_DISK_RELEASE] = 1.0
            assert push_parameters(engine.memory, engine.memory.view(np.int64), 1001)
            assert push_parameters(engine.memory, engine.memory.view(np.int64), 1500)  # nothing new
        out = np.zeros((4000, 2), np.float32)
        engine.process(out)
        outs.append(out)
    assert np.array_equal(*outs)
    assert outs[0].any()


def test_parameters_that_find_no_place_are_asked_for_later(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(8000, 4000)
    w = engine.memory.view(np.int64)
    w[layout.HOST_WRITTEN] = w[layout.HOST_READ] + layout.HOST_RING
    engine.memory[layout.PARAM_TACTOR_GAIN_DB] = -9.0
    assert not push_parameters(engine.memory, w, -1)
    w[layout.HOST_WRITTEN] = w[layout.HOST_READ]
    assert push_parameters(engine.memory, w, -1)
    assert w[layout.HOST_WRITTEN] == w[layout.HOST_READ] + 1
