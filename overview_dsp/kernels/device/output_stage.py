"""Output stage of live devices: gain, delay and ceiling of each signal, which are not recorded.

Click and tactor have a gain, a delay and a ceiling each, and a common fade at the stream's end:

    y = part * limit(gain * x[n - delay], ceiling) + (1 - part) * gain * x[n - delay]

`part` is 1 if a ceiling below full scale or a gain above 1 needs the limiter, else 0. With
gain 1, delay 0 and part 0 no bit is changed. All four are smoothed or crossfaded for `S_GLIDE`
samples. With an actuator, its drive (`actuator.py`) is computed from the tactor signal after gain
and delay, and before the ceiling. The result on a signal's first
channel is copied to its other channels.

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
    """Start the changes that the control thread has requested since the last block."""
    for i in range(layout.L_GLIDED):
        if f64[layout.L_WANTED + i] != f64[layout.L_TARGET + i]:
            f64[layout.L_TARGET + i] = f64[layout.L_WANTED + i]
            f64[layout.L_FROM + i] = f64[layout.L_GAIN + i]
            i64[layout.L_LEFT + i] = i64[layout.S_GLIDE]
    for signal in range(layout.SIGNALS):
        if i64[layout.L_DELAY_LEFT + signal] == 0:
            requested = i64[layout.L_DELAY_WANTED + signal]
            if requested != i64[layout.L_DELAY + signal]:
                i64[layout.L_DELAY_FROM + signal] = i64[layout.L_DELAY + signal]
                i64[layout.L_DELAY + signal] = requested
                i64[layout.L_DELAY_LEFT + signal] = i64[layout.S_GLIDE]


@inlined
def glided(f64, i64, i, per_glide):
    """Return a smoothed value after one sample, exact at its end."""
    if i64[layout.L_LEFT + i] > 0:
        i64[layout.L_LEFT + i] -= 1
        target = f64[layout.L_TARGET + i]
        left = smooth_step(float(i64[layout.L_LEFT + i]) * per_glide)
        f64[layout.L_GAIN + i] = target + (f64[layout.L_FROM + i] - target) * left
    return f64[layout.L_GAIN + i]


@inlined
def line_mask(f64):
    """Return the used length of a delay line (a power of two) minus 1.

    It is as short as the longest delay allows, so that both lines stay in the processor's cache.
    """
    longest = LONGEST_DELAY_S * f64[layout.S_SAMPLE_RATE] + 1.0
    return (2 << ((bits_of(longest) - ONE_BITS) >> 52)) - 1


@inlined
def delayed(f64, i64, signal, line, at, mask, per_glide):
    """Return the delay line's output at frame `at`, with a crossfade during changes."""
    x = f64[line + ((at - i64[layout.L_DELAY + signal]) & mask)]
    if i64[layout.L_DELAY_LEFT + signal] > 0:
        i64[layout.L_DELAY_LEFT + signal] -= 1
        old = f64[line + ((at - i64[layout.L_DELAY_FROM + signal]) & mask)]
        x = x + (old - x) * smooth_step(float(i64[layout.L_DELAY_LEFT + signal]) * per_glide)
    return x


@inlined
def is_untouched(f64, i64, signal):
    """Return whether a signal is unchanged: gain 1, no delay, no limiter, no actuator."""
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
    """Copy a signal from out[at] on to its delay line."""
    stretch = f64[line : line + frames]
    if channels == layout.SIGNALS:
        signal = out[at :: layout.SIGNALS]  # a constant stride, which is vectorised
        for n in range(frames):
            stretch[n] = float(signal[n])
        return
    for n in range(frames):
        stretch[n] = float(out[at & NOT_NEGATIVE])
        at += channels


@inlined
def pass_through(f64, i64, out, frames, channels, signal, channel):
    """Write an unchanged signal to its delay line and update its peak."""
    line = layout.L_LINES + signal * layout.DELAY_LINE
    mask = line_mask(f64)
    n = 0
    while n < frames:
        # the delay line is circular
        at = (i64[layout.L_LINE] + n) & mask
        stretch = min(frames - n, mask + 1 - at)
        keep(f64, line + at, out, stretch, channels, channel + n * channels)
        n += stretch
    # peak of the last block of `process`, rounded like the output
    peak = float(np.float32(f64[layout.M_PEAK_CLICK + signal]))
    if peak > FULL_SCALE:
        for n in range(frames):
            i = channel + n * channels
            out[i] = min(max(out[i], -FULL_SCALE), FULL_SCALE)
    f64[layout.L_PEAK + signal] = max(f64[layout.L_PEAK + signal], min(peak, FULL_SCALE))


@outlined
def process_signal(f64, i64, out, frames, channels, signal, channel):
    """Apply gain, delay and ceiling to one signal of a block and update its peak."""
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
    """Copy one channel to the channels whose bits are set in `others`."""
    for other in range(channels):
        if (others >> other) & 1 == 1:
            for n in range(frames):
                out[other + n * channels] = out[channel + n * channels]


@inlined
def fade_out(i64, out, frames, channels):
    """Fade out a block at the stream's end; return whether it has become silent."""
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
    """Apply the output stage to a block after `process`; return whether the stream is over."""
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
    """Call `finish` from Python; out is float32 [frames * channels], changed in place."""
    return finish(f64, i64, out, frames, channels)
