"""Third stage: envelope, carrier, texture and ringing modes, sample by sample.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import follow
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.texture import low_pass, smooth_level


@inlined
def sound_state(f64, u64):
    """Return the state of the sound stage, in the order of `sound_once`."""
    return (
        f64[layout.FOLLOWER],
        f64[layout.ENVELOPE_1],
        f64[layout.ENVELOPE_2],
        f64[layout.TACTOR_DC_IN],
        f64[layout.TACTOR_DC_OUT],
        f64[layout.TEXTURE_LEVEL],
        u64[layout.NOISE],
        f64[layout.TEXTURE],
        f64[layout.CLICK_DC_IN],
        f64[layout.CLICK_DC_OUT],
    )


@inlined
def keep_sound_state(f64, u64, state):
    """Store the state that `sound_state` returns."""
    f64[layout.FOLLOWER] = state[0]
    f64[layout.ENVELOPE_1] = state[1]
    f64[layout.ENVELOPE_2] = state[2]
    f64[layout.TACTOR_DC_IN] = state[3]
    f64[layout.TACTOR_DC_OUT] = state[4]
    f64[layout.TEXTURE_LEVEL] = state[5]
    u64[layout.NOISE] = state[6]
    f64[layout.TEXTURE] = state[7]
    f64[layout.CLICK_DC_IN] = state[8]
    f64[layout.CLICK_DC_OUT] = state[9]


@inlined
def sound_coefficients(f64):
    """Return the coefficients of `sound_once`, in its order."""
    return (
        f64[layout.C_DECAY],
        f64[layout.C_RISE],
        f64[layout.C_TACTOR_GAIN],
        f64[layout.C_TEXTURE_LEVEL],
        f64[layout.C_CLICK_GAIN],
        f64[layout.C_DC_POLE],
    )


@inlined
def sound_once(f64, n, state, coefficients):
    """Compute sample n of the D_TACTOR and D_CLICK columns; return the state after it.

    The envelope replaces the amplitude in its column.
    """
    follower, e1, e2, tactor_in, tactor_out, level, noise, texture, click_in, click_out = state
    decay, rise, tactor_gain, level_smoothing, click_gain, dc_pole = coefficients

    follower, e1, e2 = follow(f64[layout.D_AMPLITUDE + n], follower, e1, e2, decay, rise)
    envelope = e2 * tactor_gain
    wave = envelope * f64[layout.D_SINE + n]
    tactor_out = block_dc(wave, tactor_in, tactor_out, dc_pole)
    f64[layout.D_AMPLITUDE + n] = envelope
    f64[layout.D_TACTOR + n] = tactor_out

    level = smooth_level(f64[layout.D_TEXTURE_LEVEL + n], level, level_smoothing)
    rough = 0.0
    if level > 0.0:
        noise = next_state(noise)
        rough = level * white(noise)
    texture = low_pass(rough, texture, f64[layout.D_BRIGHTNESS + n])
    clicks = (texture + f64[layout.D_RING + n]) * click_gain
    click_out = block_dc(clicks, click_in, click_out, dc_pole)
    f64[layout.D_CLICK + n] = click_out
    return follower, e1, e2, wave, tactor_out, level, noise, texture, clicks, click_out


@outlined
def sound(f64, u64, start, stop):
    """Compute samples `start` to `stop` of a chunk's D_TACTOR and D_CLICK columns."""
    state = sound_state(f64, u64)
    coefficients = sound_coefficients(f64)
    for n in range(start, stop):
        state = sound_once(f64, n % layout.CHUNK, state, coefficients)
    keep_sound_state(f64, u64, state)
