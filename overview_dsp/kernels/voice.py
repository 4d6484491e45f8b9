"""Third stage: envelope, carrier, grain and ringing modes, sample after sample.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import ring, sound_strikes
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import follow
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.texture import colour, spread


@point
def sound(m, w, u, frames, trace, at, traced):
    """Fill the D_CLICK and D_TACTOR columns of one chunk, and the trace's envelope.

    `at` is the trace index of the chunk's first frame.
    """
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
    clock = w[layout.CLOCK]
    strikes = w[layout.M_STRIKES]

    decay = m[layout.C_DECAY]
    rise = m[layout.C_RISE]
    tactor_gain = m[layout.C_TACTOR_GAIN]
    click_gain = m[layout.C_CLICK_GAIN]
    spreading = m[layout.C_GRAIN]
    dc_pole = m[layout.C_DC_POLE]

    for n in range(frames):
        follower, e1, e2 = follow(m[layout.D_AMPLITUDE + n], follower, e1, e2, decay, rise)
        wave = e2 * tactor_gain * m[layout.D_SINE + n]
        tactor_out = block_dc(wave, tactor_in, tactor_out, dc_pole)
        tactor_in = wave
        m[layout.D_TACTOR + n] = tactor_out

        level = spread(m[layout.D_GRAIN + n], level, spreading)
        rough = 0.0
        if level > 0.0:
            noise = next_state(noise)
            rough = level * white(noise)
        grain = colour(rough, grain, m[layout.D_COLOUR + n])
        if w[layout.STRIKES_SOUNDED + layout.CONTACT - 1] < strikes:
            sound_strikes(m, w, clock + n)
        clicks = grain
        if w[layout.RINGING] > 0:
            clicks = clicks + ring(m, w)
        clicks = clicks * click_gain
        click_out = block_dc(clicks, click_in, click_out, dc_pole)
        click_in = clicks
        m[layout.D_CLICK + n] = click_out
        if traced:
            trace[at + n * layout.TRACE + 8] = e2 * tactor_gain

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
    m[layout.M_ENVELOPE] = e2 * tactor_gain
