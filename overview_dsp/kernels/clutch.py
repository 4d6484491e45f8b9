"""The slip clutch on shaft 2: how far the disk may be behind the hand, and how fast it follows.

Against friction B a disk that moves at the speed p (cells a sample) rests on a spring stretched by
B*p / ((k1 + k2)*dt) cells in the middle of a step, and by p/2 more at its start. The clutch limits
that stretch, so the rest position used in the step is x + clamp(hand - x, low, high), with torque
never more than the rigid shaft's nor of another sign: it only dissipates, and the ledger of
`two_disk` holds with that rest position. Four limits:

- speed: the stretch for the wanted speed. Without lag that is the hand's pace; the further the disk
  is behind, the faster, up to a ratio of the pace, and at least as fast as a tap unfolds.
- maximum speed: nothing pulls the disk faster than that. Towards a hand that rests, or has let
  go, it is pulled no faster than friction stops it, so that it does not overshoot.
- windup: the stretch grows from sample to sample by at most a ratio of the hand's pace, so that a
  ridge of friction is not pulled at once by all the way that is behind.
- backlash: the hand moves by that much before it pulls, so that tremor does not. It is applied to
  control events (`control.py`). After a release there is none, so that the disk arrives.

The pace is that of the smoothed input, smoothed once more. A finger that rests keeps the pace it
had, a jump of the input is no pace, and while the clutch slips the pace does not fall: the disk is
still on its way. The wanted speed is that of the sample before, which takes it out of the chain of
operations that each sample waits for.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined

OFF = 1e300  # of a limit that does not hold
SLOWING, LEAD = 3.2, 3.0  # to 0.8 of the speed from which friction alone stops it
MIDDLE = (
    0.5  # samples: a step's forces are those of its middle, and the stretch is that at its start
)
LEAST_SPEED = 1e-9  # cells a sample: of no account, but not 0


@inlined
def with_backlash(played, hand, backlash):
    """The hand's position behind its backlash (cells), of which `played` was the last.

    Towards an end of the surface, beyond which no hand can go, the backlash shrinks to nothing.
    """
    backlash = min(backlash, min(hand, layout.CELLS - hand))
    return min(max(played, hand - backlash), hand + backlash)


@inlined
def allowed_speed(stretch, held_back, pace, ratio, lag_rate, tap_rate, max_speed):
    """The speed (cells a sample) that the disk may be pulled to.

    A rigid shaft would be stretched by `stretch` (cells), of which `held_back` is what friction
    takes at the hand's `pace`.
    """
    way = abs(stretch)
    faster = pace + max(0.0, way - held_back) * lag_rate
    return min(max(min(ratio * pace, faster), way * tap_rate), max_speed)


@inlined
def slowed(wanted, stretch, v, friction, per_inertia):
    """The speed that it may be pulled to where the hand rests, so that it stops there.

    A disk of speed `v` that is not pulled goes on for v inertia / friction: v is led to 0.8 of
    way friction / inertia. `per_inertia` is dt/J.
    """
    stopping = SLOWING * (abs(stretch) * friction * per_inertia) - LEAD * abs(v)
    return min(wanted, max(stopping, LEAST_SPEED))


@inlined
def clutched(stretch, wound, load, growth):
    """The stretch of shaft 2 (cells), where a rigid one would have `stretch`.

    `wound` is that of the sample before, `load` what friction takes at the wanted speed, `growth`
    how much more than `wound` there may be.
    """
    high = min(load, max(wound, 0.0) + growth)
    low = max(-load, min(wound, 0.0) - growth)
    return min(max(stretch, low), high)
