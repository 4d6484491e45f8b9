"""Steps of the disk with bristles, detents and end stops, their perceived torque and strikes.

The torque of bristles and detents is output while the disk moves and fades at rest, where they hold
the disk imperceptibly. The paper's viscous friction vanishes at rest by itself.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import convert_deflection, moving, speed_after, steady_torque
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.detents import clamp, contact, crossfade, step_in_detents
from overview_dsp.kernels.friction_lookup import friction_at

LEAST_SLIDING_TORQUE = 1e-12  # N m: below it there are no bristles
SLIP = 0.05  # least release of a slip, relative to the sliding torque
STANDSTILL = 1e-150  # cells: smaller would become denormal
GIVES = 0.5  # part of the disk's movement that its bristles don't follow
STOPPED = 0.5  # of the Stribeck speed: below it the disk sticks again


@inlined
def sliding_torque_at(f64, i64, slot, position):
    """Return the sliding torque of a surface slot's bristles at a position (cells), N m."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_BRISTLES == 0:
        return 0.0
    return friction_at(f64, slot + layout.SLOT_SLIDING_TORQUE, position)


@inlined
def owner_at(i64, slot, position):
    """Return the event that owns the bristles at a position (cells), -1 = the base surface."""
    # a NaN fails both comparisons and must not become an index
    if not position > 0.0:
        position = 0.0
    if position > layout.CELLS:
        position = float(layout.CELLS)
    return i64[slot + layout.SLOT_OWNER + int(position)]


@inlined
def end_damping(f64, i64, slot):
    """Return the friction beyond the ends of a surface slot, N m s/rad."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    return f64[slot + layout.SLOT_END_DAMPING]


@inlined
def end_stop_torque(f64, i64, slot, before, after, omega):
    """Return the torque (N m) of an impact on an end stop in this sample, or 0.

    It is the torque of the stop's spring after it has absorbed all speed: omega sqrt(stiffness J).
    """
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    if clamp(after) == after or clamp(before) != before:
        return 0.0
    inertia = f64[layout.C_INERTIA] / f64[layout.S_SAMPLE_RATE]
    return abs(omega) * sqrt(f64[slot + layout.SLOT_END_STIFFNESS] * inertia)


@inlined
def slip(f64, torque, omega, gives, sliding, stribeck):
    """Return the torque (N m) released by a slip in this sample, or 0.

    Stuck bristles slip when the disk is faster than the Stribeck speed and they do not follow more
    than half of its movement (`gives`); otherwise the disk only oscillates in them.
    """
    peak = f64[layout.SLIP_PEAK]
    speed = abs(omega)
    released = 0.0
    if peak >= 0.0:
        peak = max(abs(torque), peak * f64[layout.C_FORGET])
        if speed > stribeck and gives > GIVES:
            if peak - abs(torque) > SLIP * sliding:
                released = peak - abs(torque)
            peak = -1.0
    elif speed < STOPPED * stribeck:
        peak = abs(torque)
    f64[layout.SLIP_PEAK] = peak
    return released


@outlined
def slide(f64, i64, slot, old_slot, old_part, x, v, push, resistance):
    """Compute a step over a surface with bristles, detents or end stops.

    `old_part` of the torque is that of the slot faded from. The other arguments are as in
    `two_disk` and `bristle`.

    Returns the midpoint speed and the speed after the step (cells per sample), the output torque (N
    m), the torque of a slip or an impact on an end stop (N m, 0 = none) and its event (-1 =
    the base surface).
    """
    midpoint = x + 0.5 * v
    to_omega = f64[layout.C_OMEGA]
    sliding = sliding_torque_at(f64, i64, slot, midpoint)
    rows = slot
    if old_part > 0.0:
        sliding = sliding + (sliding_torque_at(f64, i64, old_slot, midpoint) - sliding) * old_part
        if i64[slot + layout.SLOT_MODELS] & layout.HAS_BRISTLES == 0:
            rows = old_slot
    z = 0.0
    before = 0.0
    steady = 0.0
    per_cell = 0.0
    event = -1
    row = rows + layout.BRISTLES
    if sliding > LEAST_SLIDING_TORQUE:
        owner = owner_at(i64, rows, midpoint)
        event = owner if rows == slot else -1
        bank = layout.MAX_KINDS if owner < 0 else i64[rows + layout.SLOT_KIND + owner]
        row = row + bank * layout.BRISTLE_PARAMETERS
        stiffness = f64[row + layout.P_STIFFNESS]
        per_cell = stiffness * f64[layout.C_THETA]
        z = f64[layout.BRISTLE]
        if z != 0.0 and stiffness != f64[layout.BRISTLE_STIFFNESS]:
            z = convert_deflection(z, f64[layout.BRISTLE_STIFFNESS], stiffness)
        f64[layout.BRISTLE_STIFFNESS] = stiffness
        before = z
        static = f64[row + layout.P_STATIC]
        torque = steady_torque(sliding, static, f64[row + layout.P_STRIBECK], v * to_omega)
        steady = torque / per_cell
    stop = 0.0
    if clamp(midpoint) != midpoint:
        stop = crossfade(end_damping(f64, i64, slot), end_damping(f64, i64, old_slot), old_part)
    stiffness = per_cell / to_omega
    damping = f64[row + layout.P_DAMPING]
    break_away = f64[row + layout.P_BREAK_AWAY]
    pull = 0.0
    if (
        i64[slot + layout.SLOT_MODELS] | i64[old_slot + layout.SLOT_MODELS]
    ) & layout.HAS_DETENTS == 0:
        middle, z, torque = contact(push, resistance, z, stiffness, damping, steady, break_away)
    else:
        middle, z, torque, pull = step_in_detents(
            f64, i64, slot, old_slot, old_part, x, midpoint, push, resistance + stop,
            z, stiffness, damping, steady, break_away,
        )  # fmt: skip
    after = 2.0 * middle - v
    if steady > 0.0:
        after = speed_after(v, middle)
    f64[layout.BRISTLE] = z if abs(z) > STANDSTILL else 0.0
    omega = middle * to_omega
    torque = torque * to_omega
    released = 0.0
    if steady > 0.0:
        gives = 1.0 - (z - before) / middle if middle != 0.0 else 0.0
        released = slip(f64, torque, omega, gives, sliding, f64[row + layout.P_STRIBECK])
    else:
        f64[layout.SLIP_PEAK] = -1.0
    impact = end_stop_torque(f64, i64, slot, x, x + middle, omega)
    if impact > released:
        released = impact
        event = -1
    felt = (torque + pull) * moving(omega) + stop * omega
    return middle, after, felt, released, event
