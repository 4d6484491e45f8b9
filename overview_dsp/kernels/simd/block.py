"""Block processing of several voices at once, with the results of `block.process` for each.

Voices with viscous friction only, and without changing parameters or surfaces, are processed
together in lanes. Their control events, strikes and modes are processed in
the block of each voice in between. Other voices, and very few voices, are processed one by one.

Thread: audio (offline: one that renders).
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.block import recover
from overview_dsp.kernels.clutch import OFF
from overview_dsp.kernels.compiling import NOT_NEGATIVE, entry_point, inlined, outlined
from overview_dsp.kernels.control_events import (
    apply_pending,
    is_gliding,
    is_pending,
    next_event_time,
)
from overview_dsp.kernels.event_crossing import FAR, event_above, event_below, pass_events
from overview_dsp.kernels.limiter import KNEE
from overview_dsp.kernels.modal_bank import ring
from overview_dsp.kernels.motion import write_trace
from overview_dsp.kernels.output import limit_column
from overview_dsp.kernels.output_gain import on_grid, set_gain
from overview_dsp.kernels.release import arrive, has_arrived
from overview_dsp.kernels.simd import memory as own
from overview_dsp.kernels.simd.memory import load_lane, start_of, store_lane
from overview_dsp.kernels.simd.stages import (
    PACE,
    SLIP,
    SMOOTH_1,
    SMOOTH_2,
    STILL,
    WANTED,
    WOUND,
    X,
    advance_disk_all,
    shape_all,
    sound_all,
    write_all,
)
from overview_dsp.kernels.simd.vector import SIMD_WIDTH, store

FEWEST = 4  # least number of voices for which lanes are faster, with vectors of four numbers
# columns that control events and releases change
INPUT_COLUMNS = (
    (layout.X, X),
    (layout.SMOOTH_1, SMOOTH_1),
    (layout.SMOOTH_2, SMOOTH_2),
    (layout.PACE, PACE),
    (layout.WOUND, WOUND),
    (layout.SLIP, SLIP),
    (layout.WANTED, WANTED),
    (layout.M_STILL, STILL),
)
TRACE_COLUMNS = (
    (layout.D_POSITION, own.POSITION),
    (layout.D_THETA2, own.THETA2),
    (layout.D_TORQUE, own.TORQUE),
    (layout.D_SPEED, own.SPEED),
    (layout.D_FRICTION, own.FRICTION),
)


@inlined
def is_plain(f64, i64):
    """Return whether a voice has only inputs and viscous friction in the next block."""
    if is_pending(i64, layout.HOST_READ, layout.HOST_WRITTEN) or i64[layout.FADE_LEFT] > 0:
        return False
    if i64[layout.S_CLICK_CHANNEL] != 0 or i64[layout.S_TACTOR_CHANNEL] != 1:
        return False
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    return not is_gliding(i64) and i64[slot + layout.SLOT_MODELS] == 0


@inlined
def load_input(batch_f64, f64, i64, lane):
    """Copy a voice's input and active springs to its lane."""
    engaged = i64[layout.ENGAGED] == 1
    spring = f64[layout.C_SPRING_HELD] if engaged else f64[layout.C_SPRING_FREE]
    batch_f64[own.INPUT + lane] = f64[layout.INPUT]
    held = i64[layout.HOLDER] >= 0
    batch_f64[own.PACING + lane] = f64[layout.C_PACE] if held else 0.0
    batch_f64[own.REACH + lane] = f64[layout.C_REACH] if engaged else OFF
    batch_f64[own.WINDUP + lane] = f64[layout.C_WINDUP] if engaged else OFF
    batch_f64[own.HOLD + lane] = 1.0 if engaged else 0.0
    batch_f64[own.SPRING + lane] = spring
    batch_f64[own.DENOMINATOR + lane] = f64[layout.C_INERTIA] * (2.0 + 0.5 * spring)
    batch_f64[own.ARRIVAL_ABOVE + lane] = f64[layout.ARRIVAL_ABOVE]
    batch_f64[own.ARRIVAL_BELOW + lane] = f64[layout.ARRIVAL_BELOW]


