"""The disk: analytic truths, the energy ledger, order of convergence, a second opinion."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import math_functions
from overview_dsp.kernels.layout import CELLS, TRACE
from overview_dsp.kernels.two_disk import midpoint_speed
from tests.examples import INERTIA, K1, K2, plain_preset, timeline_of, with_friction

step = math_functions.plain(midpoint_speed)


def ledger(trace, preset):
    """Residual of the contract's energy identity, each step, of (E0 + E1 + |work terms|)."""
    inertia, k1, k2 = (preset.number(f"disk.{name}") for name in ("inertia", "k1", "k2"))
    held = trace.engaged
    k = k1 + held * k2
    theta0 = np.concatenate([[0.0], trace.theta1[:-1]])
    omega0 = np.concatenate([[0.0], trace.omega1[:-1]])
    dt = trace.time[0]
    # the energy a step begins with is booked with that step's own springs: letting go or taking
    # hold between two steps changes it by k2 theta1**2 / 2
    before = inertia * omega0**2 / 2 + k * theta0**2 / 2
    after = inertia * trace.omega1**2 / 2 + k * trace.theta1**2 / 2
    mean = (omega0 + trace.omega1) / 2
    lost = dt * trace.friction * mean**2
    given_ = dt * held * k2 * trace.theta2 * mean
    scale = before + after + lost + np.abs(given_)
    return (after - before + lost - given_) / np.where(scale > 0.0, scale, 1.0)


def played(preset, events, seconds, sample_rate=48_000.0, surface=None):
    """Trace of control events (time_s, theta2, touching) on a base surface."""
    engine = ov.Engine(preset, timeline_of())
    frames = round(seconds * sample_rate)
    engine.prepare(sample_rate, frames)
    if surface is not None:
        engine.set_surface(surface(engine.surface))
        engine.reset()
    for time, theta2, touching in events:
        engine.control(theta2, touching, round(time * sample_rate))
    out = np.zeros((frames, 2), dtype=np.float32)
    table = np.zeros((frames, TRACE))
    engine.process(out, table)
    from overview_dsp.offline.rendering.trace import Trace

    return Trace(table)


@given(
    frictions=st.lists(st.floats(0.0, 10.0), min_size=2, max_size=30),
    dt=st.floats(1e-7, 1.0),
    inertia=st.floats(1e-6, 1e-2),
    k1=st.floats(1e-5, 1.0),
    k2=st.floats(1e-5, 10.0),
    hands=st.lists(st.tuples(st.booleans(), st.floats(0.0, math.pi)), min_size=2, max_size=30),
)
def test_every_step_keeps_the_energy_ledger_for_any_friction_and_any_step(
    frictions, dt, inertia, k1, k2, hands
):
    theta, omega = 0.0, 0.0
    scale = k2 / (k1 + k2)  # theta1 = scale * position
    for b, (touching, theta2) in zip(frictions, hands, strict=False):
        k = k1 + touching * k2
        spring = k / inertia * dt * dt
        position, speed = theta / scale, omega / scale * dt
        middle = step(
            speed,
            (theta2 if touching else 0.0) - position,
            spring,
            inertia / dt,
            inertia / dt * (2.0 + 0.5 * spring),
            b,
        )
        theta_after = (position + middle) * scale
        omega_after = (2.0 * middle - speed) * scale / dt
        mean = middle * scale / dt
        before = inertia * omega**2 / 2 + k * theta**2 / 2
        after = inertia * omega_after**2 / 2 + k * theta_after**2 / 2
        lost, given_ = dt * b * mean**2, dt * touching * k2 * theta2 * mean
        size = before + after + lost + abs(given_)
        # energies below 1e-300 J have no digits left
        assert abs(after - before + lost - given_) <= 1e-12 * size + 1e-300
        if not touching:
            assert after <= before * (1.0 + 1e-12)
        theta, omega = theta_after, omega_after


