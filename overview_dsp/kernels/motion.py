"""First stage: the hand moves the disk over the surface; its torque, and every event it passes.

This is the chain that can't be shortened: each sample's place decides the next sample's friction.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import log_strike, strike
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.friction import friction_at
from overview_dsp.kernels.glide import smooth_step
from overview_dsp.kernels.sliding import slide
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.two_disk import midpoint_speed

RAD_PER_CELL = 3.141592653589793 / layout.CELLS
PER_CELL = 1.0 / layout.CELLS
FAR = 1e300  # cells: beyond any place
RETREAT = 1e-6  # cells: how far the disk must go back before an event counts as passed again
NEAR_REST = layout.CELLS / 1000.0  # cells
STUCK = 1e-4  # rad/s: where friction can hold the disk, this is rest too
STANDSTILL = 1e-150  # cells, cells a sample, rad/s: smaller would become denormal


@point
def move(m, w, frames, trace, at, traced):
    """Move the disk for one chunk; writes the D_TORQUE, D_OMEGA and D_PHASE columns and strikes.

    `at` is the trace index of the chunk's first frame.
    """
    # the compiler must suppose that columns of `m` alias, so the state is kept in locals
    x = m[layout.X]
    v = m[layout.V]
    y1 = m[layout.SMOOTH_1]
    y2 = m[layout.SMOOTH_2]
    phase = m[layout.PHASE]
    approach = m[layout.APPROACH]
    clock = w[layout.CLOCK]
    still = w[layout.M_STILL]
    fading = w[layout.FADE_LEFT]
    following = w[layout.NEXT_EVENT]

    target = m[layout.INPUT]
    smoothing = m[layout.C_SMOOTH]
    carrier = m[layout.C_CARRIER]
    forget = m[layout.C_FORGET]
    held = w[layout.TOUCHING]
    inertia = m[layout.C_INERTIA]
    spring = m[layout.C_SPRING_HELD] if held == 1 else m[layout.C_SPRING_FREE]
    denominator = inertia * (2.0 + 0.5 * spring)
    to_theta = m[layout.C_THETA]
    to_omega = m[layout.C_OMEGA]
    sample_rate = m[layout.S_SAMPLE_RATE]

    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    table = slot + layout.SLOT_TABLE
    old_slot = slot
    if fading > 0:
        old_slot = layout.SURFACES + w[layout.FADING_SLOT] * layout.SLOT_SIZE
    old_table = old_slot + layout.SLOT_TABLE
    modelled = w[slot + layout.SLOT_MODELS] + w[old_slot + layout.SLOT_MODELS] > 0
    per_fade = 1.0 / float(w[layout.S_FADE])
    places = slot + layout.SLOT_PLACE
    events = w[slot + layout.SLOT_EVENTS]
    above = m[places + following] if following < events else FAR
    below = m[places + following - 1] - RETREAT if following > 0 else -FAR

    friction = 0.0
    impulse = m[layout.M_IMPULSE]
    for n in range(frames):
        y1, y2 = smooth(target, y1, y2, smoothing)
        ahead = x + 0.5 * v
        friction = friction_at(m, table, ahead)
        left = 0.0
        if fading > 0:
            before = friction_at(m, old_table, ahead)
            left = smooth_step(float(fading) * per_fade)
            friction = friction + (before - friction) * left
            fading -= 1
        rest = y2 if held == 1 else 0.0
        was = x
        if modelled:
            push = inertia * (2.0 * v + spring * (rest - x))
            middle, v, torque, released, event = slide(
                m, w, slot, old_slot, left, x, v, push, denominator + friction
            )
            torque = torque + friction * (middle * to_omega)
            x = x + middle
            stands = abs(x - rest) < NEAR_REST or abs(middle * to_omega) < STUCK
            still = still + 1 if stands else 0
            if released > 0.0:
                log_strike(m, w, event, released, clock + n, 0.5)
        else:
            middle = midpoint_speed(x, v, rest, spring, inertia, denominator, friction)
            torque = friction * (middle * to_omega)
            x = x + middle
            still = still + 1 if abs(x - rest) < NEAR_REST else 0
            v = 2.0 * middle - v
        if abs(v) < STANDSTILL:
            v = 0.0
        if abs(x) < STANDSTILL:
            x = 0.0
        omega = middle * to_omega
        approach = max(abs(omega), approach * forget)
        if approach < STANDSTILL:
            approach = 0.0
        phase = advance(phase, carrier)
        impulse = impulse + torque
        m[layout.D_TORQUE + n] = torque
        m[layout.D_OMEGA + n] = omega
        m[layout.D_PHASE + n] = phase

        while x >= above:
            fraction = (above - was) / (x - was)
            strike(m, w, slot, following, approach, abs(omega), clock + n, fraction)
            following += 1
            below = above - RETREAT
            above = m[places + following] if following < events else FAR
        while x < below:
            following -= 1
            above = m[places + following]
            fraction = (was - above) / (was - x) if was > above else 0.0
            strike(m, w, slot, following, approach, abs(omega), clock + n, fraction)
            below = m[places + following - 1] - RETREAT if following > 0 else -FAR

        if traced:
            trace[at] = float(clock + n + 1) / sample_rate
            trace[at + 1] = y2 * RAD_PER_CELL
            trace[at + 2] = float(held)
            trace[at + 3] = x * to_theta
            trace[at + 4] = v * to_omega
            trace[at + 5] = x * PER_CELL
            trace[at + 6] = friction
            trace[at + 7] = torque
            at += layout.TRACE

    m[layout.X] = x
    m[layout.V] = v
    m[layout.SMOOTH_1] = y1
    m[layout.SMOOTH_2] = y2
    m[layout.PHASE] = phase
    m[layout.APPROACH] = approach
    w[layout.M_STILL] = still
    w[layout.FADE_LEFT] = fading
    w[layout.NEXT_EVENT] = following
    m[layout.M_TORQUE] = m[layout.D_TORQUE + frames - 1]
    m[layout.M_FRICTION] = friction
    m[layout.M_IMPULSE] = impulse
    w[layout.M_SUMMED] += frames