@inlined
def load_gain(batch_f64, f64, lane):
    """Copy a voice's output gain to its lane."""
    batch_f64[own.GAIN_FROM + lane] = f64[layout.GAIN_FROM]
    batch_f64[own.GAIN_STEP + lane] = f64[layout.GAIN_STEP]
    batch_f64[own.TEXTURE_GAIN + lane] = f64[layout.TEXTURE_GAIN]


@outlined
def apply_controls(batch_f64, f64, i64, lane):
    """Apply a voice's due control events and its arrival after a release."""
    for i in range(len(INPUT_COLUMNS)):
        f64[INPUT_COLUMNS[i][0]] = batch_f64[INPUT_COLUMNS[i][1] + lane]
    if has_arrived(f64):
        arrive(f64, i64)
    apply_pending(f64, i64)
    for i in range(len(INPUT_COLUMNS)):
        batch_f64[INPUT_COLUMNS[i][1] + lane] = f64[INPUT_COLUMNS[i][0]]
    load_input(batch_f64, f64, i64, lane)


@inlined
def renew_gain(batch_f64, f64, i64, lane):
    """Set a voice's output gain at a sample of its grid."""
    f64[layout.X] = batch_f64[X + lane]
    f64[layout.PACE] = batch_f64[PACE + lane]
    set_gain(f64, i64)
    load_gain(batch_f64, f64, lane)


@inlined
def copy(from_, to):
    """Copy `from_` to `to`, which has the same length."""
    for n in range(len(to)):
        to[n] = from_[n]


@outlined
def pass_all(batch_f64, f64, i64, lane, frames):
    """Strike all events that a voice passed in a chunk."""
    before = batch_f64[own.BEFORE + lane]
    above = event_above(f64, i64)
    below = event_below(f64, i64)
    positions = own.column(batch_f64, own.POSITION, lane, frames)
    for n in range(frames):
        x = positions[n]
        if x >= above or x < below:
            f64[layout.X] = x
            f64[layout.APPROACH] = batch_f64[own.APPROACH + n * SIMD_WIDTH + lane]
            f64[layout.D_OMEGA + n] = batch_f64[own.OMEGA + n * SIMD_WIDTH + lane]
            pass_events(f64, i64, n, before)
            above = event_above(f64, i64)
            below = event_below(f64, i64)
        before = x


@outlined
def strike_lane(batch_f64, batch_i64, lane, frames):
    """Strike a voice's passed events and write its ringing modes to its lane."""
    f64 = own.block(batch_f64, lane)
    i64 = own.block(batch_i64, lane)
    if batch_f64[own.HIGHEST + lane] >= event_above(f64, i64) or batch_f64[
        own.LOWEST + lane
    ] < event_below(f64, i64):
        pass_all(batch_f64, f64, i64, lane, frames)
    last = layout.STRIKES_SOUNDED + layout.CONTACT - 1
    if i64[layout.RINGING] > 0 or i64[last] < i64[layout.M_STRIKES]:
        ring(f64, i64, frames)
        copy(
            f64[layout.D_RING : layout.D_RING + frames],
            own.column(batch_f64, own.RING, lane, frames),
        )
        batch_i64[own.ECHO + lane] = 1
    elif batch_i64[own.ECHO + lane] == 1:
        for n in range(layout.CHUNK):
            batch_f64[own.RING + n * SIMD_WIDTH + (lane & NOT_NEGATIVE)] = 0.0
        batch_i64[own.ECHO + lane] = 0


