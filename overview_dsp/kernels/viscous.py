"""Motion of the disk with viscous friction only, from one passed event to the next.

This loop is a chain of dependent operations: the position of each sample decides the friction of
the next. It therefore keeps half the speed, which is exact and saves two
multiplications, and has no test for numbers near zero within the chain. The remaining capacity of a
processor computes the sound of the previous chunk, which is independent.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.clutch import MIDDLE, OFF, allowed_speed, clutched, slowed
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.friction_lookup import friction_on, is_steep, mean_friction, on_table
from overview_dsp.kernels.release import next_above, next_below
from overview_dsp.kernels.simd.vector import choose
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.voice import (
    keep_sound_state,
    sound_coefficients,
    sound_once,
    sound_state,
)

STANDSTILL = 1e-150  # cells, cells per sample, rad/s: smaller would become denormal


@inlined
def flush_to_zero(x, least):
    """Return x, or exactly 0 if its magnitude is below `least`."""
    return choose(abs(x) < least, 0.0, x)


@outlined
def advance_disk(f64, i64, u64, start, frames, sounding):
    """Move the disk from sample `start` of a chunk on.

    It stops after the first sample in which it passes an event or arrives after a release. Returns
    the next sample or the chunk's end, and whether it stopped. Writes the disk's columns. Together
    with each sample it computes the sound of the same one of the previous chunk, of `sounding`
    samples.
    """
    sound_before = sound_state(f64, u64)
    coefficients = sound_coefficients(f64)
    x = f64[layout.X]
    half = 0.5 * f64[layout.V]
    y1 = f64[layout.SMOOTH_1]
    y2 = f64[layout.SMOOTH_2]
    phase = f64[layout.PHASE]
    approach = f64[layout.APPROACH]

    target = f64[layout.INPUT]
    smoothing = f64[layout.C_SMOOTH]
    carrier = f64[layout.C_CARRIER]
    forget = f64[layout.C_FORGET]
    inertia = f64[layout.C_INERTIA]
    to_omega = f64[layout.C_OMEGA]
    engaged = i64[layout.ENGAGED] == 1
    hold = 1.0 if engaged else 0.0
    pace = f64[layout.PACE]
    pacing = f64[layout.C_PACE] if i64[layout.HOLDER] >= 0 else 0.0
    per_inertia = 1.0 / inertia
    least = f64[layout.C_PACE_LEAST]
    most = f64[layout.C_PACE_MOST]
    reach = f64[layout.C_REACH]
    slips = engaged and reach < OFF  # else shaft 2 is rigid, or disengaged
    wound = f64[layout.WOUND]
    slip = f64[layout.SLIP] if slips else 0.0
    wanted = f64[layout.WANTED] if slips else 0.0
    windup = f64[layout.C_WINDUP]
    ratio = f64[layout.C_SPEED_RATIO]
    lag_rate = f64[layout.C_LAG_RATE]
    tap_rate = f64[layout.C_TAP_RATE]
    max_speed = f64[layout.C_MAX_SPEED]
    growth = windup * min(pace, max_speed)
    spring = f64[layout.C_SPRING_HELD] if engaged else f64[layout.C_SPRING_FREE]
    denominator = inertia * (2.0 + 0.5 * spring)
    table = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE + layout.SLOT_TABLE
    above = next_above(f64, i64)
    below = next_below(f64, i64)

    n = start
    while n < frames:
        if n < sounding:
            sound_before = sound_once(f64, n % layout.CHUNK, sound_before, coefficients)
        was = y2
        y1, y2 = smooth(target, y1, y2, smoothing)
        midpoint = on_table(x + half)
        friction = friction_on(f64, table, midpoint)
        moved = abs(y2 - was)
        moves = least < moved < most
        if moves and (moved > pace or slip == 0.0):
            pace = pace + pacing * (moved - pace)
            growth = windup * min(pace, max_speed)
        stretch = y2 * hold - x
        used = y2
        if slips:
            rigid = stretch
            free = friction * reach + MIDDLE
            stretch = clutched(rigid, wound, wanted * free, growth)
            slip = rigid - stretch
            if abs(slip) > 0.0:
                used = x + stretch
            wanted = allowed_speed(rigid, free * pace, pace, ratio, lag_rate, tap_rate, max_speed)
            if not moves:
                wanted = slowed(wanted, rigid, 2.0 * half, friction, per_inertia)
        wound = stretch
        middle = midpoint_speed(2.0 * half, stretch, spring, inertia, denominator, friction)
        if is_steep(i64, table, midpoint):
            friction, middle = mean_friction(
                f64, table, table, 0.0, x, 2.0 * half, stretch, spring, inertia, middle
            )
        x = x + middle
        half = middle - half
        omega = middle * to_omega
        approach = max(abs(omega), approach * forget)
        if min(abs(x), abs(half)) < STANDSTILL:
            x = flush_to_zero(x, STANDSTILL)
            half = flush_to_zero(half, 0.5 * STANDSTILL)
            approach = flush_to_zero(approach, STANDSTILL)
        phase = advance(phase, carrier)
        i = n % layout.CHUNK  # which tells the compiler that it isn't negative
        f64[layout.D_TORQUE + i] = friction * omega
        f64[layout.D_OMEGA + i] = omega
        f64[layout.D_PHASE + i] = phase
        f64[layout.D_POSITION + i] = x
        f64[layout.D_SPEED + i] = 2.0 * half
        f64[layout.D_THETA2 + i] = used
        f64[layout.D_FRICTION + i] = friction
        n += 1
        if x >= above or x < below:
            break

    f64[layout.X] = x
    f64[layout.V] = 2.0 * half
    f64[layout.SMOOTH_1] = y1
    f64[layout.SMOOTH_2] = y2
    f64[layout.PHASE] = phase
    f64[layout.APPROACH] = approach
    f64[layout.PACE] = pace
    f64[layout.WOUND] = wound
    f64[layout.SLIP] = slip
    f64[layout.WANTED] = wanted
    keep_sound_state(f64, u64, sound_before)
    return n, x >= above or x < below