def test_a_whole_gesture_keeps_the_ledger_touched_released_and_touched_again(match, football):
    gesture = ov.sweep(1.0) + ov.pause(0.4) + ov.tap(0.7, 0.5) + ov.pause(0.2) + ov.tap(0.2, 0.3)
    trace = ov.render(match, football, gesture, tail=1.0).trace
    assert len(np.unique(trace.engaged)) == 2
    assert np.abs(ledger(trace, football)).max() <= 1e-12


@pytest.mark.parametrize(("touching", "k"), [(True, K1 + K2), (False, K1)])
def test_natural_frequency_is_that_of_the_spring_and_the_disk(touching, k):
    preset = plain_preset(surface__friction=1e-6)
    events = [(0.0, math.pi, True)] + ([] if touching else [(0.2, math.pi, False)])
    trace = played(preset, events, 14.0)
    start = 0 if touching else int(np.argmin(trace.engaged))
    swing = trace.theta1[start:] - (K2 * math.pi / (K1 + K2) if touching else 0.0)
    time = trace.time[start:]
    ups = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossings = time[ups] - swing[ups] * np.diff(time)[ups] / (swing[ups + 1] - swing[ups])
    frequency = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    assert frequency == pytest.approx(math.sqrt(k / INERTIA) / (2 * math.pi), rel=1e-3)


def test_a_finger_held_still_settles_exactly_on_the_place_it_points_at():
    trace = played(plain_preset(), [(0.0, 1.0, True)], 6.0)
    assert trace.theta1[-1] == pytest.approx(K2 / (K1 + K2), rel=1e-3)
    assert trace.cursor[-1] == pytest.approx(1.0 / math.pi, rel=1e-9)


def test_recoil_falls_with_the_time_constant_of_friction_and_shaft_1():
    b = 1e-2  # far overdamped: B/k1 = 5 s, and the fast pole dies in J/B = 10 ms
    trace = played(plain_preset(surface__friction=b), [(0.0, 2.0, True), (8.0, 2.0, False)], 14.0)
    first, second = np.searchsorted(trace.time, [9.0, 13.0])
    tau = 4.0 / math.log(trace.theta1[first] / trace.theta1[second])
    slow = 2 * INERTIA / (b - math.sqrt(b * b - 4 * K1 * INERTIA))
    assert tau == pytest.approx(slow, rel=1e-3)
    assert tau == pytest.approx(b / K1, rel=3e-3)


def test_a_free_disk_spins_down_with_inertia_over_friction():
    # a spring too weak to matter: v falls by exp(-B/J t)
    preset = plain_preset(disk__k1=1e-5, disk__k2=10.0, surface__friction=1e-3)
    trace = played(preset, [(0.0, math.pi / 2, True), (0.004, math.pi / 2, False)], 0.4)
    freed = trace.time[np.argmin(trace.engaged)]
    start, stop = np.searchsorted(trace.time, [freed + 0.002, freed + 0.202])
    fall = math.log(abs(trace.omega1[start] / trace.omega1[stop]))
    assert fall == pytest.approx(0.2 * 1e-3 / INERTIA, rel=0.05)


def smooth_friction(surface):
    position = np.arange(CELLS + 1) / CELLS
    return with_friction(surface, 1e-3 * (1.5 + np.sin(3.0 * np.pi * position)))


def smooth_path(sample_rate, seconds=0.6):
    """The disk's angle when the kernel's own step follows an analytic friction and input."""
    dt = 1.0 / sample_rate
    spring = (K1 + K2) / INERTIA * dt * dt
    scale = INERTIA / dt
    x = v = 0.0
    for n in range(round(seconds * sample_rate)):
        hand = 1.5 * (1.0 - math.cos(2.0 * math.pi * (n + 0.5) * dt))
        b = 1e-3 * (1.5 + math.sin(3.0 * (x + 0.5 * v)))
        middle = step(v, hand - x, spring, scale, scale * (2.0 + 0.5 * spring), b)
        x, v = x + middle, 2.0 * middle - v
    return x


