"""Drive of an actuator: perceptual weighting, overdrive, and protection of the actuator.

An actuator is modelled as a mass on a spring (position s in drives, speed v over w0), held from
sample to sample by its exact matrix:

    s'' + w0/Q s' + w0**2 s = w0**2 y

    e = soft_limit(nominal * weight(x))              what is asked for, smoothly below the peak
    t = clip((limit - heat) * knee, 0, 1)      1, or less where the heat nears its limit
    g = sqrt(t smoothed)
    y = clip(forward * g * e - k1 s - k2 v, -g * peak, g * peak)
    y = clip(y, what the heat still allows)
    heat += leak * (y**2 - heat) <= limit

Overdrive is state feedback from the model: with `forward`, k1 and k2 from pole placement the mass
moves like one of a lower Q, at the same level. It equals the inverse filter (a biquad from the
actuator's Q to the lower one), but compensates for drive that the peak has limited. It raises
the drive at rising edges and brakes at falling ones.

Heat is the drive's mean square with an exponential memory of 1/leak samples. From
sum(y**2) = (heat_end - heat_start)/leak + sum(heat) it follows that over any n samples

    mean(y**2) <= limit * (1 + 1/(leak * n)).

Both bounds hold for any input, including NaN and infinity (which count as 0).

Thread: audio (`drive`), main (`drive_block`).
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry_point, inlined
from overview_dsp.kernels.math_functions import tanh_positive

SILENCE = 1e-9  # a position, speed or reduction below it is zero
LARGEST = 1e6  # highest signal, relative to full scale
COLD = 1e-200  # heat below it is zero without a drive


@inlined
def weight_sample(f64, at, x):
    """Return one sample after perceptual weighting (transposed direct form II)."""
    y = f64[at + layout.ACT_W0] * x + f64[at + layout.ACT_W_DELAY_1]
    first = f64[at + layout.ACT_W1] * x - f64[at + layout.ACT_W_BACK_1] * y
    first = first + f64[at + layout.ACT_W_DELAY_2]
    second = f64[at + layout.ACT_W2] * x - f64[at + layout.ACT_W_BACK_2] * y
    silent = x == 0.0 and abs(first) + abs(second) < SILENCE
    f64[at + layout.ACT_W_DELAY_1] = 0.0 if silent else first
    f64[at + layout.ACT_W_DELAY_2] = 0.0 if silent else second
    return y


@inlined
def soft_limit(f64, at, x):
    """Return x, soft-limited to the peak above the nominal drive."""
    over = abs(x) - f64[at + layout.ACT_BEND]
    if over <= 0.0:
        return x
    headroom = f64[at + layout.ACT_ROOM]
    y = f64[at + layout.ACT_BEND] + headroom * tanh_positive(over / headroom)
    return y if x > 0.0 else -y


@inlined
def move_mass(f64, at, y):
    """Advance the modelled mass by one sample of drive y; exactly at rest after it has decayed."""
    position = f64[at + layout.ACT_POSITION]
    speed = f64[at + layout.ACT_SPEED]
    s = f64[at + layout.ACT_A11] * position + f64[at + layout.ACT_A12] * speed
    v = f64[at + layout.ACT_A21] * position + f64[at + layout.ACT_A22] * speed
    s = s + f64[at + layout.ACT_B1] * y
    v = v + f64[at + layout.ACT_B2] * y
    still = abs(y) < SILENCE and abs(s) + abs(v) < SILENCE
    f64[at + layout.ACT_POSITION] = 0.0 if still else s
    f64[at + layout.ACT_SPEED] = 0.0 if still else v


@inlined
def power_reduction(f64, at):
    """Return the smoothed reduction of power, 0 to 1, and store it."""
    headroom = (f64[at + layout.ACT_LIMIT] - f64[at + layout.ACT_HEAT]) * f64[at + layout.ACT_KNEE]
    wanted = 1.0 - min(max(headroom, 0.0), 1.0)
    taken = f64[at + layout.ACT_TAKEN]
    taken = taken + f64[at + layout.ACT_FOLLOW] * (wanted - taken)
    if wanted == 0.0 and taken < SILENCE:
        taken = 0.0
    f64[at + layout.ACT_TAKEN] = taken
    f64[at + layout.ACT_MOST_TAKEN] = max(f64[at + layout.ACT_MOST_TAKEN], taken)
    return taken


@inlined
def drive(f64, i64, at, x):
    """Convert a sample of the signal to the drive; the actuator's columns start at `at`."""
    if x - x != 0.0:  # NaN or infinite
        x = 0.0
    x = min(max(x, -LARGEST), LARGEST)
    gain = sqrt(max(0.0, 1.0 - power_reduction(f64, at)))
    asked = soft_limit(f64, at, f64[at + layout.ACT_NOMINAL] * weight_sample(f64, at, x))
    y = f64[at + layout.ACT_FORWARD] * gain * asked
    y = y - f64[at + layout.ACT_FROM_POSITION] * f64[at + layout.ACT_POSITION]
    y = y - f64[at + layout.ACT_FROM_SPEED] * f64[at + layout.ACT_SPEED]
    if x == 0.0 and abs(y) < SILENCE:
        y = 0.0
    peak = gain * f64[at + layout.ACT_PEAK]
    if abs(y) > peak:
        y = peak if y > 0.0 else -peak
        i64[at + layout.ACT_AT_PEAK] += 1
    leak = f64[at + layout.ACT_LEAK]
    cooled = f64[at + layout.ACT_HEAT] - leak * f64[at + layout.ACT_HEAT]
    allowed = max(0.0, (f64[at + layout.ACT_LIMIT] - cooled) / leak)
    if y * y > allowed:
        y = sqrt(allowed) if y > 0.0 else -sqrt(allowed)
    heat = cooled + leak * (y * y)
    f64[at + layout.ACT_HEAT] = 0.0 if y == 0.0 and heat < COLD else heat
    move_mass(f64, at, y)
    i64[at + layout.ACT_SILENT] = i64[at + layout.ACT_SILENT] + 1 if y == 0.0 else 0
    return y


@entry_point
def drive_block(f64, i64, at, out, frames, channels, channel):
    """Convert one channel of a block in place.

    Parameters
    ----------
    f64, i64 : float64, int64 [at + layout.ACT_SIZE or more]
        Memory, seen two ways.
    at : int64
        First column of the actuator.
    out : float32 [frames * channels]
    frames, channels, channel : int64
    """
    for n in range(frames):
        i = channel + n * channels
        out[i] = drive(f64, i64, at, float(out[i]))
