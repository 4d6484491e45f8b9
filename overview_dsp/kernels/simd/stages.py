"""Stages of a chunk for voices in lanes: the loops of `viscous`, `shaping` and `voice`.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.clutch import MIDDLE, OFF, allowed_speed, clutched, slowed
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.friction_lookup import any_steep, frictions_at, mean_frictions, steep_at
from overview_dsp.kernels.math_functions import sin_turns
from overview_dsp.kernels.motion import NEAR_REST
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.simd import memory as own
from overview_dsp.kernels.simd.vector import (
    SIMD_WIDTH,
    any_of,
    choose,
    load,
    load_words,
    store,
    store_pairs,
)
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.texture import brightness, low_pass, smooth_level, texture_level
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.viscous import STANDSTILL, flush_to_zero

APPROACH = own.of_state(layout.APPROACH)
X = own.of_state(layout.X)
V = own.of_state(layout.V)
PACE = own.of_state(layout.PACE)
WOUND = own.of_state(layout.WOUND)
SLIP = own.of_state(layout.SLIP)
WANTED = own.of_state(layout.WANTED)
SMOOTH_1 = own.of_state(layout.SMOOTH_1)
SMOOTH_2 = own.of_state(layout.SMOOTH_2)
FOLLOWER = own.of_state(layout.FOLLOWER)
ENVELOPE_1 = own.of_state(layout.ENVELOPE_1)
ENVELOPE_2 = own.of_state(layout.ENVELOPE_2)
PHASE = own.of_state(layout.PHASE)
TACTOR_DC_IN = own.of_state(layout.TACTOR_DC_IN)
TACTOR_DC_OUT = own.of_state(layout.TACTOR_DC_OUT)
TEXTURE_LEVEL = own.of_state(layout.TEXTURE_LEVEL)
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
C_SPEED_RATIO = own.of_coefficient(layout.C_SPEED_RATIO)
C_TAP_RATE = own.of_coefficient(layout.C_TAP_RATE)
C_LAG_RATE = own.of_coefficient(layout.C_LAG_RATE)
C_MAX_SPEED = own.of_coefficient(layout.C_MAX_SPEED)
C_PACE_LEAST = own.of_coefficient(layout.C_PACE_LEAST)
C_PACE_MOST = own.of_coefficient(layout.C_PACE_MOST)
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
C_TEXTURE_LEVEL = own.of_coefficient(layout.C_TEXTURE_LEVEL)
C_DC_POLE = own.of_coefficient(layout.C_DC_POLE)


@inlined
def sound_state_all(batch_f64, batch_u64):
    """Return the state of the sound stage, in the order of `sound_once_all`."""
    return (
        load(batch_f64, FOLLOWER),
        load(batch_f64, ENVELOPE_1),
        load(batch_f64, ENVELOPE_2),
        load(batch_f64, TACTOR_DC_IN),
        load(batch_f64, TACTOR_DC_OUT),
        load(batch_f64, TEXTURE_LEVEL),
        load_words(batch_f64, NOISE),
        load(batch_f64, TEXTURE),
        load(batch_f64, CLICK_DC_IN),
        load(batch_f64, CLICK_DC_OUT),
        load_words(batch_u64, SILENT),
        load(batch_f64, own.LOUDEST_CLICK),
        load(batch_f64, own.LOUDEST_TACTOR),
    )


@inlined
def keep_sound_state_all(batch_f64, state):
    """Store the state that `sound_state_all` returns."""
    store(batch_f64, FOLLOWER, state[0])
    store(batch_f64, ENVELOPE_1, state[1])
    store(batch_f64, ENVELOPE_2, state[2])
    store(batch_f64, TACTOR_DC_IN, state[3])
    store(batch_f64, TACTOR_DC_OUT, state[4])
    store(batch_f64, TEXTURE_LEVEL, state[5])
    store(batch_f64, NOISE, state[6])
    store(batch_f64, TEXTURE, state[7])
    store(batch_f64, CLICK_DC_IN, state[8])
    store(batch_f64, CLICK_DC_OUT, state[9])
    store(batch_f64, SILENT, state[10])
    store(batch_f64, own.LOUDEST_CLICK, state[11])
    store(batch_f64, own.LOUDEST_TACTOR, state[12])


@inlined
def sound_once_all(batch_f64, at, state):
    """`sound_once` for lanes, after their modes: the rows from `at` on."""
    (
        follower,
        e1,
        e2,
        tactor_in,
        tactor_out,
        level,
        noise,
        texture,
        click_in,
        click_out,
        silent,
        loudest_click,
        loudest_tactor,
    ) = state
    amplitude = load(batch_f64, own.AMPLITUDE + at)
    follower, e1, e2 = follow(
        amplitude, follower, e1, e2, load(batch_f64, C_DECAY), load(batch_f64, C_RISE)
    )
    envelope = e2 * load(batch_f64, C_TACTOR_GAIN)
    wave = envelope * load(batch_f64, own.SINE + at)
    tactor_out = block_dc(wave, tactor_in, tactor_out, load(batch_f64, C_DC_POLE))
    level = smooth_level(
        load(batch_f64, own.TEXTURE_LEVEL + at), level, load(batch_f64, C_TEXTURE_LEVEL)
    )
    rough = level > 0.0
    following = next_state(noise)
    noise = choose(rough, following, noise)
    texture = low_pass(
        choose(rough, level * white(following), 0.0), texture, load(batch_f64, own.BRIGHTNESS + at)
    )
    clicks = (texture + load(batch_f64, own.RING + at)) * load(batch_f64, C_CLICK_GAIN)
    click_out = block_dc(clicks, click_in, click_out, load(batch_f64, C_DC_POLE))
    store(batch_f64, own.AMPLITUDE + at, envelope)
    store(batch_f64, own.TACTOR + at, tactor_out)
    store(batch_f64, own.CLICK + at, click_out)
    tactor_size = abs(tactor_out)
    click_size = abs(click_out)
    loudest_tactor = max(loudest_tactor, tactor_size)
    loudest_click = max(loudest_click, click_size)
    silent = choose(max(tactor_size, click_size) == 0.0, silent + 1, 0)
    return (
        follower,
        e1,
        e2,
        wave,
        tactor_out,
        level,
        noise,
        texture,
        clicks,
        click_out,
        silent,
        loudest_click,
        loudest_tactor,
    )


@outlined
def sound_all(batch_f64, batch_u64, frames):
    """`sound` for lanes."""
    state = sound_state_all(batch_f64, batch_u64)
    for at in range(0, frames * SIMD_WIDTH, SIMD_WIDTH):
        state = sound_once_all(batch_f64, at, state)
    keep_sound_state_all(batch_f64, state)


@outlined
def advance_disk_all(batch_f64, batch_i64, frames, traced):
    """`advance_disk` for lanes, up to the first sample in which a disk arrives after a release.

    Events that are passed on the way stop no lane. Returns the sample after it, or the chunk's end.
    """
    x = load(batch_f64, X)
    half = 0.5 * load(batch_f64, V)
    y1 = load(batch_f64, SMOOTH_1)
    y2 = load(batch_f64, SMOOTH_2)
    phase = load(batch_f64, PHASE)
    approach = load(batch_f64, APPROACH)
    pace = load(batch_f64, PACE)
    wound = load(batch_f64, WOUND)
    slip = load(batch_f64, SLIP)
    # any speed but 0 is valid for a rigid shaft
    wanted = choose(load(batch_f64, own.REACH) < OFF, load(batch_f64, WANTED), 1.0)
    impulse = load(batch_f64, IMPULSE)
    still = load_words(batch_i64, STILL)
    torque = load(batch_f64, LAST_TORQUE)
    friction = load(batch_f64, LAST_FRICTION)
    per_inertia = 1.0 / load(batch_f64, C_INERTIA)
    highest = x
    lowest = x
    n = 0
    arrived = False
    while n < frames and not arrived:
        at = n * SIMD_WIDTH
        was = y2
        y1, y2 = smooth(load(batch_f64, own.INPUT), y1, y2, load(batch_f64, C_SMOOTH))
        friction = frictions_at(batch_f64, batch_i64, own.TABLE, x + half)
        moved = abs(y2 - was)
        counts = choose(slip == 0.0, moved, max(moved, pace))
        moves = choose(moved < load(batch_f64, C_PACE_MOST), moved, 0.0)
        moves = moves > load(batch_f64, C_PACE_LEAST)
        counts = choose(moves, counts, pace)
        pace = pace + load(batch_f64, own.PACING) * (counts - pace)
        rigid = y2 * load(batch_f64, own.HOLD) - x
        free = friction * load(batch_f64, own.REACH) + MIDDLE
        max_speed = load(batch_f64, C_MAX_SPEED)
        growth = load(batch_f64, own.WINDUP) * min(pace, max_speed)
        stretch = clutched(rigid, wound, wanted * free, growth)
        slip = rigid - stretch
        used = choose(abs(slip) > 0.0, x + stretch, y2)
        wound = stretch
        wanted = allowed_speed(
            rigid,
            free * pace,
            pace,
            load(batch_f64, C_SPEED_RATIO),
            load(batch_f64, C_LAG_RATE),
            load(batch_f64, C_TAP_RATE),
            max_speed,
        )
        resting = slowed(wanted, rigid, 2.0 * half, friction, per_inertia)
        wanted = choose(moves, wanted, resting)
        middle = midpoint_speed(
            2.0 * half,
            stretch,
            load(batch_f64, own.SPRING),
            load(batch_f64, C_INERTIA),
            load(batch_f64, own.DENOMINATOR),
            friction,
        )
        if any_steep(batch_i64, batch_i64, own.TABLE, x + half):
            mean, of_mean = mean_frictions(
                batch_f64,
                batch_i64,
                own.TABLE,
                x,
                2.0 * half,
                stretch,
                load(batch_f64, own.SPRING),
                load(batch_f64, C_INERTIA),
                load(batch_f64, own.DENOMINATOR),
                middle,
            )
            steep = steep_at(batch_i64, batch_i64, own.TABLE, x + half)
            friction = choose(steep, mean, friction)
            middle = choose(steep, of_mean, middle)
        x = x + middle
        half = middle - half
        omega = middle * load(batch_f64, C_OMEGA)
        approach = max(abs(omega), approach * load(batch_f64, C_FORGET))
        tiny = min(abs(x), abs(half)) < STANDSTILL
        x = flush_to_zero(x, STANDSTILL)
        half = flush_to_zero(half, 0.5 * STANDSTILL)
        approach = choose(tiny, flush_to_zero(approach, STANDSTILL), approach)
        phase = advance(phase, load(batch_f64, C_CARRIER))
        torque = friction * omega
        impulse = impulse + torque
        highest = max(highest, x)
        lowest = min(lowest, x)
        at_rest = load(batch_f64, own.INPUT) * load(batch_f64, own.HOLD)
        still = choose(abs(x - at_rest) < NEAR_REST, still + 1, 0)
        store(batch_f64, own.TORQUE + at, torque)
        store(batch_f64, own.OMEGA + at, omega)
        store(batch_f64, own.PHASE + at, phase)
        store(batch_f64, own.POSITION + at, x)
        store(batch_f64, own.APPROACH + at, approach)
        if traced:
            store(batch_f64, own.SPEED + at, 2.0 * half)
            store(batch_f64, own.THETA2 + at, used)
            store(batch_f64, own.FRICTION + at, friction)
        below = choose(x < load(batch_f64, own.ARRIVAL_BELOW), 1.0, 0.0)
        arrived = any_of(choose(x >= load(batch_f64, own.ARRIVAL_ABOVE), 1.0, below) > 0.0)
        n += 1
    store(batch_f64, X, x)
    store(batch_f64, V, 2.0 * half)
    store(batch_f64, SMOOTH_1, y1)
    store(batch_f64, SMOOTH_2, y2)
    store(batch_f64, PHASE, phase)
    store(batch_f64, APPROACH, approach)
    store(batch_f64, PACE, pace)
    store(batch_f64, WOUND, wound)
    store(batch_f64, SLIP, slip)
    store(batch_f64, WANTED, choose(load(batch_f64, own.REACH) < OFF, wanted, 0.0))
    store(batch_f64, IMPULSE, impulse)
    store(batch_f64, STILL, still)
    store(batch_f64, LAST_TORQUE, torque)
    store(batch_f64, LAST_FRICTION, friction)
    store(batch_f64, own.HIGHEST, highest)
    store(batch_f64, own.LOWEST, lowest)
    return n


@inlined
def gain_at(batch_f64, at):
    """Return the output gains of the sample whose rows begin at `at`."""
    sample = load(batch_f64, own.BEYOND) + float(at // SIMD_WIDTH + 1)
    return load(batch_f64, own.GAIN_FROM) + load(batch_f64, own.GAIN_STEP) * sample


@outlined
def shape_all(batch_f64, frames):
    """`shape` for lanes, in two loops, which processors overlap better."""
    store(batch_f64, own.LOUDEST_CLICK, 0.0)
    store(batch_f64, own.LOUDEST_TACTOR, 0.0)
    for at in range(0, frames * SIMD_WIDTH, SIMD_WIDTH):
        torque = load(batch_f64, own.TORQUE + at) * gain_at(batch_f64, at)
        amplitude = compress(
            torque, load(batch_f64, C_TORQUE), load(batch_f64, C_GATE), load(batch_f64, C_EXPONENT)
        )
        store(batch_f64, own.AMPLITUDE + at, amplitude)
    for at in range(0, frames * SIMD_WIDTH, SIMD_WIDTH):
        omega = load(batch_f64, own.OMEGA + at)
        gain = load(batch_f64, C_TEXTURE_GAIN) * load(batch_f64, own.TEXTURE_GAIN)
        level = texture_level(load(batch_f64, own.TORQUE + at), omega, gain)
        store(batch_f64, own.SINE + at, sin_turns(load(batch_f64, own.PHASE + at)))
        store(batch_f64, own.TEXTURE_LEVEL + at, level)
        store(batch_f64, own.BRIGHTNESS + at, brightness(omega, load(batch_f64, C_TEXTURE_CUTOFF)))


@outlined
def write_all(batch_f64, out, start, stride, frames):
    """`write` for lanes with two channels, from float `start` on, with `stride` floats per lane."""
    store(batch_f64, LAST_ENVELOPE, load(batch_f64, own.AMPLITUDE + (frames - 1) * SIMD_WIDTH))
    for n in range(frames):
        at = n * SIMD_WIDTH
        click = load(batch_f64, own.CLICK + at)
        tactor = load(batch_f64, own.TACTOR + at)
        store_pairs(out, start + 2 * n, stride, click, tactor)
    store(
        batch_f64, PEAK_CLICK, max(load(batch_f64, PEAK_CLICK), load(batch_f64, own.LOUDEST_CLICK))
    )
    store(
        batch_f64,
        PEAK_TACTOR,
        max(load(batch_f64, PEAK_TACTOR), load(batch_f64, own.LOUDEST_TACTOR)),
    )