@outlined
def bend_lane(batch_f64, batch_i64, lane, frames):
    """Limit a voice's signals to the ceiling and update its meters."""
    f64 = own.block(batch_f64, lane)
    i64 = own.block(batch_i64, lane)
    ceiling = f64[layout.C_CEILING]
    for at, to, loudest in (
        (own.CLICK, layout.D_CLICK, own.LOUDEST_CLICK),
        (own.TACTOR, layout.D_TACTOR, own.LOUDEST_TACTOR),
    ):
        if batch_f64[loudest + lane] > KNEE * ceiling:
            copy(own.column(batch_f64, at, lane, frames), f64[to : to + frames])
            peak, limited = limit_column(f64, i64, to, frames, ceiling)
            copy(f64[to : to + frames], own.column(batch_f64, at, lane, frames))
            batch_f64[loudest + lane] = peak
            i64[layout.M_LIMITED] += limited


@outlined
def trace_lane(batch_f64, batch_i64, lane, frames, trace, at):
    """Write a voice's trace of a chunk without its envelope, from index `at` on."""
    f64 = own.block(batch_f64, lane)
    for i in range(len(TRACE_COLUMNS)):
        to, column = TRACE_COLUMNS[i]
        copy(own.column(batch_f64, column, lane, frames), f64[to : to + frames])
    i64 = own.block(batch_i64, lane)
    for n in range(frames):
        f64[layout.D_ENGAGED + n] = float(i64[layout.ENGAGED])
    write_trace(f64, i64, frames, trace, at)


@outlined
def trace_envelope(batch_f64, lane, frames, trace, at):
    """Write a voice's envelope of a chunk to its trace, from index `at` on."""
    rows = trace[at + 8 : at + frames * layout.TRACE : layout.TRACE]
    copy(own.column(batch_f64, own.AMPLITUDE, lane, frames), rows)


@inlined
def run_all(batch_f64, batch_i64, batch_u64, count, out, block, start, frames, trace, traced):
    """Process up to `frames` frames of a block without control events, from frame `start` on.

    Returns the number of frames; it stops where a disk arrives after a release. Each stage has a
    loop of its own: in one loop they would have too few registers.
    """
    for lane in range(count):
        batch_f64[own.BEFORE + lane] = batch_f64[X + lane]
    frames = advance_disk_all(batch_f64, batch_i64, frames, traced)
    for lane in range(count):
        if batch_i64[own.MEMBER + lane] == 1:
            strike_lane(batch_f64, batch_i64, lane, frames)
            if traced:
                at = (lane * block + start) * layout.TRACE
                trace_lane(batch_f64, batch_i64, lane, frames, trace, at)
            batch_i64[start_of(lane) + layout.CLOCK] += frames
    shape_all(batch_f64, frames)
    sound_all(batch_f64, batch_u64, frames)
    for lane in range(count):
        if batch_i64[own.MEMBER + lane] == 1:
            bend_lane(batch_f64, batch_i64, lane, frames)
            if traced:
                at = (lane * block + start) * layout.TRACE
                trace_envelope(batch_f64, lane, frames, trace, at)
    write_all(batch_f64, out, start * layout.SIGNALS, block * layout.SIGNALS, frames)
    return frames


@inlined
def join(batch_f64, batch_i64, lane):
    """Load a voice into its lane for the next block."""
    f64 = own.block(batch_f64, lane)
    i64 = own.block(batch_i64, lane)
    f64[layout.M_PEAK_CLICK] = 0.0
    f64[layout.M_PEAK_TACTOR] = 0.0
    load_lane(batch_f64, f64, lane)
    load_input(batch_f64, f64, i64, lane)
    load_gain(batch_f64, f64, lane)
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    batch_i64[own.TABLE + lane] = start_of(lane) + slot + layout.SLOT_TABLE
    batch_i64[own.DUE + lane] = next_event_time(i64)


