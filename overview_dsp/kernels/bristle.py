"""Bristle friction: friction that sticks, breaks away and slides.

The elasto-plastic model (Dupont, Hayward, Armstrong and Altpeter 2002; as sound: Avanzini, Serafin
and Rocchesso 2005): the contact is a bristle deflected by z (rad of disk 1), which is elastic up to
its break-away and gives way beyond it:

    z'     = omega * (1 - A(z)),    A = 0 up to b*zs, then (|z| - b*zs)/(zs - b*zs)
    torque = stiffness * z + damping * z'
    zs     = sliding torque / stiffness * (1 + (static - 1) * exp(-(omega/stribeck)**2))

A is the published alpha * z/zs with a linear instead of a sinusoidal transition, so that the step
below has a closed form. In steady sliding z = zs. The surface's B is the viscous part.

One step is implicit in z and in the speed. In the units of `two_disk` (cells, per sample),

    resistance * vm + k * z1 + d * (z1 - z0) = push,    z1 - z0 = vm * (1 - A(z1)),

is a quadratic in vm, solved without iteration for any stiffness and any dt, and passive: with the
stored energy S = stiffness * z**2/2 and dtheta = vm * dt,

    torque * dtheta = S1 - S0 + stiffness * (z1*A*dtheta + (z1 - z0)**2/2) + damping part,

whose last three terms are losses >= 0. Damping acts only while the deflection grows, since bristles
that spring back while sliding would otherwise add energy.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.math_functions import exp

CREEP = 0.02  # rad/s: well below it a torque holds the disk without being perceived


@inlined
def moving(omega):
    """Return the perceived part of a torque that persists at rest: 0 at rest, 1 in motion."""
    squared = omega * omega
    return squared / (squared + CREEP * CREEP)


@inlined
def steady_torque(sliding, static, stribeck, omega):
    """Return the torque of steady sliding (N m) at a speed (rad/s)."""
    ratio = omega / stribeck
    return sliding * (1.0 + (static - 1.0) * exp(-ratio * ratio))


@inlined
def convert_deflection(z, before, stiffness):
    """Return the deflection of bristles after a change of stiffness, without added energy.

    Stiffer bristles keep the torque, softer bristles the energy.
    """
    ratio = before / stiffness
    return z * ratio if ratio <= 1.0 else z * sqrt(ratio)


@inlined
def bristle_step(push, resistance, z0, stiffness, damping, steady, break_away):
    """Return a step's midpoint speed vm (cells per sample), deflection, and torque (unit of push).

    `push` is the torque of inertia and springs for vm = 0 and `resistance` its derivative by vm,
    both scaled as in `two_disk`. `stiffness` is per cell in that unit, `steady` > 0 is zs in cells.
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
    """Return the speed after a step (cells per sample): 2 vm - v, limited to prevent overshoot.

    If bristles stop the disk within a sample, the midpoint rule would reverse it. The speed is then
    limited to the step's mean.
    """
    after = 2.0 * middle - v
    if after * middle <= 0.0 and abs(after) > abs(middle):
        return -middle
    return after
