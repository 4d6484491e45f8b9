"""Last of all, live only: what the device does to each signal after what is recorded and replayed.

For click and tactor each a gain, a delay and a ceiling, and for both the fade that ends a stream:

    y = part * limit(gain * x[n - delay], ceiling) + (1 - part) * gain * x[n - delay]

`part` is 1 where a ceiling below full scale or a gain above 1 asks for the limiter, else 0: with
gain 1, delay 0 and part 0 not a bit is changed. All four glide or crossfade for `S_GLIDE` samples.
Where an actuator is chosen, its drive (`actuator.py`) is made from the tactor's gained and delayed
signal; the ceiling comes last and can only take away.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.actuator import drive
from overview_dsp.kernels.compiling import NOT_NEGATIVE, entry, point, routine
from overview_dsp.kernels.glide import smooth_step
from overview_dsp.kernels.limiter import limit

FULL_SCALE = 1.0
TACTOR = 1  # of the signals, the one that an actuator gets


@point
def take_wishes(m, w):
    """Begin the glides that the control thread has asked for since the last block."""
    for i in range(layout.L_GLIDED):
        if m[layout.L_WANTED + i] != m[layout.L_TARGET + i]:
            m[layout.L_TARGET + i] = m[layout.L_WANTED + i]
            m[layout.L_FROM + i] = m[layout.L_GAIN + i]
            w[layout.L_LEFT + i] = w[layout.S_GLIDE]
    for signal in range(layout.SIGNALS):
        if w[layout.L_DELAY_LEFT + signal] == 0:
            wanted = w[layout.L_DELAY_WANTED + signal]
            if wanted != w[layout.L_DELAY + signal]:
                w[layout.L_DELAY_FROM + signal] = w[layout.L_DELAY + signal]
                w[layout.L_DELAY + signal] = wanted
                w[layout.L_DELAY_LEFT + signal] = w[layout.S_GLIDE]


@point
def glided(m, w, i, per_glide):
    """One sample of a gliding value, exact at its end."""
    if w[layout.L_LEFT + i] > 0:
        w[layout.L_LEFT + i] -= 1
        target = m[layout.L_TARGET + i]
        left = smooth_step(float(w[layout.L_LEFT + i]) * per_glide)
        m[layout.L_GAIN + i] = target + (m[layout.L_FROM + i] - target) * left
    return m[layout.L_GAIN + i]


@point
def delayed(m, w, signal, line, at, per_glide):
    """The delay line's output at frame `at`, crossfaded while the delay changes."""
    mask = layout.DELAY_LINE - 1
    x = m[line + ((at - w[layout.L_DELAY + signal]) & mask)]
    if w[layout.L_DELAY_LEFT + signal] > 0:
        w[layout.L_DELAY_LEFT + signal] -= 1
        old = m[line + ((at - w[layout.L_DELAY_FROM + signal]) & mask)]
        x = x + (old - x) * smooth_step(float(w[layout.L_DELAY_LEFT + signal]) * per_glide)
    return x


@point
def is_untouched(m, w, signal):
    """Whether nothing is done to a signal now: gain 1, no delay, no limiter, no actuator."""
    gliding = w[layout.L_DELAY_LEFT + signal]
    for i in range(signal, layout.L_GLIDED, layout.SIGNALS):
        gliding += w[layout.L_LEFT + i]
    driven = signal == TACTOR and w[layout.L_ACTUATOR + layout.ACT_ON] == 1
    return (
        gliding == 0
        and not driven
        and w[layout.L_DELAY + signal] == 0
        and m[layout.L_GAIN + signal] == 1.0
        and not m[layout.L_LIMITED + signal] > 0.0
    )


@point
def keep(m, line, out, frames, channels, at):
    """Copy one signal, from out[at] on, into a stretch of its delay line; its highest magnitude."""
    peak = 0.0
    for n in range(frames):
        y = float(out[at & NOT_NEGATIVE])
        at += channels
        m[(line + n) & NOT_NEGATIVE] = y
        peak = max(peak, abs(y))
    return peak


@point
def pass_through(m, w, out, frames, channels, signal, channel):
    """A signal to which nothing is done: into the delay line; its peak is booked."""
    line = layout.L_LINES + signal * layout.DELAY_LINE
    written = w[layout.L_LINE] & (layout.DELAY_LINE - 1)
    first = min(frames, layout.DELAY_LINE - written)
    peak = keep(m, line + written, out, first, channels, channel)
    if first < frames:
        # as a delay line in a circle has it: the rest from its start on
        peak = max(peak, keep(m, line, out, frames - first, channels, channel + first * channels))
    if peak > FULL_SCALE:
        for n in range(frames):
            i = channel + n * channels
            out[i] = min(max(out[i], -FULL_SCALE), FULL_SCALE)
    m[layout.L_PEAK + signal] = max(m[layout.L_PEAK + signal], min(peak, FULL_SCALE))


@routine
def treat(m, w, out, frames, channels, signal, channel):
    """One signal of a block through its gain, delay and ceiling; its peak is booked."""
    if is_untouched(m, w, signal):
        pass_through(m, w, out, frames, channels, signal, channel)
        return
    per_glide = 1.0 / float(w[layout.S_GLIDE])
    line = layout.L_LINES + signal * layout.DELAY_LINE
    written = w[layout.L_LINE]
    peak = m[layout.L_PEAK + signal]
    driven = signal == TACTOR and w[layout.L_ACTUATOR + layout.ACT_ON] == 1
    for n in range(frames):
        at = written + n
        m[line + (at & (layout.DELAY_LINE - 1))] = float(out[channel + n * channels])
        gain = glided(m, w, signal, per_glide)
        ceiling = glided(m, w, layout.SIGNALS + signal, per_glide)
        part = glided(m, w, 2 * layout.SIGNALS + signal, per_glide)
        y = gain * delayed(m, w, signal, line, at, per_glide)
        if driven:
            y = drive(m, w, layout.L_ACTUATOR, y)
        if part > 0.0:
            y = y + part * (limit(y, ceiling) - y)
        y = min(max(y, -FULL_SCALE), FULL_SCALE)
        peak = max(peak, abs(y))
        out[channel + n * channels] = y
    m[layout.L_PEAK + signal] = peak


@point
def fade_out(w, out, frames, channels):
    """Fade a block towards the stream's end; whether silence is reached."""
    length = w[layout.S_GLIDE]
    for n in range(frames):
        left = max(0, length - 1 - w[layout.L_FADED])
        gain = smooth_step(float(left) / float(length))
        for channel in range(channels):
            out[n * channels + channel] = out[n * channels + channel] * gain
        w[layout.L_FADED] += 1
    return w[layout.L_FADED] >= length


@point
def finish(m, w, out, frames, channels):
    """What a device's block still needs after `process`; whether the stream is over."""
    take_wishes(m, w)
    if w[layout.S_CLICK_CHANNEL] >= 0:
        treat(m, w, out, frames, channels, 0, w[layout.S_CLICK_CHANNEL])
    if w[layout.S_TACTOR_CHANNEL] >= 0:
        treat(m, w, out, frames, channels, 1, w[layout.S_TACTOR_CHANNEL])
    w[layout.L_LINE] += frames
    if w[layout.L_STOP] == 1:
        return fade_out(w, out, frames, channels)
    return False


@entry
def finish_block(m, w, out, frames, channels):
    """`finish` for callers in Python: out is float32 [frames * channels], treated in place."""
    return finish(m, w, out, frames, channels)
