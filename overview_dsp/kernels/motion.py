"""First stage: motion of the disk over the surface, its torque, and passed events.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import store_release
from overview_dsp.kernels.click import log_strike
from overview_dsp.kernels.clutch import MIDDLE, OFF, allowed_speed, clutched, slowed
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.event_crossing import pass_events
from overview_dsp.kernels.friction_lookup import friction_between, is_steep, mean_friction, on_table
from overview_dsp.kernels.nonviscous_step import slide
from overview_dsp.kernels.parameter_smoothing import smooth_step
from overview_dsp.kernels.release import arrive, has_arrived, next_above, next_below
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.viscous import STANDSTILL, advance_disk, flush_to_zero
from overview_dsp.kernels.voice import sound

RAD_PER_CELL = 3.141592653589793 / layout.CELLS
PER_CELL = 1.0 / layout.CELLS
NEAR_REST = layout.CELLS / 1000.0  # cells
STUCK = 1e-4  # rad/s: where friction can hold the disk, this is rest too


@inlined
def slot_of(i64, column):
    """Return the first column of the surface slot with the number in a column."""
    return layout.SURFACES + i64[column] * layout.SLOT_SIZE


@inlined
def faded_from(i64):
    """Return the first column of the slot faded from, or of the active one."""
    return slot_of(i64, layout.FADING_SLOT if i64[layout.FADE_LEFT] > 0 else layout.ACTIVE_SLOT)


@outlined
def step(f64, i64, n, old_slot, modelled):
    """Move the disk by sample n of a chunk on any surface or in a crossfade; write its columns."""
    slot = slot_of(i64, layout.ACTIVE_SLOT)
    x = f64[layout.X]
    v = f64[layout.V]
    was = f64[layout.SMOOTH_2]
    y1, y2 = smooth(
        f64[layout.INPUT], f64[layout.SMOOTH_1], f64[layout.SMOOTH_2], f64[layout.C_SMOOTH]
    )
    f64[layout.SMOOTH_1] = y1
    f64[layout.SMOOTH_2] = y2
    midpoint = x + 0.5 * v
    left = 0.0
    if i64[layout.FADE_LEFT] > 0:
        per_fade = 1.0 / float(i64[layout.S_FADE])
        left = smooth_step(float(i64[layout.FADE_LEFT]) * per_fade)
        i64[layout.FADE_LEFT] -= 1
    table = slot + layout.SLOT_TABLE
    old_table = old_slot + layout.SLOT_TABLE
    friction = friction_between(f64, table, old_table, left, midpoint)
    engaged = i64[layout.ENGAGED] == 1
    hold = 1.0 if engaged else 0.0
    moved = abs(y2 - was)
    pace = f64[layout.PACE]
    max_speed = f64[layout.C_MAX_SPEED]
    moves = f64[layout.C_PACE_LEAST] < moved < f64[layout.C_PACE_MOST]
    if moves and i64[layout.HOLDER] >= 0 and (moved > pace or f64[layout.SLIP] == 0.0):
        pace = pace + f64[layout.C_PACE] * (moved - pace)
    f64[layout.PACE] = pace
    rigid = y2 * hold - x
    reach = f64[layout.C_REACH] if engaged else OFF
    windup = f64[layout.C_WINDUP] if engaged else OFF
    ratio = f64[layout.C_SPEED_RATIO]
    free = friction * reach + MIDDLE
    # any speed but 0 is valid for a rigid shaft
    load = (f64[layout.WANTED] if reach < OFF else 1.0) * free
    held_back = free * pace
    if modelled and reach < OFF:
        # the torque of bristles and detents does not depend on the speed
        most = max(f64[slot + layout.SLOT_HOLD], f64[old_slot + layout.SLOT_HOLD])
        held = most / f64[layout.C_OMEGA] * reach
        load = load + ratio * held
        held_back = held_back + held
    stretch = clutched(rigid, f64[layout.WOUND], load, windup * min(pace, max_speed))
    slip = rigid - stretch
    used = x + stretch if abs(slip) > 0.0 else y2
    f64[layout.WOUND] = stretch
    f64[layout.SLIP] = slip
    lag_rate, tap_rate = f64[layout.C_LAG_RATE], f64[layout.C_TAP_RATE]
    wanted = allowed_speed(rigid, held_back, pace, ratio, lag_rate, tap_rate, max_speed)
    if not moves:
        wanted = slowed(wanted, rigid, v, friction, 1.0 / f64[layout.C_INERTIA])
    f64[layout.WANTED] = wanted if reach < OFF else 0.0
    spring = f64[layout.C_SPRING_HELD] if engaged else f64[layout.C_SPRING_FREE]
    inertia = f64[layout.C_INERTIA]
    denominator = inertia * (2.0 + 0.5 * spring)
    to_omega = f64[layout.C_OMEGA]
    middle = midpoint_speed(v, stretch, spring, inertia, denominator, friction)
    there = on_table(midpoint)
    if is_steep(i64, table, there) or (left > 0.0 and is_steep(i64, old_table, there)):
        friction, middle = mean_friction(
            f64, table, old_table, left, x, v, stretch, spring, inertia, middle
        )
    if modelled:
        push = inertia * (2.0 * v + spring * stretch)
        middle, v, torque, released, event = slide(
            f64, i64, slot, old_slot, left, x, v, push, denominator + friction
        )
        torque = torque + friction * (middle * to_omega)
        if released > 0.0:
            log_strike(f64, i64, event, released, i64[layout.CLOCK] + n, 0.5)
    else:
        torque = friction * (middle * to_omega)
        v = 2.0 * middle - v
    omega = middle * to_omega
    f64[layout.X] = flush_to_zero(x + middle, STANDSTILL)
    f64[layout.V] = flush_to_zero(v, STANDSTILL)
    approach = max(abs(omega), f64[layout.APPROACH] * f64[layout.C_FORGET])
    f64[layout.APPROACH] = flush_to_zero(approach, STANDSTILL)
    f64[layout.PHASE] = advance(f64[layout.PHASE], f64[layout.C_CARRIER])
    i = n % layout.CHUNK  # which tells the compiler that it isn't negative
    f64[layout.D_TORQUE + i] = torque
    f64[layout.D_OMEGA + i] = omega
    f64[layout.D_PHASE + i] = f64[layout.PHASE]
    f64[layout.D_POSITION + i] = f64[layout.X]
    f64[layout.D_SPEED + i] = f64[layout.V]
    f64[layout.D_THETA2 + i] = used
    f64[layout.D_FRICTION + i] = friction


@inlined
def is_at_rest(f64, i64, n, stuck):
    """Return whether the disk is at rest in sample n of a chunk; slower than `stuck` is at rest."""
    rest = f64[layout.INPUT] if i64[layout.ENGAGED] == 1 else 0.0
    near = abs(f64[layout.D_POSITION + n] - rest) < NEAR_REST
    return near or abs(f64[layout.D_OMEGA + n]) < stuck


@inlined
def note_stillness(f64, i64, first, stop, modelled):
    """Count the samples since the disk was last away from its rest position.

    Looks at samples `first` to `stop` of a chunk, in which shaft 2 does not change.
    """
    stuck = STUCK if modelled else 0.0
    last = stop - 1
    while last >= first and is_at_rest(f64, i64, last, stuck):
        last -= 1
    if last >= first:
        i64[layout.M_STILL] = stop - 1 - last
    else:
        i64[layout.M_STILL] += stop - first


@inlined
def sum_torque(f64, i64, frames):
    """Add the chunk's torque to its integral, in order, so that no partition changes a bit."""
    impulse = f64[layout.M_IMPULSE]
    for n in range(frames):
        impulse = impulse + f64[layout.D_TORQUE + n]
    f64[layout.M_IMPULSE] = impulse
    i64[layout.M_SUMMED] += frames


