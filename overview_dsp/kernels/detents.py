"""Detents, hills and end stops: torque that only depends on where the disk is.

    torque = -dU/dtheta1

The surface holds the pull dU/dtheta1 at its points, joined by lines, and its integral U, so energy
and torque agree exactly. Beyond an end of the surface a spring pushes back. A step takes the mean
pull along its way (a discrete gradient, Gonzalez 1996),

    pull = (U(x1) - U(x0)) / (x1 - x0),

so that what the disk loses the detent has: the ledger of `two_disk` holds with U in it, for any
step. The pull depends on the speed that is sought and the speed on the pull; for detents a disk can
swing in the two agree after two or three rounds, and always by the last.

Units: U in N m cells (times `C_THETA`: J), pull in N m.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import bristle_step
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.friction_lookup import friction_at

SHORT = 0.5  # cells: on a shorter way no difference of energies is taken, which would cancel
ROUNDS = 120
BISECTED = 10  # the round from which halving takes over
CLOSE = 1e-13  # of the pull
CLOSE_ENERGY = 1e-15  # of the energy, whose rounding is as large


@inlined
def clamp(position):
    """A position (cells) kept to the surface."""
    # a NaN fails both comparisons and must not become an index
    if not position > 0.0:
        return 0.0
    return position if position < layout.CELLS else float(layout.CELLS)


@inlined
def pull_at(f64, i64, slot, position):
    """The pull of a surface slot at a position (cells), N m."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    inside = clamp(position)
    if inside != position:
        return (position - inside) * f64[slot + layout.SLOT_END_STIFFNESS] * f64[layout.C_THETA]
    return friction_at(f64, slot + layout.SLOT_PULL, position)


@inlined
def energy_at(f64, i64, slot, inside):
    """The energy of a surface slot's detents at a position on the surface (cells), N m cells."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    i = int(inside)
    part = inside - float(i)
    at = slot + layout.SLOT_PULL + 2 * i
    return f64[slot + layout.SLOT_DETENT_ENERGY + i] + part * (f64[at] + 0.5 * part * f64[at + 1])


@inlined
def mean_pull(f64, i64, slot, x, way):
    """The mean pull of a surface slot (N m) on a way of some cells, other than 0, from x."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    start = clamp(x)
    end = clamp(x + way)
    over = x - start
    over_after = x + way - end
    spring = f64[slot + layout.SLOT_END_STIFFNESS] * f64[layout.C_THETA]
    stop = 0.5 * spring * (over_after + over) * ((over_after - over) / way)
    if abs(end - start) > SHORT:
        risen = energy_at(f64, i64, slot, end) - energy_at(f64, i64, slot, start)
        return risen / way + stop
    # at most one point of the table is passed, where the pull bends
    table = slot + layout.SLOT_PULL
    first = friction_at(f64, table, start)
    last = friction_at(f64, table, end)
    bend = float(max(int(start), int(end)))
    if int(start) == int(end):
        risen = 0.5 * (first + last) * (end - start)
    else:
        there = friction_at(f64, table, bend)
        risen = 0.5 * ((first + there) * (bend - start) + (there + last) * (end - bend))
    return risen / way + stop


@inlined
def crossfade(new, old, old_part):
    """A value of the slot in use with a part of the one faded from."""
    return new + (old - new) * old_part if old_part > 0.0 else new


@inlined
def contact(push, resistance, z, stiffness, damping, steady, break_away):
    """One step without detents, with bristles where they give way at steady > 0 cells."""
    if steady > 0.0:
        return bristle_step(push, resistance, z, stiffness, damping, steady, break_away)
    return push / resistance, 0.0, 0.0


@outlined
def step_in_detents(
    f64, i64, slot, old_slot, old_part, x, ahead, push, resistance,
    z, stiffness, damping, steady, break_away,
):  # fmt: skip
    """One step in the detents of a slot; the arguments are those of `sliding` and `bristle`.

    Returns speed, deflection and torque as `contact`, and the mean pull (N m).
    """
    per_omega = 1.0 / f64[layout.C_OMEGA]
    pull = crossfade(pull_at(f64, i64, slot, ahead), pull_at(f64, i64, old_slot, ahead), old_part)
    middle, bent, torque = 0.0, 0.0, 0.0
    last_pull, last_miss = 0.0, 0.0
    low, high = 0.0, 0.0
    lows, highs = 0, 0
    for n in range(ROUNDS):
        middle, bent, torque = contact(
            push - pull * per_omega, resistance, z, stiffness, damping, steady, break_away
        )
        if middle == 0.0:
            found = crossfade(pull_at(f64, i64, slot, x), pull_at(f64, i64, old_slot, x), old_part)
        else:
            found = crossfade(
                mean_pull(f64, i64, slot, x, middle),
                mean_pull(f64, i64, old_slot, x, middle),
                old_part,
            )
        miss = found - pull
        if abs(miss) <= CLOSE * (abs(found) + abs(pull)):
            break
        if abs(miss * middle) <= CLOSE_ENERGY * abs(energy_at(f64, i64, slot, clamp(x))):
            break
        if miss > 0.0:
            low, lows = pull, 1
        else:
            high, highs = pull, 1
        following = found
        if n > 0 and miss != last_miss:
            following = pull - miss * (pull - last_pull) / (miss - last_miss)
        if lows == 1 and highs == 1:
            inside = (following - low) * (high - following) > 0.0
            if not inside or n > BISECTED:
                following = 0.5 * (low + high)
        elif n > 0 and (following - pull) * miss <= 0.0:
            following = pull + 2.0 * miss
        last_pull, last_miss = pull, miss
        pull = following
    return middle, bent, torque, pull
