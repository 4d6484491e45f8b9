"""Detents, hills and end stops: torque that only depends on the position of the disk.

    torque = -dU/dtheta1

The surface stores the pull dU/dtheta1 at its points, linearly interpolated, and its integral U, so
that energy and torque agree exactly. Beyond the ends of the surface a spring pushes back. A step
uses the mean pull over its distance (a discrete gradient, Gonzalez 1996),

    pull = (U(x1) - U(x0)) / (x1 - x0),

so that the detent gains the energy that the disk loses: the energy balance of `two_disk` holds with
U for any step. Pull and speed depend on each other. For detents in which a disk can
oscillate, the iteration converges after two or three rounds, and always by the last.

Units: U in N m cells (times `C_THETA`: J), pull in N m.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.bristle import bristle_step
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.friction_lookup import friction_at

SHORT = 0.5  # cells: for shorter steps a difference of energies would cancel
ROUNDS = 120
BISECTED = 10  # first round of bisection
CLOSE = 1e-13  # tolerance relative to the pull
CLOSE_ENERGY = 1e-15  # tolerance relative to the energy, the size of its rounding


@inlined
def clamp(position):
    """Return a position (cells) clamped to the surface."""
    # a NaN fails both comparisons and must not become an index
    if not position > 0.0:
        return 0.0
    return position if position < layout.CELLS else float(layout.CELLS)


@inlined
def pull_at(f64, i64, slot, position):
    """Return the pull of a surface slot at a position (cells), N m."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    inside = clamp(position)
    if inside != position:
        return (position - inside) * f64[slot + layout.SLOT_END_STIFFNESS] * f64[layout.C_THETA]
    return friction_at(f64, slot + layout.SLOT_PULL, position)


@inlined
def energy_at(f64, i64, slot, inside):
    """Return the energy of a surface slot's detents at a clamped position (cells), N m cells."""
    if i64[slot + layout.SLOT_MODELS] & layout.HAS_DETENTS == 0:
        return 0.0
    i = int(inside)
    part = inside - float(i)
    at = slot + layout.SLOT_PULL + 2 * i
    return f64[slot + layout.SLOT_DETENT_ENERGY + i] + part * (f64[at] + 0.5 * part * f64[at + 1])


@inlined
def mean_pull(f64, i64, slot, x, way):
    """Return the mean pull of a surface slot (N m) over a distance `way` != 0 (cells) from x."""
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
    # at most one point of the table, where the slope changes, is passed
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
    """Return a crossfade from the value of the old slot to that of the new one."""
    return new + (old - new) * old_part if old_part > 0.0 else new


@inlined
def contact(push, resistance, z, stiffness, damping, steady, break_away):
    """Compute a step without detents, with bristles if `steady` > 0 cells."""
    if steady > 0.0:
        return bristle_step(push, resistance, z, stiffness, damping, steady, break_away)
    return push / resistance, 0.0, 0.0


@outlined
def step_in_detents(
    f64, i64, slot, old_slot, old_part, x, midpoint, push, resistance,
    z, stiffness, damping, steady, break_away,
):  # fmt: skip
    """Compute a step in the detents of a slot; arguments are those of `slide` and `bristle_step`.

    Returns speed, deflection and torque like `contact`, and the mean pull (N m).
    """
    per_omega = 1.0 / f64[layout.C_OMEGA]
    pull = crossfade(
        pull_at(f64, i64, slot, midpoint), pull_at(f64, i64, old_slot, midpoint), old_part
    )
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
