"""The disk over viscous friction alone, from one passed event to the next.

This is the chain that can't be shortened: each sample's place decides the next sample's friction.
So nothing else is in this loop, and its state is at hand: half the speed, which is exact and saves
the chain two multiplications, and no test for numbers near zero that the next sample waits for.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import point, routine
from overview_dsp.kernels.friction import friction_at
from overview_dsp.kernels.lanes import choose
from overview_dsp.kernels.passing import event_above, event_below
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.two_disk import midpoint_speed

STANDSTILL = 1e-150  # cells, cells a sample, rad/s: smaller would become denormal


@point
def snapped(x, least):
    """x, or exactly 0 if it is nearer to it than `least`."""
    return choose(abs(x) < least, 0.0, x)


@routine
def travel(m, w, start, frames):
    """Move the disk from sample `start` of a chunk on; the sample after which it stopped.

    That is the first in which an event is passed, or the chunk's end. Writes the disk's columns.
    """
    x = m[layout.X]
    half = 0.5 * m[layout.V]
    y1 = m[layout.SMOOTH_1]
    y2 = m[layout.SMOOTH_2]
    phase = m[layout.PHASE]
    approach = m[layout.APPROACH]

    target = m[layout.INPUT]
    smoothing = m[layout.C_SMOOTH]
    carrier = m[layout.C_CARRIER]
    forget = m[layout.C_FORGET]
    inertia = m[layout.C_INERTIA]
    to_omega = m[layout.C_OMEGA]
    held = w[layout.TOUCHING] == 1
    hold = 1.0 if held else 0.0
    spring = m[layout.C_SPRING_HELD] if held else m[layout.C_SPRING_FREE]
    denominator = inertia * (2.0 + 0.5 * spring)
    table = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE + layout.SLOT_TABLE
    above = event_above(m, w)
    below = event_below(m, w)

    n = start
    while n < frames:
        y1, y2 = smooth(target, y1, y2, smoothing)
        rest = y2 * hold
        friction = friction_at(m, table, x + half)
        middle = midpoint_speed(x, 2.0 * half, rest, spring, inertia, denominator, friction)
        x = x + middle
        half = middle - half
        omega = middle * to_omega
        approach = max(abs(omega), approach * forget)
        if min(abs(x), abs(half)) < STANDSTILL:
            x = snapped(x, STANDSTILL)
            half = snapped(half, 0.5 * STANDSTILL)
            approach = snapped(approach, STANDSTILL)
        phase = advance(phase, carrier)
        i = n % layout.CHUNK  # which tells the compiler that it isn't negative
        m[layout.D_TORQUE + i] = friction * omega
        m[layout.D_OMEGA + i] = omega
        m[layout.D_PHASE + i] = phase
        m[layout.D_PLACE + i] = x
        m[layout.D_SPEED + i] = 2.0 * half
        m[layout.D_THETA2 + i] = y2
        m[layout.D_FRICTION + i] = friction
        n += 1
        if x >= above or x < below:
            break

    m[layout.X] = x
    m[layout.V] = 2.0 * half
    m[layout.SMOOTH_1] = y1
    m[layout.SMOOTH_2] = y2
    m[layout.PHASE] = phase
    m[layout.APPROACH] = approach
    return n
