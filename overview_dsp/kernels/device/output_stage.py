"""Last of all, live only: what the device does to each signal after what is recorded and replayed.

For click and tactor each a gain, a delay and a ceiling, and for both the fade that ends a stream:

    y = part * limit(gain * x[n - delay], ceiling) + (1 - part) * gain * x[n - delay]

`part` is 1 where a ceiling below full scale or a gain above 1 asks for the limiter, else 0: with
gain 1, delay 0 and part 0 not a bit is changed. All four glide or crossfade for `S_GLIDE` samples.
Where an actuator is chosen, its drive (`actuator.py`) is made from the tactor's gained and delayed
signal; the ceiling comes last and can only take away. What has become of a signal on its first
channel is copied to its others.

Thread: audio.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import NOT_NEGATIVE, entry_point, inlined, outlined
from overview_dsp.kernels.device.actuator import drive
from overview_dsp.kernels.limiter import limit
from overview_dsp.kernels.math_functions import ONE_BITS
from overview_dsp.kernels.parameter_smoothing import smooth_step
from overview_dsp.kernels.simd.vector import bits_of

FULL_SCALE = 1.0
LONGEST_DELAY_S = 0.1


@inlined
def read_requests(f64, i64):
    """Begin the glides that the control thread has asked for since the last block."""
    for i in range(layout.L_GLIDED):
        if f64[layout.L_WANTED + i] != f64[layout.L_TARGET + i]:
            f64[layout.L_TARGET + i] = f64[layout.L_WANTED + i]
            f64[layout.L_FROM + i] = f64[layout.L_GAIN + i]
            i64[layout.L_LEFT + i] = i64[layout.S_GLIDE]
    for signal in range(layout.SIGNALS):
        if i64[layout.L_DELAY_LEFT + signal] == 0:
            wanted = i64[layout.L_DELAY_WANTED + signal]
            if wanted != i64[layout.L_DELAY + signal]:
                i64[layout.L_DELAY_FROM + signal] = i64[layout.L_DELAY + signal]
                i64[layout.L_DELAY + signal] = wanted
                i64[layout.L_DELAY_LEFT + signal] = i64[layout.S_GLIDE]


@inlined
def glided(f64, i64, i, per_glide):
    """One sample of a gliding value, exact at its end."""
    if i64[layout.L_LEFT + i] > 0:
        i64[layout.L_LEFT + i] -= 1
        target = f64[layout.L_TARGET + i]
        left = smooth_step(float(i64[layout.L_LEFT + i]) * per_glide)
        f64[layout.L_GAIN + i] = target + (f64[layout.L_FROM + i] - target) * left
    return f64[layout.L_GAIN + i]


@inlined
def line_mask(f64):
    """One less than the frames of a delay line that are in use, a power of two.

    As few as the longest delay needs, so that both lines stay in a processor's cache.
    """
    longest = LONGEST_DELAY_S * f64[layout.S_SAMPLE_RATE] + 1.0
    return (2 << ((bits_of(longest) - ONE_BITS) >> 52)) - 1


@inlined
def delayed(f64, i64, signal, line, at, mask, per_glide):
    """The delay line's output at frame `at`, crossfaded while the delay changes."""
    x = f64[line + ((at - i64[layout.L_DELAY + signal]) & mask)]
    if i64[layout.L_DELAY_LEFT + signal] > 0:
        i64[layout.L_DELAY_LEFT + signal] -= 1
        old = f64[line + ((at - i64[layout.L_DELAY_FROM + signal]) & mask)]
        x = x + (old - x) * smooth_step(float(i64[layout.L_DELAY_LEFT + signal]) * per_glide)
    return x


@inlined
def is_untouched(f64, i64, signal):
    """Whether nothing is done to a signal now: gain 1, no delay, no limiter, no actuator."""
    gliding = i64[layout.L_DELAY_LEFT + signal]
    for i in range(signal, layout.L_GLIDED, layout.SIGNALS):
        gliding += i64[layout.L_LEFT + i]
    driven = signal == layout.TACTOR and i64[layout.L_ACTUATOR + layout.ACT_ON] == 1
    return (
        gliding == 0
        and not driven
        and i64[layout.L_DELAY + signal] == 0
        and f64[layout.L_GAIN + signal] == 1.0
        and not f64[layout.L_LIMITED + signal] > 0.0
    )


@inlined
def keep(f64, line, out, frames, channels, at):
    """Copy one signal, from out[at] on, into a stretch of its delay line."""
    stretch = f64[line : line + frames]
    if channels == layout.SIGNALS:
        signal = out[at :: layout.SIGNALS]  # so far apart in any case: several at a time
        for n in range(frames):
            stretch[n] = float(signal[n])
        return
    for n in range(frames):
        stretch[n] = float(out[at & NOT_NEGATIVE])
        at += channels


