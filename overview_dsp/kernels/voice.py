"""Third stage: envelope, carrier, grain and ringing modes, sample after sample.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import follow
from overview_dsp.kernels.modal_bank import ring
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.texture import colour, spread


@inlined
def sound(f64, i64, u64, frames, trace, at, traced):
    """Fill the D_CLICK and D_TACTOR columns of one chunk, and the trace's envelope.

    `at` is the trace index of the chunk's first frame.
    """
    ring(f64, i64, frames)
    follower = f64[layout.FOLLOWER]
    e1 = f64[layout.ENVELOPE_1]
    e2 = f64[layout.ENVELOPE_2]
    tactor_in = f64[layout.TACTOR_DC_IN]
    tactor_out = f64[layout.TACTOR_DC_OUT]
    click_in = f64[layout.CLICK_DC_IN]
    click_out = f64[layout.CLICK_DC_OUT]
    level = f64[layout.GRAIN]
    grain = f64[layout.TEXTURE]
    noise = u64[layout.NOISE]

    decay = f64[layout.C_DECAY]
    rise = f64[layout.C_RISE]
    tactor_gain = f64[layout.C_TACTOR_GAIN]
    click_gain = f64[layout.C_CLICK_GAIN]
    spreading = f64[layout.C_GRAIN]
    dc_pole = f64[layout.C_DC_POLE]

    for n in range(frames):
        follower, e1, e2 = follow(f64[layout.D_AMPLITUDE + n], follower, e1, e2, decay, rise)
        wave = e2 * tactor_gain * f64[layout.D_SINE + n]
        tactor_out = block_dc(wave, tactor_in, tactor_out, dc_pole)
        tactor_in = wave
        f64[layout.D_TACTOR + n] = tactor_out

        level = spread(f64[layout.D_GRAIN + n], level, spreading)
        rough = 0.0
        if level > 0.0:
            noise = next_state(noise)
            rough = level * white(noise)
        grain = colour(rough, grain, f64[layout.D_COLOUR + n])
        clicks = (grain + f64[layout.D_RING + n]) * click_gain
        click_out = block_dc(clicks, click_in, click_out, dc_pole)
        click_in = clicks
        f64[layout.D_CLICK + n] = click_out
        if traced:
            trace[at + n * layout.TRACE + 8] = e2 * tactor_gain

    f64[layout.FOLLOWER] = follower
    f64[layout.ENVELOPE_1] = e1
    f64[layout.ENVELOPE_2] = e2
    f64[layout.TACTOR_DC_IN] = tactor_in
    f64[layout.TACTOR_DC_OUT] = tactor_out
    f64[layout.CLICK_DC_IN] = click_in
    f64[layout.CLICK_DC_OUT] = click_out
    f64[layout.GRAIN] = level
    f64[layout.TEXTURE] = grain
    u64[layout.NOISE] = noise
    f64[layout.M_ENVELOPE] = e2 * tactor_gain
