"""Bristles under the disk: friction that sticks, breaks away and slides.

The elasto-plastic model (Dupont, Hayward, Armstrong and Altpeter 2002; as sound: Avanzini, Serafin
and Rocchesso 2005): the contact is a bristle deflected by z (rad of disk 1), which is elastic up to
its break-away and gives way beyond it:

    z'     = omega * (1 - A(z)),    A = 0 up to b*zs, then (|z| - b*zs)/(zs - b*zs)
    torque = stiffness * z + damping * z'
    zs     = sliding torque / stiffness * (1 + (static - 1) * exp(-(omega/stribeck)**2))

A is the published alpha * z/zs with a straight line in place of half a sine, so that the step below
has a closed form. In steady sliding z = zs. The viscous part is the surface's own B.

One step is implicit in z and in the speed. In the units of `two_disk` (cells, a sample),

    resistance * vm + k * z1 + d * (z1 - z0) = push,    z1 - z0 = vm * (1 - A(z1)),

is a quadratic in vm, solved without iteration for any stiffness and any dt, and passive: with the
stored energy S = stiffness * z**2/2 and dtheta = vm * dt,

    torque * dtheta = S1 - S0 + stiffness * (z1*A*dtheta + (z1 - z0)**2/2) + damping part,

whose last three terms are losses >= 0. Damping acts only while the deflection grows: bristles that
spring back in sliding would otherwise give energy.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.math_functions import exp

CREEP = 0.02  # rad/s: well below it a torque holds the disk, and isn't felt


@inlined
def moving(omega):
    """How much of a torque that doesn't fade by itself is felt: 0 at rest, 1 in motion."""
    squared = omega * omega
    return squared / (squared + CREEP * CREEP)


@inlined
def steady_torque(sliding, static, stribeck, omega):
    """Torque of steady sliding (N m) at a speed (rad/s): falls from static to sliding torque."""
    ratio = omega / stribeck
    return sliding * (1.0 + (static - 1.0) * exp(-ratio * ratio))


@inlined
def convert_deflection(z, before, stiffness):
    """The deflection of bristles that become stiffer or softer: never with more energy.

    Stiffer ones keep the torque, softer ones the energy.
    """
    ratio = before / stiffness
    return z * ratio if ratio <= 1.0 else z * sqrt(ratio)


@inlined
def bristle_step(push, resistance, z0, stiffness, damping, steady, break_away):
    """The step's midpoint speed vm (cells a sample), the deflection after it, torque / push's unit.

    `push` is the torque of inertia and springs for vm = 0, `resistance` what vm adds to it, both as
    `two_disk` scales them; `stiffness` a cell in that unit; `steady` > 0 is zs in cells.
    """
    free = push - stiffness * z0
    sign = 1.0 if free >= 0.0 else -1.0
    free = abs(free)
    was = sign * z0
    if was > steady:
        damping = 0.0
    firm = stiffness + damping
    speed = free / (resistance + firm)
    z1 = was + speed
    edge = break_away * steady
    if z1 > edge:
        span = steady - edge
        # (resistance/span) vm**2 + b vm - free = 0
        b = resistance + firm - (free + firm * (was - edge)) / span
        root = sqrt(b * b + 4.0 * resistance * free / span)
        speed = 2.0 * free / (b + root) if b >= 0.0 else 0.5 * (root - b) * span / resistance
        z1 = (was + speed * (steady / span)) / (1.0 + speed / span)
    return sign * speed, sign * z1, sign * (stiffness * z1 + damping * (z1 - was))


@inlined
def speed_after(v, middle):
    """The speed after a step (cells a sample): 2 vm - v, as in `two_disk`, unless it overshoots.

    Where bristles stop the disk within a sample the midpoint rule would throw it back; it leaves no
    faster than the step's mean.
    """
    after = 2.0 * middle - v
    if after * middle <= 0.0 and abs(after) > abs(middle):
        return -middle
    return after
