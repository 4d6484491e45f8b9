"""The block driver for voices side by side: what `block.process` does to each, for all at once.

A voice with viscous friction alone, and no parameter or surface on its way, goes with the others
through the lanes' loops; what happens to it alone (control events, strikes, its modes) is done to
its own block between them. Any other voice, and fewer than pay, are left to be processed alone.

Thread: audio (offline: one that renders).
"""

from __future__ import annotations

from overview_dsp.kernels import lane_memory as own
from overview_dsp.kernels import layout
from overview_dsp.kernels.block import recover
from overview_dsp.kernels.compiling import NOT_NEGATIVE, entry, point, routine
from overview_dsp.kernels.control import apply_due, next_due
from overview_dsp.kernels.lane_memory import put_back, start_of, take_in
from overview_dsp.kernels.lane_stages import (
    SMOOTH_1,
    SMOOTH_2,
    X,
    shape_all,
    sound_all,
    travel_all,
    write_all,
)
from overview_dsp.kernels.lanes import LANES
from overview_dsp.kernels.limiter import KNEE
from overview_dsp.kernels.motion import write_trace
from overview_dsp.kernels.output import limit_column
from overview_dsp.kernels.passing import event_above, event_below, pass_events
from overview_dsp.kernels.ringing import ring

FEWEST = 4  # voices for which the lanes' loops pay, with vectors of four numbers
CHANNELS = 2
TRACE_COLUMNS = (
    (layout.D_PLACE, own.PLACE),
    (layout.D_THETA2, own.THETA2),
    (layout.D_TORQUE, own.TORQUE),
    (layout.D_SPEED, own.SPEED),
    (layout.D_FRICTION, own.FRICTION),
)


@point
def is_plain(m, w):
    """Whether nothing but hands moves a voice in the next block, over viscous friction alone."""
    if w[layout.HOST_READ] < w[layout.HOST_WRITTEN] or w[layout.FADE_LEFT] > 0:
        return False
    if w[layout.S_CLICK_CHANNEL] != 0 or w[layout.S_TACTOR_CHANNEL] != 1:
        return False
    gliding = 0
    for i in range(layout.COEFFS):
        gliding |= w[layout.GLIDE_LEFT + i]
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    return gliding == 0 and w[slot + layout.SLOT_MODELS] == 0


@point
def take_hand(b, m, w, lane):
    """A voice's hand, and the springs that act, into its lane."""
    held = w[layout.TOUCHING] == 1
    spring = m[layout.C_SPRING_HELD] if held else m[layout.C_SPRING_FREE]
    b[own.INPUT + lane] = m[layout.INPUT]
    b[own.HOLD + lane] = 1.0 if held else 0.0
    b[own.SPRING + lane] = spring
    b[own.DENOMINATOR + lane] = m[layout.C_INERTIA] * (2.0 + 0.5 * spring)


@routine
def obey(b, m, w, lane):
    """Apply a voice's control events that are due."""
    m[layout.SMOOTH_1] = b[SMOOTH_1 + lane]
    m[layout.SMOOTH_2] = b[SMOOTH_2 + lane]
    apply_due(m, w)
    b[SMOOTH_1 + lane] = m[layout.SMOOTH_1]
    b[SMOOTH_2 + lane] = m[layout.SMOOTH_2]
    take_hand(b, m, w, lane)


@point
def copy(from_, to):
    """Every number of `from_` into `to`, which is as long."""
    for n in range(len(to)):
        to[n] = from_[n]


@routine
def pass_all(b, m, w, lane, frames):
    """Strike the events that a voice passed in a chunk."""
    before = b[own.BEFORE + lane]
    above = event_above(m, w)
    below = event_below(m, w)
    places = own.column(b, own.PLACE, lane, frames)
    for n in range(frames):
        x = places[n]
        if x >= above or x < below:
            m[layout.X] = x
            m[layout.APPROACH] = b[own.APPROACH + n * LANES + lane]
            m[layout.D_OMEGA + n] = b[own.OMEGA + n * LANES + lane]
            pass_events(m, w, n, before)
            above = event_above(m, w)
            below = event_below(m, w)
        before = x


@routine
def strike_lane(b, wb, lane, frames):
    """A voice's events that were passed in a chunk, and its modes, into its lane."""
    m = own.block(b, lane)
    w = own.block(wb, lane)
    if b[own.HIGHEST + lane] >= event_above(m, w) or b[own.LOWEST + lane] < event_below(m, w):
        pass_all(b, m, w, lane, frames)
    last = layout.STRIKES_SOUNDED + layout.CONTACT - 1
    if w[layout.RINGING] > 0 or w[last] < w[layout.M_STRIKES]:
        ring(m, w, frames)
        copy(m[layout.D_RING : layout.D_RING + frames], own.column(b, own.RING, lane, frames))
        wb[own.ECHO + lane] = 1
    elif wb[own.ECHO + lane] == 1:
        for n in range(layout.CHUNK):
            b[own.RING + n * LANES + (lane & NOT_NEGATIVE)] = 0.0
        wb[own.ECHO + lane] = 0


