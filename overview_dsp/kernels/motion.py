"""First stage: the hand moves the disk over the surface; its torque, and every event it passes.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import log_strike
from overview_dsp.kernels.compiling import point, routine
from overview_dsp.kernels.friction import friction_at
from overview_dsp.kernels.glide import smooth_step
from overview_dsp.kernels.passing import event_above, event_below, pass_events
from overview_dsp.kernels.sliding import slide
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.viscous import STANDSTILL, snapped, travel

RAD_PER_CELL = 3.141592653589793 / layout.CELLS
PER_CELL = 1.0 / layout.CELLS
NEAR_REST = layout.CELLS / 1000.0  # cells
STUCK = 1e-4  # rad/s: where friction can hold the disk, this is rest too


@point
def slot_of(w, column):
    """Where the surface slot starts whose number is in a column."""
    return layout.SURFACES + w[column] * layout.SLOT_SIZE


@point
def faded_from(w):
    """Where the slot faded from starts; that of the active one when nothing fades."""
    return slot_of(w, layout.FADING_SLOT if w[layout.FADE_LEFT] > 0 else layout.ACTIVE_SLOT)


@routine
def step(m, w, n, old_slot, modelled):
    """Sample n of a chunk on any surface, or between two; writes the disk's columns."""
    slot = slot_of(w, layout.ACTIVE_SLOT)
    x = m[layout.X]
    v = m[layout.V]
    y1, y2 = smooth(m[layout.INPUT], m[layout.SMOOTH_1], m[layout.SMOOTH_2], m[layout.C_SMOOTH])
    m[layout.SMOOTH_1] = y1
    m[layout.SMOOTH_2] = y2
    ahead = x + 0.5 * v
    friction = friction_at(m, slot + layout.SLOT_TABLE, ahead)
    left = 0.0
    if w[layout.FADE_LEFT] > 0:
        before = friction_at(m, old_slot + layout.SLOT_TABLE, ahead)
        per_fade = 1.0 / float(w[layout.S_FADE])
        left = smooth_step(float(w[layout.FADE_LEFT]) * per_fade)
        friction = friction + (before - friction) * left
        w[layout.FADE_LEFT] -= 1
    held = w[layout.TOUCHING] == 1
    rest = y2 if held else 0.0
    spring = m[layout.C_SPRING_HELD] if held else m[layout.C_SPRING_FREE]
    inertia = m[layout.C_INERTIA]
    denominator = inertia * (2.0 + 0.5 * spring)
    to_omega = m[layout.C_OMEGA]
    if modelled:
        push = inertia * (2.0 * v + spring * (rest - x))
        middle, v, torque, released, event = slide(
            m, w, slot, old_slot, left, x, v, push, denominator + friction
        )
        torque = torque + friction * (middle * to_omega)
        if released > 0.0:
            log_strike(m, w, event, released, w[layout.CLOCK] + n, 0.5)
    else:
        middle = midpoint_speed(x, v, rest, spring, inertia, denominator, friction)
        torque = friction * (middle * to_omega)
        v = 2.0 * middle - v
    omega = middle * to_omega
    m[layout.X] = snapped(x + middle, STANDSTILL)
    m[layout.V] = snapped(v, STANDSTILL)
    approach = max(abs(omega), m[layout.APPROACH] * m[layout.C_FORGET])
    m[layout.APPROACH] = snapped(approach, STANDSTILL)
    m[layout.PHASE] = advance(m[layout.PHASE], m[layout.C_CARRIER])
    i = n % layout.CHUNK  # which tells the compiler that it isn't negative
    m[layout.D_TORQUE + i] = torque
    m[layout.D_OMEGA + i] = omega
    m[layout.D_PHASE + i] = m[layout.PHASE]
    m[layout.D_PLACE + i] = m[layout.X]
    m[layout.D_SPEED + i] = m[layout.V]
    m[layout.D_THETA2 + i] = y2
    m[layout.D_FRICTION + i] = friction


@point
def stands(m, w, n, stuck):
    """Whether the disk is at rest in sample n of a chunk; `stuck` is the speed that is rest too."""
    rest = m[layout.D_THETA2 + n] if w[layout.TOUCHING] == 1 else 0.0
    near = abs(m[layout.D_PLACE + n] - rest) < NEAR_REST
    return near or abs(m[layout.D_OMEGA + n]) < stuck


@point
def note_stillness(m, w, frames, modelled):
    """Count the samples since the disk was last away from where its springs rest."""
    stuck = STUCK if modelled else 0.0
    last = frames - 1
    while last >= 0 and stands(m, w, last, stuck):
        last -= 1
    if last >= 0:
        w[layout.M_STILL] = frames - 1 - last
    else:
        w[layout.M_STILL] += frames


@point
def sum_torque(m, w, frames):
    """Add the chunk's torque to its integral, in order, so that no partition changes a bit."""
    impulse = m[layout.M_IMPULSE]
    for n in range(frames):
        impulse = impulse + m[layout.D_TORQUE + n]
    m[layout.M_IMPULSE] = impulse
    w[layout.M_SUMMED] += frames


@point
def write_trace(m, w, frames, trace, at):
    """The disk's columns of one chunk as trace rows from index `at` on."""
    held = float(w[layout.TOUCHING])
    for n in range(frames):
        place = m[layout.D_PLACE + n]
        trace[at] = float(w[layout.CLOCK] + n + 1) / m[layout.S_SAMPLE_RATE]
        trace[at + 1] = m[layout.D_THETA2 + n] * RAD_PER_CELL
        trace[at + 2] = held
        trace[at + 3] = place * m[layout.C_THETA]
        trace[at + 4] = m[layout.D_SPEED + n] * m[layout.C_OMEGA]
        trace[at + 5] = place * PER_CELL
        trace[at + 6] = m[layout.D_FRICTION + n]
        trace[at + 7] = m[layout.D_TORQUE + n]
        at += layout.TRACE


@point
def move(m, w, frames, trace, at, traced):
    """Move the disk for one chunk; writes its columns, strikes, and the trace if `traced`.

    `at` is the trace index of the chunk's first frame.
    """
    old_slot = faded_from(w)
    models = w[slot_of(w, layout.ACTIVE_SLOT) + layout.SLOT_MODELS]
    modelled = models + w[old_slot + layout.SLOT_MODELS] > 0
    start = m[layout.X]
    n = 0
    while n < frames:
        if modelled or w[layout.FADE_LEFT] > 0:
            step(m, w, n, old_slot, modelled)
            n += 1
        else:
            n = travel(m, w, n, frames)
        x = m[layout.X]
        if x >= event_above(m, w) or x < event_below(m, w):
            pass_events(m, w, n - 1, start if n == 1 else m[layout.D_PLACE + n - 2])
    note_stillness(m, w, frames, modelled)
    m[layout.M_TORQUE] = m[layout.D_TORQUE + frames - 1]
    m[layout.M_FRICTION] = m[layout.D_FRICTION + frames - 1]
    sum_torque(m, w, frames)
    if traced:
        write_trace(m, w, frames, trace, at)
