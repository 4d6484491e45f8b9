"""The working memory of `SIMD_WIDTH` voices side by side, one column wide each.

A voice's own block (`layout.py`) is the truth between calls. `take_in` copies what changes from
sample to sample into the lanes, `put_back` returns it.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import SIMD_WIDTH

COEFFICIENTS = 0  # all of a voice's own, in their order
STATE = COEFFICIENTS + layout.COEFFS * SIMD_WIDTH
# what the lanes' loops change in the state; the rest of it stays with the voice
MOVED = (
    layout.APPROACH,
    layout.X,
    layout.V,
    layout.PACE,
    layout.SMOOTH_1,
    layout.SMOOTH_2,
    layout.FOLLOWER,
    layout.ENVELOPE_1,
    layout.ENVELOPE_2,
    layout.PHASE,
    layout.TACTOR_DC_IN,
    layout.TACTOR_DC_OUT,
    layout.GRAIN,
    layout.TEXTURE,
    layout.CLICK_DC_IN,
    layout.CLICK_DC_OUT,
    layout.NOISE,
    layout.M_IMPULSE,
    layout.M_STILL,
    layout.M_SILENT,
    layout.M_TORQUE,
    layout.M_FRICTION,
    layout.M_ENVELOPE,
    layout.M_PEAK_CLICK,
    layout.M_PEAK_TACTOR,
)
INPUT = STATE + len(MOVED) * SIMD_WIDTH
HOLD = INPUT + SIMD_WIDTH  # 1 while shaft 2 is engaged, else 0
SPRING = HOLD + SIMD_WIDTH
DENOMINATOR = SPRING + SIMD_WIDTH
PACING = DENOMINATOR + SIMD_WIDTH  # smoothing of the hand's pace, 0 where nobody holds the disk
CATCH = PACING + SIMD_WIDTH  # the clutch's reach where shaft 2 is engaged, else without end
HIGHEST = CATCH + SIMD_WIDTH  # position in the last chunk, cells
LOWEST = HIGHEST + SIMD_WIDTH
TABLE = LOWEST + SIMD_WIDTH  # i64: where the voice's friction table begins
DUE = TABLE + SIMD_WIDTH  # i64: sample of the voice's next control event
WANTED = DUE + SIMD_WIDTH  # i64: 1 = the lane has a voice
MEMBER = WANTED + SIMD_WIDTH  # i64: 1 = which goes with the others
BEFORE = MEMBER + SIMD_WIDTH  # position before the chunk, cells
ECHO = BEFORE + SIMD_WIDTH  # i64: 1 = its RING columns are not all zero
LOUDEST_CLICK = ECHO + SIMD_WIDTH  # in the last chunk
LOUDEST_TACTOR = LOUDEST_CLICK + SIMD_WIDTH
# between the stages: a row for each sample of a chunk
ROWS = layout.CHUNK * SIMD_WIDTH
TORQUE = LOUDEST_TACTOR + SIMD_WIDTH
OMEGA = TORQUE + ROWS
PHASE = OMEGA + ROWS
POSITION = PHASE + ROWS
APPROACH = POSITION + ROWS
AMPLITUDE = APPROACH + ROWS
SINE = AMPLITUDE + ROWS
GRAIN = SINE + ROWS
COLOUR = GRAIN + ROWS
RING = COLOUR + ROWS
CLICK = RING + ROWS
TACTOR = CLICK + ROWS
SPEED = TACTOR + ROWS  # from here on for traces alone
THETA2 = SPEED + ROWS
FRICTION = THETA2 + ROWS
ENVELOPE = FRICTION + ROWS
SIZE = ENVELOPE + ROWS
MEMORY = SIZE + SIMD_WIDTH * layout.TOTAL  # the lanes' own, then the voices' blocks


def of_state(column: int) -> int:
    """Where the lanes keep a column of the voices' state."""
    return STATE + MOVED.index(column) * SIMD_WIDTH


def of_coefficient(column: int) -> int:
    """Where the lanes keep a coefficient of the voices."""
    return COEFFICIENTS + (column - layout.COEFF) * SIMD_WIDTH


@inlined
def start_of(lane):
    """Where a lane's voice has its own block."""
    return SIZE + lane * layout.TOTAL


@inlined
def block(memory, lane):
    """A voice's own block, of any of the memory's three views."""
    return memory[SIZE + lane * layout.TOTAL : SIZE + (lane + 1) * layout.TOTAL]


@inlined
def column(batch_f64, at, lane, frames):
    """One lane of the rows from `at` on: a view of one number for each of `frames` samples."""
    return batch_f64[at + lane : at + lane + frames * SIMD_WIDTH : SIMD_WIDTH]


@inlined
def take_in(batch_f64, f64, lane):
    """Copy a voice's coefficients and state into its lane."""
    for i in range(layout.COEFFS):
        batch_f64[COEFFICIENTS + i * SIMD_WIDTH + lane] = f64[layout.COEFF + i]
    for i in range(len(MOVED)):
        batch_f64[STATE + i * SIMD_WIDTH + lane] = f64[MOVED[i]]


@inlined
def put_back(batch_f64, f64, lane):
    """Return a lane's state to its voice."""
    for i in range(len(MOVED)):
        f64[MOVED[i]] = batch_f64[STATE + i * SIMD_WIDTH + lane]
