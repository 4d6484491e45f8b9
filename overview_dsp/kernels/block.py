"""The block driver: events, then runs of samples between them, then meters and the guard.

`process` cuts a block only where an event falls due or a coefficient glides, and every state column
is carried from sample to sample in full, so no partition into blocks can change a bit.

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
    """A chunk's sound into the output from frame `start` on, and its envelope into the trace."""
    f64[layout.M_ENVELOPE] = f64[layout.D_AMPLITUDE + frames - 1]
    if traced:
        for n in range(frames):
            trace[(start + n) * layout.TRACE + 8] = f64[layout.D_AMPLITUDE + n]
    emit(f64, i64, out, start, frames, channels)


@inlined
def run(f64, i64, u64, out, channels, start, stop, step, waiting, trace, traced):
    """Samples `start` to `stop` of a block, between events: the whole voice, `step` at a time.

    The `waiting` samples before them still lack their sound, and so do the last ones afterwards:
    how many is returned. It is made beside the next chunk's disk, as neither waits for the other.
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
    """The sound of the `waiting` samples before frame `stop`."""
    if waiting > 0:
        sound(f64, u64, 0, waiting)
        synthesize(f64, i64, out, stop - waiting, waiting, channels, trace, traced)


@inlined
def clear(f64, i64, u64):
    """Every state column and meter as new; coefficients, rings and surfaces stay."""
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
    f64[layout.GRAIN_GAIN] = 1.0
    u64[layout.NOISE] = u64[layout.S_SEED]


@inlined
def is_finite(f64):
    """Whether every recursive state column is a finite number."""
    # in pairs, so that few sums wait for others
    moved = (f64[layout.X] + f64[layout.V]) + (f64[layout.SMOOTH_1] + f64[layout.SMOOTH_2])
    felt = (f64[layout.ENVELOPE_1] + f64[layout.ENVELOPE_2]) + (
        f64[layout.FOLLOWER] + f64[layout.TACTOR_DC_OUT]
    )
    heard = (f64[layout.CLICK_DC_OUT] + f64[layout.TEXTURE]) + (
        f64[layout.PHASE] + f64[layout.BRISTLE]
    )
    total = (moved + felt) + (heard + f64[layout.M_IMPULSE])
    return total - total == 0.0


@inlined
def recover(f64, i64, u64, clock, out, start, stop):
    """After a block: a voice whose state isn't finite is as new, and its output zero."""
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
    """As new: state and meters cleared, glides and crossfades finished, waiting events dropped.

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
    """One block of audio.

    Parameters
    ----------
    f64, i64, u64 : float64, int64, uint64 [layout.TOTAL]
        The memory block, seen three ways.
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
    # the first chunk's disk and the last one's sound have nothing beside them
    step = STEP if frames > SHORT else SHORT_STEP
    n = 0
    waiting = 0
    first = i64[layout.CLOCK]
    while n < frames:
        apply_pending(f64, i64)
        stop = frames
        gliding = is_gliding(i64)
        if gliding:
            # it is a new constant every sample, and what waits goes with the last one
            synthesize_pending(f64, i64, u64, out, channels, n, waiting, trace, traced)
            waiting = 0
            gliding = glide_all(f64, i64) > 0
        if gliding:
            stop = n + 1
        else:
            due = next_event_time(i64) - first
            if due < stop:
                # an event pushed just now may be due already
                stop = due if due > n else n + 1
        waiting = run(f64, i64, u64, out, channels, n, stop, step, waiting, trace, traced)
        n = stop
    synthesize_pending(f64, i64, u64, out, channels, n, waiting, trace, traced)
    i64[layout.M_BLOCKS] += 1
    recover(f64, i64, u64, first + frames, out, 0, frames * channels)


@entry_point
def tactor_stage(f64, torque, out):
    """The tactor channel of a torque signal alone, as `process` makes it from rest.

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