@routine
def bend_lane(b, wb, lane, frames):
    """Hold what is over the ceiling's knee under the ceiling, and meter it."""
    m = own.block(b, lane)
    w = own.block(wb, lane)
    ceiling = m[layout.C_CEILING]
    for at, to, loudest in (
        (own.CLICK, layout.D_CLICK, own.LOUDEST_CLICK),
        (own.TACTOR, layout.D_TACTOR, own.LOUDEST_TACTOR),
    ):
        if b[loudest + lane] > KNEE * ceiling:
            copy(own.column(b, at, lane, frames), m[to : to + frames])
            peak, limited = limit_column(m, w, to, frames, ceiling)
            copy(m[to : to + frames], own.column(b, at, lane, frames))
            b[loudest + lane] = peak
            w[layout.M_LIMITED] += limited


@routine
def trace_lane(b, wb, lane, frames, trace, at):
    """A voice's trace of a chunk, from index `at` on."""
    m = own.block(b, lane)
    for i in range(len(TRACE_COLUMNS)):
        to, column = TRACE_COLUMNS[i]
        copy(own.column(b, column, lane, frames), m[to : to + frames])
    write_trace(m, own.block(wb, lane), frames, trace, at)
    rows = trace[at + 8 : at + frames * layout.TRACE : layout.TRACE]
    copy(own.column(b, own.ENVELOPE, lane, frames), rows)


@point
def run_all(b, wb, ub, count, out, block, start, frames, trace, traced):
    """`frames` from frame `start` of a block of `block`, in which no voice has an event due."""
    for lane in range(count):
        b[own.BEFORE + lane] = b[X + lane]
    travel_all(b, wb, frames, traced)
    for lane in range(count):
        if wb[own.MEMBER + lane] == 1:
            strike_lane(b, wb, lane, frames)
    shape_all(b, frames)
    sound_all(b, ub, frames, traced)
    for lane in range(count):
        if wb[own.MEMBER + lane] == 1:
            bend_lane(b, wb, lane, frames)
            if traced:
                trace_lane(b, wb, lane, frames, trace, (lane * block + start) * layout.TRACE)
            wb[start_of(lane) + layout.CLOCK] += frames
    write_all(b, out, start * CHANNELS, block * CHANNELS, frames)


@point
def join(b, wb, lane):
    """A voice goes with the others through the next block."""
    m = own.block(b, lane)
    w = own.block(wb, lane)
    m[layout.M_PEAK_CLICK] = 0.0
    m[layout.M_PEAK_TACTOR] = 0.0
    take_in(b, m, lane)
    take_hand(b, m, w, lane)
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    wb[own.TABLE + lane] = start_of(lane) + slot + layout.SLOT_TABLE
    wb[own.DUE + lane] = next_due(w)


@point
def leave(b, wb, ub, lane, out, frames):
    """A voice has its block's end to itself again."""
    m = own.block(b, lane)
    w = own.block(wb, lane)
    put_back(b, m, lane)
    w[layout.M_SUMMED] += frames
    w[layout.M_BLOCKS] += 1
    first = lane * frames * CHANNELS
    clock = w[layout.CLOCK]
    recover(m, w, own.block(ub, lane), clock, out, first, first + frames * CHANNELS)


@point
def next_stop(b, wb, count, n, stop):
    """Apply what is due at frame `n` of the block; the frame up to which nothing else is."""
    for lane in range(count):
        if wb[own.MEMBER + lane] == 1:
            now = wb[start_of(lane) + layout.CLOCK]
            if wb[own.DUE + lane] <= now:
                w = own.block(wb, lane)
                obey(b, own.block(b, lane), w, lane)
                wb[own.DUE + lane] = next_due(w)
            # what is due already waits for a sample, as it does alone
            left = max(1, wb[own.DUE + lane] - now)
            stop = min(stop, n + left)
    return stop


@entry
def process_lanes(b, wb, ub, count, out, frames, trace, traced):
    """A block of the voices whose WANTED column is 1; each gets the bits of `block.process`.

    What it did for which voice is in the MEMBER columns: those it left at 0 are still to be
    processed alone.

    Parameters
    ----------
    b, wb, ub : float64, int64, uint64 [lane_memory.MEMORY]
        The lanes' memory and the voices' own, seen three ways.
    count : int64
        The lanes to look at, the first of all: LANES, but not as a constant, of which the compiler
        would make as many copies of everything.
    out : float32 [LANES * frames * 2]
        Each lane's click and tactor, overwritten; those of other lanes hold nothing of use.
    frames : int64
    trace : float64 [LANES * frames * layout.TRACE] or of any length
        Overwritten if `traced`.
    traced : bool

    Thread: one that renders. Never allocates, locks or raises.
    """
    members = 0
    for lane in range(count):
        wanted = wb[own.WANTED + lane] == 1
        plain = wanted and is_plain(own.block(b, lane), own.block(wb, lane))
        wb[own.MEMBER + lane] = 1 if plain else 0
        members += wb[own.MEMBER + lane]
    for lane in range(count):
        if members < FEWEST:
            wb[own.MEMBER + lane] = 0
        elif wb[own.MEMBER + lane] == 1:
            join(b, wb, lane)
    if members < FEWEST:
        return
    n = 0
    while n < frames:
        stop = next_stop(b, wb, count, n, min(frames, n + layout.CHUNK))
        run_all(b, wb, ub, count, out, frames, n, stop - n, trace, traced)
        n = stop
    for lane in range(count):
        if wb[own.MEMBER + lane] == 1:
            leave(b, wb, ub, lane, out, frames)