def test_the_step_is_of_second_order():
    reference = smooth_path(64_000)
    coarse, fine = (abs(smooth_path(rate) - reference) for rate in (1_000, 2_000))
    # the reference's own error is 1/1024 of the finer one's
    assert math.log2(coarse / fine) >= 1.9


@numba.njit
def accelerated(t, theta, omega, k, pull, inertia, hand, table, position):
    """The paper's equation 2 in continuous time, with the kernel's own table and smoothed input."""
    dt, released, cells_per_rad = position
    at = t / dt - 0.5
    i = min(max(int(at), 0), released - 2)
    theta2 = hand[i] + (at - i) * (hand[i + 1] - hand[i])
    x = min(max(theta * cells_per_rad, 0.0), float(CELLS))
    j = min(int(x), CELLS - 1)
    b = table[j] + (x - j) * (table[j + 1] - table[j])
    return (-k * theta - b * omega + pull * theta2) / inertia


@numba.njit
def solved(start, stop, parts, theta, omega, k, pull, inertia, hand, table, position):
    """The disk's angle at the end of samples `start` to `stop`: fourth order, `parts` steps each.

    Returns the angles, float64 [stop - start], and the last speed.
    """
    dt = position[0]
    h = dt / parts
    out = np.empty(stop - start)
    for n in range(start, stop):
        for part in range(parts):
            t = n * dt + part * h
            given = (k, pull, inertia, hand, table, position)
            a1 = accelerated(t, theta, omega, *given)
            v2 = omega + 0.5 * h * a1
            a2 = accelerated(t + 0.5 * h, theta + 0.5 * h * omega, v2, *given)
            v3 = omega + 0.5 * h * a2
            a3 = accelerated(t + 0.5 * h, theta + 0.5 * h * v2, v3, *given)
            v4 = omega + h * a3
            a4 = accelerated(t + h, theta + h * v3, v4, *given)
            theta += h / 6.0 * (omega + 2.0 * v2 + 2.0 * v3 + v4)
            omega += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        out[n - start] = theta
    return out, omega


@pytest.fixture
def played_match(request, match):
    """The bundled match, or one of the real ones: the densest has 46 events."""
    if request.param == "bundled":
        return match
    folder = request.getfixturevalue("data_folder") / "football" / "statsbomb"
    return ov.load_timeline(folder / f"{request.param}.json")


@pytest.mark.parametrize(
    ("name", "gesture", "seconds"),
    [
        ("fast sweep and recoil", ov.sweep(1.0), 2.3),
        ("slow sweep", ov.sweep(1.2, 0.0, 0.4), 1.3),
        ("tap and recoil", ov.tap(0.9, 0.5), 1.2),
    ],
)
@pytest.mark.parametrize("played_match", ["bundled", "15986", "22936", "69321"], indirect=True)
def test_the_disk_agrees_with_a_high_order_solver(played_match, football, name, gesture, seconds):
    result = ov.render(played_match, football, gesture, tail=max(0.0, seconds - gesture.duration_s))
    trace, preset, table = result.trace, football, result.engine.surface.friction
    inertia, k1, k2 = (preset.number(f"disk.{part}") for part in ("inertia", "k1", "k2"))
    dt = 1.0 / result.sample_rate
    released = int(np.flatnonzero(trace.engaged > 0.5)[-1]) + 1
    cells_per_rad = (k1 + k2) / k2 * CELLS / math.pi

    def solution(parts):
        given_ = (inertia, trace.theta2, table, (dt, released, cells_per_rad))
        held, omega = solved(0, released, parts, 0.0, 0.0, k1 + k2, k2, *given_)
        free, _ = solved(released, len(trace.time), parts, held[-1], omega, k1, 0.0, *given_)
        return np.concatenate([held, free])

    fine = solution(96)
    assert np.abs(fine - solution(48)).max() <= 1e-6  # the solver's own error is below
    assert np.abs(fine - trace.theta1).max() <= 3e-5, name
