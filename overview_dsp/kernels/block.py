"""Block processing: events, runs of samples between them, meters, and a guard.

`process` divides a block only at events and while coefficients are smoothed. All state columns are
carried from sample to sample, so the partition into blocks changes no bit.

Thread: audio (`process`), main (`reset`, `tactor_stage`).
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import store_release
from overview_dsp.kernels.compiling import entry_point, inlined, outlined
from overview_dsp.kernels.control_events import (
    apply_pending,
    discard_pending,
    glide_all,
    is_gliding,
    next_event_time,
)
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.limiter import limit
from overview_dsp.kernels.math_functions import sin_turns
from overview_dsp.kernels.modal_bank import ring
from overview_dsp.kernels.motion import move
from overview_dsp.kernels.output import emit
from overview_dsp.kernels.output_gain import on_grid, set_gain
from overview_dsp.kernels.release import stop_waiting
from overview_dsp.kernels.shaping import shape
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.voice import sound

STEP = 32  # samples of a chunk, at most `layout.CHUNK`
SHORT_STEP = 16  # the same in a block of
SHORT = 64  # frames or fewer


@outlined
def synthesize(f64, i64, out, start, frames, channels, trace, traced):
    """Write a chunk's sound to the output from frame `start` on, and its envelope to the trace."""
    f64[layout.M_ENVELOPE] = f64[layout.D_AMPLITUDE + frames - 1]
    if traced:
        for n in range(frames):
            trace[(start + n) * layout.TRACE + 8] = f64[layout.D_AMPLITUDE + n]
    emit(f64, i64, out, start, frames, channels)


@inlined
def run(f64, i64, u64, out, channels, start, stop, step, waiting, trace, traced):
    """Process samples `start` to `stop` of a block, without events, in chunks of `step`.

    The sound of a chunk is computed together with the motion of the next one, since the two are
    independent. `waiting` samples before `start` have no sound yet; returns the number afterwards.
    """
    while start < stop:
        beyond = on_grid(i64)
        if beyond == 0:
            set_gain(f64, i64)
        frames = min(stop - start, step, layout.GAIN_GRID - beyond)
        move(f64, i64, u64, frames, waiting, trace, start * layout.TRACE, traced)
        if waiting > 0:
            synthesize(f64, i64, out, start - waiting, waiting, channels, trace, traced)
        shape(f64, frames, beyond)
        ring(f64, i64, frames)
        waiting = frames
        i64[layout.CLOCK] += frames
        start += frames
    return waiting


@inlined
def synthesize_pending(f64, i64, u64, out, channels, stop, waiting, trace, traced):
    """Synthesize the `waiting` samples before frame `stop`."""
    if waiting > 0:
        sound(f64, u64, 0, waiting)
        synthesize(f64, i64, out, stop - waiting, waiting, channels, trace, traced)


@inlined
def clear(f64, i64, u64):
    """Clear all state columns and meters; keep coefficients, rings and surfaces."""
    for i in range(layout.STATE, layout.ACTIVE_SLOT):
        i64[i] = 0
    for i in range(layout.FADING_SLOT + 1, layout.TOTAL_STATE):
        i64[i] = 0
    store_release(i64, layout.FADING_SLOT, -1)
    i64[layout.STRIKES_READ] = 0
    for number in range(layout.CONTACT):
        i64[layout.STRIKES_SOUNDED + number] = 0
    i64[layout.HOLDER] = -1
    stop_waiting(f64, i64)
    f64[layout.GAIN_FROM] = 1.0
    f64[layout.GAIN_TO] = 1.0
    f64[layout.TEXTURE_GAIN] = 1.0
    u64[layout.NOISE] = u64[layout.S_SEED]


@inlined
def is_finite(f64):
    """Return whether every recursive state column is a finite number."""
    # in pairs, for fewer dependent additions
    motion = (f64[layout.X] + f64[layout.V]) + (f64[layout.SMOOTH_1] + f64[layout.SMOOTH_2])
    tactor = (f64[layout.ENVELOPE_1] + f64[layout.ENVELOPE_2]) + (
        f64[layout.FOLLOWER] + f64[layout.TACTOR_DC_OUT]
    )
    click = (f64[layout.CLICK_DC_OUT] + f64[layout.TEXTURE]) + (
        f64[layout.PHASE] + f64[layout.BRISTLE]
    )
    total = (motion + tactor) + (click + f64[layout.M_IMPULSE])
    return total - total == 0.0


