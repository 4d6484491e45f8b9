"""Where the surface has bristles: their step at the disk's place, what is felt of it, and slips.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import bristle_step, converted, moving, speed_after, steady_torque
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.friction import friction_at

LEAST_GRIP = 1e-12  # N m: from here there are no bristles
SLIP = 0.05  # of the sliding torque: the least that a slip lets go
STANDSTILL = 1e-150  # cells: smaller would become denormal
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
def slip(m, torque, omega, sliding, stribeck):
    """Torque (N m) let go in this sample, 0 if the disk went on as it did.

    Stuck bristles have slipped once the disk is faster than the Stribeck speed.
    """
    peak = m[layout.SLIP_PEAK]
    speed = abs(omega)
    released = 0.0
    if peak >= 0.0:
        peak = max(abs(torque), peak * m[layout.C_FORGET])
        if speed > stribeck:
            if peak - abs(torque) > SLIP * sliding:
                released = peak - abs(torque)
            peak = -1.0
    elif speed < STOPPED * stribeck:
        peak = abs(torque)
    m[layout.SLIP_PEAK] = peak
    return released


@point
def slide(m, w, slot, old_slot, old_part, x, v, push, resistance):
    """One step over a surface with bristles.

    `old_part` of the torque is that of the slot faded from. The other arguments are as in
    `two_disk` and `bristle`.

    Returns the midpoint speed and the speed after it (cells a sample), the torque felt (N m), the
    torque let go by a slip (N m, 0 = none) and the event it belongs to (-1 = the bare surface).
    """
    ahead = x + 0.5 * v
    to_omega = m[layout.C_OMEGA]
    sliding = grip_at(m, w, slot, ahead)
    rows = slot
    if old_part > 0.0:
        sliding = sliding + (grip_at(m, w, old_slot, ahead) - sliding) * old_part
        if w[slot + layout.SLOT_MODELS] & layout.HAS_BRISTLES == 0:
            rows = old_slot
    owner = owner_at(w, rows, ahead)
    bank = layout.MAX_KINDS if owner < 0 else w[rows + layout.SLOT_KIND + owner]
    row = rows + layout.BRISTLES + bank * layout.BRISTLE_PARAMETERS
    stribeck = m[row + layout.P_STRIBECK]
    if sliding > LEAST_GRIP:
        stiffness = m[row + layout.P_STIFFNESS]
        a_cell = stiffness * m[layout.C_THETA]
        z = m[layout.BRISTLE]
        if z != 0.0 and stiffness != m[layout.BRISTLE_STIFFNESS]:
            z = converted(z, m[layout.BRISTLE_STIFFNESS], stiffness)
        static = m[row + layout.P_STATIC]
        steady = steady_torque(sliding, static, stribeck, v * to_omega) / a_cell
        middle, z, torque = bristle_step(
            push,
            resistance,
            z,
            a_cell / to_omega,
            m[row + layout.P_DAMPING],
            steady,
            m[row + layout.P_BREAK_AWAY],
        )
        if abs(z) < STANDSTILL:
            z = 0.0
        torque = torque * to_omega
        after = speed_after(v, middle)
        m[layout.BRISTLE] = z
        m[layout.BRISTLE_STIFFNESS] = stiffness
    else:
        middle = push / resistance
        after = 2.0 * middle - v
        torque = 0.0
        m[layout.BRISTLE] = 0.0
    omega = middle * to_omega
    released = slip(m, torque, omega, sliding, stribeck)
    return middle, after, torque * moving(omega), released, owner if rows == slot else -1