@inlined
def write_trace(f64, i64, frames, trace, at):
    """Write the disk's columns of a chunk to trace rows from index `at` on."""
    touching = 1.0 if i64[layout.HOLDER] >= 0 else 0.0
    for n in range(frames):
        position = f64[layout.D_POSITION + n]
        trace[at] = float(i64[layout.CLOCK] + n + 1) / f64[layout.S_SAMPLE_RATE]
        trace[at + 1] = f64[layout.D_THETA2 + n] * RAD_PER_CELL
        trace[at + 2] = touching
        trace[at + 3] = position * f64[layout.C_THETA]
        trace[at + 4] = f64[layout.D_SPEED + n] * f64[layout.C_OMEGA]
        trace[at + 5] = position * PER_CELL
        trace[at + 6] = f64[layout.D_FRICTION + n]
        trace[at + 7] = f64[layout.D_TORQUE + n]
        trace[at + 9] = f64[layout.D_ENGAGED + n]
        at += layout.TRACE


@inlined
def move(f64, i64, u64, frames, sounding, trace, at, traced):
    """Move the disk by one chunk; write its columns, strikes, and the trace if `traced`.

    `at` is the trace index of the chunk's first frame. Also computes the sound of the previous
    chunk's `sounding` samples.
    """
    old_slot = faded_from(i64)
    models = i64[slot_of(i64, layout.ACTIVE_SLOT) + layout.SLOT_MODELS]
    modelled = models + i64[old_slot + layout.SLOT_MODELS] > 0
    start = f64[layout.X]
    sounded = 0
    n = 0
    while n < frames:
        first = n
        engaged = float(i64[layout.ENGAGED])
        if modelled or i64[layout.FADE_LEFT] > 0:
            step(f64, i64, n, old_slot, modelled)
            n += 1
            x = f64[layout.X]
            passed = x >= next_above(f64, i64) or x < next_below(f64, i64)
        else:
            if sounded < min(n, sounding):  # after steps, or what the last chunk had more
                sound(f64, u64, sounded, min(n, sounding))
            n, passed = advance_disk(f64, i64, u64, n, frames, sounding)
            sounded = min(n, sounding)
        note_stillness(f64, i64, first, n, modelled)
        if traced:
            for i in range(first, n):
                f64[layout.D_ENGAGED + i] = engaged
        if passed:
            pass_events(f64, i64, n - 1, start if n == 1 else f64[layout.D_POSITION + n - 2])
            if has_arrived(f64):
                arrive(f64, i64)
    if sounded < sounding:
        sound(f64, u64, sounded, sounding)
    f64[layout.M_TORQUE] = f64[layout.D_TORQUE + frames - 1]
    f64[layout.M_FRICTION] = f64[layout.D_FRICTION + frames - 1]
    sum_torque(f64, i64, frames)
    if i64[layout.FADING_SLOT] >= 0 and i64[layout.FADE_LEFT] == 0:
        store_release(i64, layout.FADING_SLOT, -1)  # free for writing from here on
    if traced:
        write_trace(f64, i64, frames, trace, at)
