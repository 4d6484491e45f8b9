"""The stages of a chunk for voices side by side: the loops of `viscous`, `shaping` and `voice`.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import lane_memory as own
from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import routine
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.elementary import sin_turns
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.friction import frictions_at
from overview_dsp.kernels.lanes import LANES, choose, load, load_words, store, store_pairs
from overview_dsp.kernels.motion import NEAR_REST
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.texture import brightness, colour, grain_level, spread
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.viscous import STANDSTILL, snapped

APPROACH = own.of_state(layout.APPROACH)
X = own.of_state(layout.X)
V = own.of_state(layout.V)
SMOOTH_1 = own.of_state(layout.SMOOTH_1)
SMOOTH_2 = own.of_state(layout.SMOOTH_2)
FOLLOWER = own.of_state(layout.FOLLOWER)
ENVELOPE_1 = own.of_state(layout.ENVELOPE_1)
ENVELOPE_2 = own.of_state(layout.ENVELOPE_2)
PHASE = own.of_state(layout.PHASE)
TACTOR_DC_IN = own.of_state(layout.TACTOR_DC_IN)
TACTOR_DC_OUT = own.of_state(layout.TACTOR_DC_OUT)
GRAIN = own.of_state(layout.GRAIN)
TEXTURE = own.of_state(layout.TEXTURE)
CLICK_DC_IN = own.of_state(layout.CLICK_DC_IN)
CLICK_DC_OUT = own.of_state(layout.CLICK_DC_OUT)
NOISE = own.of_state(layout.NOISE)
IMPULSE = own.of_state(layout.M_IMPULSE)
STILL = own.of_state(layout.M_STILL)
SILENT = own.of_state(layout.M_SILENT)
LAST_TORQUE = own.of_state(layout.M_TORQUE)
LAST_FRICTION = own.of_state(layout.M_FRICTION)
LAST_ENVELOPE = own.of_state(layout.M_ENVELOPE)
PEAK_CLICK = own.of_state(layout.M_PEAK_CLICK)
PEAK_TACTOR = own.of_state(layout.M_PEAK_TACTOR)
C_SMOOTH = own.of_coefficient(layout.C_SMOOTH)
C_INERTIA = own.of_coefficient(layout.C_INERTIA)
C_OMEGA = own.of_coefficient(layout.C_OMEGA)
C_FORGET = own.of_coefficient(layout.C_FORGET)
C_CARRIER = own.of_coefficient(layout.C_CARRIER)
C_TORQUE = own.of_coefficient(layout.C_TORQUE)
C_GATE = own.of_coefficient(layout.C_GATE)
C_EXPONENT = own.of_coefficient(layout.C_EXPONENT)
C_TEXTURE_GAIN = own.of_coefficient(layout.C_TEXTURE_GAIN)
C_TEXTURE_CUTOFF = own.of_coefficient(layout.C_TEXTURE_CUTOFF)
C_DECAY = own.of_coefficient(layout.C_DECAY)
C_RISE = own.of_coefficient(layout.C_RISE)
C_TACTOR_GAIN = own.of_coefficient(layout.C_TACTOR_GAIN)
C_CLICK_GAIN = own.of_coefficient(layout.C_CLICK_GAIN)
C_GRAIN = own.of_coefficient(layout.C_GRAIN)
C_DC_POLE = own.of_coefficient(layout.C_DC_POLE)


@routine
def travel_all(b, wb, frames, traced):
    """`travel` for lanes, through a whole chunk: events that are passed on the way stop no lane."""
    x = load(b, X)
    half = 0.5 * load(b, V)
    y1 = load(b, SMOOTH_1)
    y2 = load(b, SMOOTH_2)
    phase = load(b, PHASE)
    approach = load(b, APPROACH)
    impulse = load(b, IMPULSE)
    still = load_words(wb, STILL)
    torque = load(b, LAST_TORQUE)
    friction = load(b, LAST_FRICTION)
    highest = x
    lowest = x
    for n in range(frames):
        at = n * LANES
        y1, y2 = smooth(load(b, own.INPUT), y1, y2, load(b, C_SMOOTH))
        friction = frictions_at(b, wb, own.TABLE, x + half)
        rest = y2 * load(b, own.HOLD)
        middle = midpoint_speed(
            x,
            2.0 * half,
            rest,
            load(b, own.SPRING),
            load(b, C_INERTIA),
            load(b, own.DENOMINATOR),
            friction,
        )
        x = x + middle
        half = middle - half
        omega = middle * load(b, C_OMEGA)
        approach = max(abs(omega), approach * load(b, C_FORGET))
        near = min(abs(x), abs(half)) < STANDSTILL
        x = snapped(x, STANDSTILL)
        half = snapped(half, 0.5 * STANDSTILL)
        approach = choose(near, snapped(approach, STANDSTILL), approach)
        phase = advance(phase, load(b, C_CARRIER))
        torque = friction * omega
        impulse = impulse + torque
        highest = max(highest, x)
        lowest = min(lowest, x)
        still = choose(abs(x - rest) < NEAR_REST, still + 1, 0)
        store(b, own.TORQUE + at, torque)
        store(b, own.OMEGA + at, omega)
        store(b, own.PHASE + at, phase)
        store(b, own.PLACE + at, x)
        store(b, own.APPROACH + at, approach)
        if traced:
            store(b, own.SPEED + at, 2.0 * half)
            store(b, own.THETA2 + at, y2)
            store(b, own.FRICTION + at, friction)
    store(b, X, x)
    store(b, V, 2.0 * half)
    store(b, SMOOTH_1, y1)
    store(b, SMOOTH_2, y2)
    store(b, PHASE, phase)
    store(b, APPROACH, approach)
    store(b, IMPULSE, impulse)
    store(b, STILL, still)
    store(b, LAST_TORQUE, torque)
    store(b, LAST_FRICTION, friction)
    store(b, own.HIGHEST, highest)
    store(b, own.LOWEST, lowest)


@routine
def shape_all(b, frames):
    """`shape` for lanes; in two loops, whose chains a processor overlaps better."""
    for at in range(0, frames * LANES, LANES):
        torque = load(b, own.TORQUE + at)
        amplitude = compress(torque, load(b, C_TORQUE), load(b, C_GATE), load(b, C_EXPONENT))
        store(b, own.AMPLITUDE + at, amplitude)
    for at in range(0, frames * LANES, LANES):
        omega = load(b, own.OMEGA + at)
        level = grain_level(load(b, own.TORQUE + at), omega, load(b, C_TEXTURE_GAIN))
        store(b, own.SINE + at, sin_turns(load(b, own.PHASE + at)))
        store(b, own.GRAIN + at, level)
        store(b, own.COLOUR + at, brightness(omega, load(b, C_TEXTURE_CUTOFF)))


@routine
def sound_all(b, ub, frames, traced):
    """`sound` for lanes, whose modes have rung already."""
    follower = load(b, FOLLOWER)
    e1 = load(b, ENVELOPE_1)
    e2 = load(b, ENVELOPE_2)
    tactor_in = load(b, TACTOR_DC_IN)
    tactor_out = load(b, TACTOR_DC_OUT)
    click_in = load(b, CLICK_DC_IN)
    click_out = load(b, CLICK_DC_OUT)
    level = load(b, GRAIN)
    grain = load(b, TEXTURE)
    noise = load_words(b, NOISE)
    silent = load_words(ub, SILENT)
    envelope = load(b, LAST_ENVELOPE)
    loudest_tactor = choose(level >= 0.0, 0.0, 0.0)
    loudest_click = loudest_tactor
    for at in range(0, frames * LANES, LANES):
        amplitude = load(b, own.AMPLITUDE + at)
        follower, e1, e2 = follow(amplitude, follower, e1, e2, load(b, C_DECAY), load(b, C_RISE))
        envelope = e2 * load(b, C_TACTOR_GAIN)
        wave = envelope * load(b, own.SINE + at)
        tactor_out = block_dc(wave, tactor_in, tactor_out, load(b, C_DC_POLE))
        tactor_in = wave
        level = spread(load(b, own.GRAIN + at), level, load(b, C_GRAIN))
        rough = level > 0.0
        following = next_state(noise)
        noise = choose(rough, following, noise)
        grain = colour(
            choose(rough, level * white(following), 0.0), grain, load(b, own.COLOUR + at)
        )
        clicks = (grain + load(b, own.RING + at)) * load(b, C_CLICK_GAIN)
        click_out = block_dc(clicks, click_in, click_out, load(b, C_DC_POLE))
        click_in = clicks
        store(b, own.TACTOR + at, tactor_out)
        store(b, own.CLICK + at, click_out)
        tactor_size = abs(tactor_out)
        click_size = abs(click_out)
        loudest_tactor = max(loudest_tactor, tactor_size)
        loudest_click = max(loudest_click, click_size)
        silent = choose(max(tactor_size, click_size) == 0.0, silent + 1, 0)
        if traced:
            store(b, own.ENVELOPE + at, envelope)
    store(b, FOLLOWER, follower)
    store(b, ENVELOPE_1, e1)
    store(b, ENVELOPE_2, e2)
    store(b, TACTOR_DC_IN, tactor_in)
    store(b, TACTOR_DC_OUT, tactor_out)
    store(b, CLICK_DC_IN, click_in)
    store(b, CLICK_DC_OUT, click_out)
    store(b, GRAIN, level)
    store(b, TEXTURE, grain)
    store(b, NOISE, noise)
    store(b, SILENT, silent)
    store(b, LAST_ENVELOPE, envelope)
    store(b, own.LOUDEST_CLICK, loudest_click)
    store(b, own.LOUDEST_TACTOR, loudest_tactor)


@routine
def write_all(b, out, start, apart, frames):
    """`write` for lanes, into two channels: from float `start` on, and lanes `apart` floats."""
    for n in range(frames):
        at = n * LANES
        click = load(b, own.CLICK + at)
        tactor = load(b, own.TACTOR + at)
        store_pairs(out, start + 2 * n, apart, click, tactor)
    store(b, PEAK_CLICK, max(load(b, PEAK_CLICK), load(b, own.LOUDEST_CLICK)))
    store(b, PEAK_TACTOR, max(load(b, PEAK_TACTOR), load(b, own.LOUDEST_TACTOR)))
