"""Where the surface has bristles, wells or end stops: the disk's step, what is felt of it, strikes.

Felt is the torque of the bristles and wells while the disk moves; it fades at rest, where they hold
the disk without a feel, as the paper's friction does by itself.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import converted, moving, speed_after, steady_torque
from overview_dsp.kernels.compiling import point, routine
from overview_dsp.kernels.friction import friction_at
from overview_dsp.kernels.wells import contact, mixed, step_in_wells, within

LEAST_GRIP = 1e-12  # N m: from here there are no bristles
SLIP = 0.05  # of the sliding torque: the least that a slip lets go
STANDSTILL = 1e-150  # cells: smaller would become denormal
GIVES = 0.5  # part of the disk's way that its bristles don't follow
STOPPED = 0.5  # of the Stribeck speed: below it the disk sticks again


@point
def grip_at(m, w, slot, place):
    """Sliding torque of a surface slot's bristles at a place (cells), N m."""
    if w[slot + layout.SLOT_MODELS] & layout.HAS_BRISTLES == 0:
        return 0.0
    return friction_at(m, slot + layout.SLOT_GRIP, place)


@point
def owner_at(w, slot, place):
    """The event whose bristles are at a place (cells), -1 = the bare surface's."""
    # a NaN fails both comparisons and must not become an index
    if not place > 0.0:
        place = 0.0
    if place > layout.CELLS:
        place = float(layout.CELLS)
    return w[slot + layout.SLOT_OWNER + int(place)]


@point
def end_damping(m, w, slot):
    """Friction beyond the ends of a surface slot, N m s/rad."""
    if w[slot + layout.SLOT_MODELS] & layout.HAS_WELLS == 0:
        return 0.0
    return m[slot + layout.SLOT_END_DAMPING]


@point
def knock(m, w, slot, before, after, omega):
    """Torque (N m) with which the disk meets an end stop in this sample, 0 if it doesn't.

    It is what the stop's spring holds against when it has taken all speed: omega sqrt(stiffness J).
    """
    if w[slot + layout.SLOT_MODELS] & layout.HAS_WELLS == 0:
        return 0.0
    if within(after) == after or within(before) != before:
        return 0.0
    inertia = m[layout.C_INERTIA] / m[layout.S_SAMPLE_RATE]
    return abs(omega) * sqrt(m[slot + layout.SLOT_END_STIFFNESS] * inertia)


@point
def slip(m, torque, omega, gives, sliding, stribeck):
    """Torque (N m) let go in this sample, 0 if the disk went on as it did.

    Stuck bristles have slipped once the disk is faster than the Stribeck speed and they give way:
    by more than half of its way, `gives` (or it only swings in them).
    """
    peak = m[layout.SLIP_PEAK]
    speed = abs(omega)
    released = 0.0
    if peak >= 0.0:
        peak = max(abs(torque), peak * m[layout.C_FORGET])
        if speed > stribeck and gives > GIVES:
            if peak - abs(torque) > SLIP * sliding:
                released = peak - abs(torque)
            peak = -1.0
    elif speed < STOPPED * stribeck:
        peak = abs(torque)
    m[layout.SLIP_PEAK] = peak
    return released


@routine
def slide(m, w, slot, old_slot, old_part, x, v, push, resistance):
    """One step over a surface with bristles, wells or end stops.

    `old_part` of the torque is that of the slot faded from. The other arguments are as in
    `two_disk` and `bristle`.

    Returns the midpoint speed and the speed after it (cells a sample), the torque felt (N m), the
    torque let go by a slip or met at an end stop (N m, 0 = none) and the event it belongs to (-1 =
    the bare surface).
    """
    ahead = x + 0.5 * v
    to_omega = m[layout.C_OMEGA]
    sliding = grip_at(m, w, slot, ahead)
    rows = slot
    if old_part > 0.0:
        sliding = sliding + (grip_at(m, w, old_slot, ahead) - sliding) * old_part
        if w[slot + layout.SLOT_MODELS] & layout.HAS_BRISTLES == 0:
            rows = old_slot
    z = 0.0
    before = 0.0
    steady = 0.0
    per_cell = 0.0
    event = -1
    row = rows + layout.BRISTLES
    if sliding > LEAST_GRIP:
        owner = owner_at(w, rows, ahead)
        event = owner if rows == slot else -1
        bank = layout.MAX_KINDS if owner < 0 else w[rows + layout.SLOT_KIND + owner]
        row = row + bank * layout.BRISTLE_PARAMETERS
        stiffness = m[row + layout.P_STIFFNESS]
        per_cell = stiffness * m[layout.C_THETA]
        z = m[layout.BRISTLE]
        if z != 0.0 and stiffness != m[layout.BRISTLE_STIFFNESS]:
            z = converted(z, m[layout.BRISTLE_STIFFNESS], stiffness)
        m[layout.BRISTLE_STIFFNESS] = stiffness
        before = z
        static = m[row + layout.P_STATIC]
        torque = steady_torque(sliding, static, m[row + layout.P_STRIBECK], v * to_omega)
        steady = torque / per_cell
    stop = 0.0
    if within(ahead) != ahead:
        stop = mixed(end_damping(m, w, slot), end_damping(m, w, old_slot), old_part)
    stiffness = per_cell / to_omega
    damping = m[row + layout.P_DAMPING]
    break_away = m[row + layout.P_BREAK_AWAY]
    pull = 0.0
    if (w[slot + layout.SLOT_MODELS] | w[old_slot + layout.SLOT_MODELS]) & layout.HAS_WELLS == 0:
        middle, z, torque = contact(push, resistance, z, stiffness, damping, steady, break_away)
    else:
        middle, z, torque, pull = step_in_wells(
            m, w, slot, old_slot, old_part, x, ahead, push, resistance + stop,
            z, stiffness, damping, steady, break_away,
        )  # fmt: skip
    after = 2.0 * middle - v
    if steady > 0.0:
        after = speed_after(v, middle)
    m[layout.BRISTLE] = z if abs(z) > STANDSTILL else 0.0
    omega = middle * to_omega
    torque = torque * to_omega
    released = 0.0
    if steady > 0.0:
        gives = 1.0 - (z - before) / middle if middle != 0.0 else 0.0
        released = slip(m, torque, omega, gives, sliding, m[row + layout.P_STRIBECK])
    else:
        m[layout.SLIP_PEAK] = -1.0
    met = knock(m, w, slot, x, x + middle, omega)
    if met > released:
        released = met
        event = -1
    felt = (torque + pull) * moving(omega) + stop * omega
    return middle, after, felt, released, event
