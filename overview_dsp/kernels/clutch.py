"""Slip clutch on shaft 2: limits of the lag of the disk and of its speed.

In friction B, a disk with the speed p (cells per sample) stretches its spring by
B*p / ((k1 + k2)*dt) cells in the middle of a step, and by p/2 more at its start. The clutch limits
this stretch: the rest position used in the step is x + clamp(input - x, low, high). The torque is
never higher than that of a rigid shaft and never of another sign. The clutch only dissipates, and
the energy balance of `two_disk` holds with this rest position. Four limits:

- speed: the stretch for the allowed speed. Without lag this is the pace of the input. It grows with
  the lag up to a ratio of the pace, and is at least the speed of a tap.
- maximum speed: the highest speed of the disk. Towards a resting or released input, the speed is
  limited to what friction can stop, so that the disk does not overshoot.
- windup: the stretch grows per sample by at most a ratio of the input's pace, so that the full lag
  does not act on a ridge of friction at once.
- backlash: play between input and shaft, which removes tremor. It is applied to
  control events (`control_events.py`). After a release there is none, so that the disk arrives.

The pace is the smoothed speed of the smoothed input. A resting input keeps its last pace, jumps of
the input are ignored, and the pace does not fall while the clutch slips, since the disk is
still moving. The allowed speed is that of the previous sample, which removes it from the chain of
dependent operations.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined

OFF = 1e300  # a limit that is switched off
SLOWING, LEAD = 3.2, 3.0  # lead to 0.8 of the speed from which friction alone stops the disk
MIDDLE = (
    0.5  # samples: a step's forces are those of its middle, and the stretch is that at its start
)
LEAST_SPEED = 1e-9  # cells per sample: negligible, but not 0


@inlined
def with_backlash(played, target, backlash):
    """Return the input position after backlash (cells); `played` is the previous one.

    Towards the ends of the surface, the limits of the input, the backlash shrinks to 0.
    """
    backlash = min(backlash, min(target, layout.CELLS - target))
    return min(max(played, target - backlash), target + backlash)


@inlined
def allowed_speed(stretch, held_back, pace, ratio, lag_rate, tap_rate, max_speed):
    """Return the highest speed (cells per sample) to which the clutch accelerates the disk.

    A rigid shaft would be stretched by `stretch` (cells). `held_back` is the part due to
    friction at the input's `pace`.
    """
    way = abs(stretch)
    faster = pace + max(0.0, way - held_back) * lag_rate
    return min(max(min(ratio * pace, faster), way * tap_rate), max_speed)


@inlined
def slowed(allowed, stretch, v, friction, per_inertia):
    """Return the allowed speed towards a resting input, such that the disk stops there.

    Without pull, a disk of speed `v` moves on by v inertia / friction. v is led to 0.8 of
    distance * friction / inertia. `per_inertia` is dt/J.
    """
    stopping = SLOWING * (abs(stretch) * friction * per_inertia) - LEAD * abs(v)
    return min(allowed, max(stopping, LEAST_SPEED))


@inlined
def clutched(stretch, wound, load, growth):
    """Return the stretch of shaft 2 (cells) if that of a rigid shaft is `stretch`.

    `wound` is that of the previous sample, `load` that of friction at the allowed speed, and
    `growth` the highest increase over `wound`.
    """
    high = min(load, max(wound, 0.0) + growth)
    low = max(-load, min(wound, 0.0) - growth)
    return min(max(stretch, low), high)
