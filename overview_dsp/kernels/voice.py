"""Third stage: the two signals, from the shaped columns to the output.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import ring, sound_strikes
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import follow
from overview_dsp.kernels.limiter import KNEE, limit
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.texture import colour, spread


@point
def sound(m, w, u, out, start, frames, channels, trace, traced):
    """Write frames `start` to `start + frames` of the output, and the trace's envelope."""
    follower = m[layout.FOLLOWER]
    e1 = m[layout.ENVELOPE_1]
    e2 = m[layout.ENVELOPE_2]
    tactor_in = m[layout.TACTOR_DC_IN]
    tactor_out = m[layout.TACTOR_DC_OUT]
    click_in = m[layout.CLICK_DC_IN]
    click_out = m[layout.CLICK_DC_OUT]
    level = m[layout.GRAIN]
    grain = m[layout.TEXTURE]
    noise = u[layout.NOISE]
    silent = w[layout.M_SILENT]
    limited = w[layout.M_LIMITED]
    peak_click = m[layout.M_PEAK_CLICK]
    peak_tactor = m[layout.M_PEAK_TACTOR]
    clock = w[layout.CLOCK]
    strikes = w[layout.M_STRIKES]

    decay = m[layout.C_DECAY]
    rise = m[layout.C_RISE]
    tactor_gain = m[layout.C_TACTOR_GAIN]
    click_gain = m[layout.C_CLICK_GAIN]
    spreading = m[layout.C_GRAIN]
    cutoff = m[layout.C_TEXTURE_CUTOFF]
    ceiling = m[layout.C_CEILING]
    dc_pole = m[layout.C_DC_POLE]
    knee = KNEE * ceiling
    click_channel = w[layout.S_CLICK_CHANNEL]
    tactor_channel = w[layout.S_TACTOR_CHANNEL]

    for n in range(frames):
        follower, e1, e2 = follow(m[layout.D_AMPLITUDE + n], follower, e1, e2, decay, rise)
        wave = e2 * tactor_gain * m[layout.D_SINE + n]
        tactor_out = block_dc(wave, tactor_in, tactor_out, dc_pole)
        tactor_in = wave
        tactor = limit(tactor_out, ceiling)

        level = spread(m[layout.D_GRAIN + n], level, spreading)
        rough = 0.0
        if level > 0.0:
            noise = next_state(noise)
            rough = level * white(noise)
        grain = colour(rough, grain, m[layout.D_OMEGA + n], cutoff)
        if w[layout.STRIKES_SOUNDED + layout.CONTACT - 1] < strikes:
            sound_strikes(m, w, clock + n)
        clicks = grain
        if w[layout.RINGING] > 0:
            clicks = clicks + ring(m, w)
        clicks = clicks * click_gain
        click_out = block_dc(clicks, click_in, click_out, dc_pole)
        click_in = clicks
        click = limit(click_out, ceiling)

        limited += int(abs(tactor_out) > knee) + int(abs(click_out) > knee)
        peak_click = max(peak_click, abs(click))
        peak_tactor = max(peak_tactor, abs(tactor))
        silent = silent + 1 if click == 0.0 and tactor == 0.0 else 0
        first = (start + n) * channels
        for channel in range(channels):
            out[first + channel] = 0.0
        if click_channel >= 0:
            out[first + click_channel] = click
        if tactor_channel >= 0:
            out[first + tactor_channel] = tactor
        if traced:
            trace[(start + n) * layout.TRACE + 8] = e2 * tactor_gain

    m[layout.FOLLOWER] = follower
    m[layout.ENVELOPE_1] = e1
    m[layout.ENVELOPE_2] = e2
    m[layout.TACTOR_DC_IN] = tactor_in
    m[layout.TACTOR_DC_OUT] = tactor_out
    m[layout.CLICK_DC_IN] = click_in
    m[layout.CLICK_DC_OUT] = click_out
    m[layout.GRAIN] = level
    m[layout.TEXTURE] = grain
    u[layout.NOISE] = noise
    w[layout.M_SILENT] = silent
    w[layout.M_LIMITED] = limited
    m[layout.M_PEAK_CLICK] = peak_click
    m[layout.M_PEAK_TACTOR] = peak_tactor
    m[layout.M_ENVELOPE] = e2 * tactor_gain
    w[layout.CLOCK] = clock + frames