@inlined
def leave(batch_f64, batch_i64, batch_u64, lane, out, frames):
    """Store a voice's lane in its block and finish the block."""
    f64 = own.block(batch_f64, lane)
    i64 = own.block(batch_i64, lane)
    store_lane(batch_f64, f64, lane)
    if has_arrived(f64):
        arrive(f64, i64)
    i64[layout.M_SUMMED] += frames
    i64[layout.M_BLOCKS] += 1
    first = lane * frames * layout.SIGNALS
    clock = i64[layout.CLOCK]
    recover(
        f64, i64, own.block(batch_u64, lane), clock, out, first, first + frames * layout.SIGNALS
    )


@inlined
def next_stop(batch_f64, batch_i64, count, n, stop):
    """Apply the events due at frame `n` of the block; return the frame of the next events."""
    for lane in range(count):
        if batch_i64[own.MEMBER + lane] == 1:
            now = batch_i64[start_of(lane) + layout.CLOCK]
            f64 = own.block(batch_f64, lane)
            i64 = own.block(batch_i64, lane)
            x = batch_f64[X + lane]
            arrived = (
                x >= batch_f64[own.ARRIVAL_ABOVE + lane] or x < batch_f64[own.ARRIVAL_BELOW + lane]
            )
            if batch_i64[own.DUE + lane] <= now or arrived:
                apply_controls(batch_f64, f64, i64, lane)
                batch_i64[own.DUE + lane] = next_event_time(i64)
            beyond = on_grid(i64)
            if beyond == 0:
                renew_gain(batch_f64, f64, i64, lane)
            batch_f64[own.BEYOND + lane] = float(beyond)
            stop = min(stop, n + layout.GAIN_GRID - beyond)
            # a new event that is already due waits for one sample, as for single voices
            left = max(1, batch_i64[own.DUE + lane] - now)
            stop = min(stop, n + left)
    return stop


@entry_point
def process_lanes(batch_f64, batch_i64, batch_u64, count, out, frames, trace, traced):
    """Process a block of the voices whose WANTED column is 1, bit-identical to `block.process`.

    The MEMBER columns are 1 for processed voices. Those with 0 must be
    processed one by one.

    Parameters
    ----------
    batch_f64, batch_i64, batch_u64 : float64, int64, uint64 [simd.memory.MEMORY]
        Memory of lanes and voices in three views.
    count : int64
        Number of lanes: SIMD_WIDTH, but not as a constant, for which the
        compiler would unroll all loops.
    out : float32 [SIMD_WIDTH * frames * 2]
        Click and tactor of each lane, overwritten; undefined for other lanes.
    frames : int64
    trace : float64 [SIMD_WIDTH * frames * layout.TRACE] or of any length
        Overwritten if `traced`.
    traced : bool

    Thread: one that renders. Never allocates, locks or raises.
    """
    members = 0
    for lane in range(count):
        in_use = batch_i64[own.WANTED + lane] == 1
        plain = in_use and is_plain(own.block(batch_f64, lane), own.block(batch_i64, lane))
        batch_i64[own.MEMBER + lane] = 1 if plain else 0
        members += batch_i64[own.MEMBER + lane]
    store(batch_f64, own.ARRIVAL_ABOVE, FAR)  # of lanes without a voice, too
    store(batch_f64, own.ARRIVAL_BELOW, -FAR)
    for lane in range(count):
        if members < FEWEST:
            batch_i64[own.MEMBER + lane] = 0
        elif batch_i64[own.MEMBER + lane] == 1:
            join(batch_f64, batch_i64, lane)
    if members < FEWEST:
        return
    n = 0
    while n < frames:
        stop = next_stop(batch_f64, batch_i64, count, n, min(frames, n + layout.CHUNK))
        n += run_all(
            batch_f64, batch_i64, batch_u64, count, out, frames, n, stop - n, trace, traced
        )
    for lane in range(count):
        if batch_i64[own.MEMBER + lane] == 1:
            leave(batch_f64, batch_i64, batch_u64, lane, out, frames)