@inlined
def pass_through(f64, i64, out, frames, channels, signal, channel):
    """A signal to which nothing is done: into the delay line; its peak is booked."""
    line = layout.L_LINES + signal * layout.DELAY_LINE
    mask = line_mask(f64)
    n = 0
    while n < frames:
        # as a delay line in a circle has it: up to its end, then from its start on
        at = (i64[layout.L_LINE] + n) & mask
        stretch = min(frames - n, mask + 1 - at)
        keep(f64, line + at, out, stretch, channels, channel + n * channels)
        n += stretch
    # that of the block that `process` has just made, as the output has it
    peak = float(np.float32(f64[layout.M_PEAK_CLICK + signal]))
    if peak > FULL_SCALE:
        for n in range(frames):
            i = channel + n * channels
            out[i] = min(max(out[i], -FULL_SCALE), FULL_SCALE)
    f64[layout.L_PEAK + signal] = max(f64[layout.L_PEAK + signal], min(peak, FULL_SCALE))


@outlined
def process_signal(f64, i64, out, frames, channels, signal, channel):
    """One signal of a block through its gain, delay and ceiling; its peak is booked."""
    if is_untouched(f64, i64, signal):
        pass_through(f64, i64, out, frames, channels, signal, channel)
        return
    per_glide = 1.0 / float(i64[layout.S_GLIDE])
    line = layout.L_LINES + signal * layout.DELAY_LINE
    mask = line_mask(f64)
    written = i64[layout.L_LINE]
    peak = f64[layout.L_PEAK + signal]
    driven = signal == layout.TACTOR and i64[layout.L_ACTUATOR + layout.ACT_ON] == 1
    for n in range(frames):
        at = written + n
        f64[line + (at & mask)] = float(out[channel + n * channels])
        gain = glided(f64, i64, signal, per_glide)
        ceiling = glided(f64, i64, layout.SIGNALS + signal, per_glide)
        part = glided(f64, i64, 2 * layout.SIGNALS + signal, per_glide)
        y = gain * delayed(f64, i64, signal, line, at, mask, per_glide)
        if driven:
            y = drive(f64, i64, layout.L_ACTUATOR, y)
        if part > 0.0:
            y = y + part * (limit(y, ceiling) - y)
        y = min(max(y, -FULL_SCALE), FULL_SCALE)
        peak = max(peak, abs(y))
        out[channel + n * channels] = y
    f64[layout.L_PEAK + signal] = peak


@outlined
def copy_to(out, frames, channels, channel, others):
    """One channel's samples, bit for bit, to those whose bits are set in `others`."""
    for other in range(channels):
        if (others >> other) & 1 == 1:
            for n in range(frames):
                out[other + n * channels] = out[channel + n * channels]


@inlined
def fade_out(i64, out, frames, channels):
    """Fade a block towards the stream's end; whether silence is reached."""
    length = i64[layout.S_GLIDE]
    for n in range(frames):
        left = max(0, length - 1 - i64[layout.L_FADED])
        gain = smooth_step(float(left) / float(length))
        for channel in range(channels):
            out[n * channels + channel] = out[n * channels + channel] * gain
        i64[layout.L_FADED] += 1
    return i64[layout.L_FADED] >= length


@inlined
def finish(f64, i64, out, frames, channels):
    """What a device's block still needs after `process`; whether the stream is over."""
    read_requests(f64, i64)
    if i64[layout.S_CLICK_CHANNEL] >= 0:
        process_signal(f64, i64, out, frames, channels, 0, i64[layout.S_CLICK_CHANNEL])
        if i64[layout.L_ALSO_CLICK] != 0:
            click = i64[layout.S_CLICK_CHANNEL]
            copy_to(out, frames, channels, click, i64[layout.L_ALSO_CLICK])
    if i64[layout.S_TACTOR_CHANNEL] >= 0:
        process_signal(f64, i64, out, frames, channels, 1, i64[layout.S_TACTOR_CHANNEL])
        if i64[layout.L_ALSO_TACTOR] != 0:
            tactor = i64[layout.S_TACTOR_CHANNEL]
            copy_to(out, frames, channels, tactor, i64[layout.L_ALSO_TACTOR])
    i64[layout.L_LINE] += frames
    if i64[layout.L_STOP] == 1:
        return fade_out(i64, out, frames, channels)
    return False


@entry_point
def finish_block(f64, i64, out, frames, channels):
    """`finish` for callers in Python: out is float32 [frames * channels], treated in place."""
    return finish(f64, i64, out, frames, channels)