@inlined
def recover(f64, i64, u64, clock, out, start, stop):
    """Reset a voice whose state is not finite after a block, and mute its output."""
    if is_finite(f64):
        return
    blocks = i64[layout.M_BLOCKS]
    resets = i64[layout.M_RESETS]
    clear(f64, i64, u64)
    i64[layout.CLOCK] = clock
    i64[layout.M_BLOCKS] = blocks
    i64[layout.M_RESETS] = resets + 1
    for i in range(start, stop):
        out[i] = 0.0


@entry_point
def reset(f64, i64, u64):
    """Clear state and meters, finish smoothing and crossfades, and drop pending events.

    Thread: main, or audio between blocks.
    """
    clear(f64, i64, u64)
    store_release(i64, layout.APPLIED, 0)
    for i in range(layout.COEFFS):
        if i64[layout.GLIDE_LEFT + i] > 0:
            f64[i] = f64[layout.TARGET + i]
            i64[layout.GLIDE_LEFT + i] = 0
    discard_pending(i64)


@entry_point
def process(f64, i64, u64, out, frames, channels, trace, traced):
    """Process one block of audio.

    Parameters
    ----------
    f64, i64, u64 : float64, int64, uint64 [layout.TOTAL]
        The memory block in three views.
    out : float32 [frames * channels]
        Interleaved output, overwritten.
    frames, channels : int64
    trace : float64 [frames * layout.TRACE] or of any length
        Overwritten if `traced`.
    traced : bool

    Thread: audio. Never allocates, locks or raises.
    """
    f64[layout.M_PEAK_CLICK] = 0.0
    f64[layout.M_PEAK_TACTOR] = 0.0
    # only the motion of the first chunk and the sound of the last one are computed alone
    step = STEP if frames > SHORT else SHORT_STEP
    n = 0
    waiting = 0
    first = i64[layout.CLOCK]
    while n < frames:
        apply_pending(f64, i64)
        stop = frames
        gliding = is_gliding(i64)
        if gliding:
            # smoothed coefficients change every sample; pending sound uses their last values
            synthesize_pending(f64, i64, u64, out, channels, n, waiting, trace, traced)
            waiting = 0
            gliding = glide_all(f64, i64) > 0
        if gliding:
            stop = n + 1
        else:
            due = next_event_time(i64) - first
            if due < stop:
                # a new event may already be due
                stop = due if due > n else n + 1
        waiting = run(f64, i64, u64, out, channels, n, stop, step, waiting, trace, traced)
        n = stop
    synthesize_pending(f64, i64, u64, out, channels, n, waiting, trace, traced)
    i64[layout.M_BLOCKS] += 1
    recover(f64, i64, u64, first + frames, out, 0, frames * channels)


@entry_point
def tactor_stage(f64, torque, out):
    """Compute the tactor channel of a torque signal as `process` does from rest.

    Parameters
    ----------
    f64 : float64 [layout.TOTAL]
        Only the coefficients are read.
    torque : float64 [frames]
        N m.
    out : float32 [frames]
        Overwritten.

    Thread: main.
    """
    follower = 0.0
    e1 = 0.0
    e2 = 0.0
    phase = 0.0
    before = 0.0
    blocked = 0.0
    for n in range(torque.size):
        amplitude = compress(
            torque[n], f64[layout.C_TORQUE], f64[layout.C_GATE], f64[layout.C_EXPONENT]
        )
        follower, e1, e2 = follow(
            amplitude, follower, e1, e2, f64[layout.C_DECAY], f64[layout.C_RISE]
        )
        phase = advance(phase, f64[layout.C_CARRIER])
        wave = e2 * f64[layout.C_TACTOR_GAIN] * sin_turns(phase)
        blocked = block_dc(wave, before, blocked, f64[layout.C_DC_POLE])
        before = wave
        out[n] = limit(blocked, f64[layout.C_CEILING])
