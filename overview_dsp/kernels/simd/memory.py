"""Memory of `SIMD_WIDTH` voices in lanes, one column per voice.

Between calls, the block of each voice (`layout.py`) holds its state. `load_lane` copies the columns
that change with each sample to the lanes, `store_lane` copies them back.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import SIMD_WIDTH

row = layout.Columns()
COEFFICIENTS = row(layout.COEFFS * SIMD_WIDTH)  # in the order of the voice's block
# state columns that the lanes' loops change
MOVED = (
    layout.APPROACH,
    layout.X,
    layout.V,
    layout.PACE,
    layout.WOUND,
    layout.SLIP,
    layout.WANTED,
    layout.SMOOTH_1,
    layout.SMOOTH_2,
    layout.FOLLOWER,
    layout.ENVELOPE_1,
    layout.ENVELOPE_2,
    layout.PHASE,
    layout.TACTOR_DC_IN,
    layout.TACTOR_DC_OUT,
    layout.TEXTURE_LEVEL,
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
STATE = row(len(MOVED) * SIMD_WIDTH)
INPUT = row(SIMD_WIDTH)
HOLD = row(SIMD_WIDTH)  # 1 while shaft 2 is engaged, else 0
SPRING = row(SIMD_WIDTH)
DENOMINATOR = row(SIMD_WIDTH)
PACING = row(SIMD_WIDTH)  # smoothing of the input's pace, 0 without an active input
REACH = row(SIMD_WIDTH)  # of the clutch while shaft 2 is engaged, else OFF
WINDUP = row(SIMD_WIDTH)
ARRIVAL_ABOVE = row(SIMD_WIDTH)
ARRIVAL_BELOW = row(SIMD_WIDTH)
GAIN_FROM = row(SIMD_WIDTH)
GAIN_STEP = row(SIMD_WIDTH)
TEXTURE_GAIN = row(SIMD_WIDTH)
BEYOND = row(SIMD_WIDTH)  # samples from the output gain's grid to the chunk's first
HIGHEST = row(SIMD_WIDTH)  # position in the last chunk, cells
LOWEST = row(SIMD_WIDTH)
TABLE = row(SIMD_WIDTH)  # i64: where the voice's friction table begins
DUE = row(SIMD_WIDTH)  # i64: sample of the voice's next control event
WANTED = row(SIMD_WIDTH)  # i64: 1 = the lane has a voice
MEMBER = row(SIMD_WIDTH)  # i64: 1 = the voice is processed in its lane
BEFORE = row(SIMD_WIDTH)  # position before the chunk, cells
ECHO = row(SIMD_WIDTH)  # i64: 1 = its RING columns are not all zero
LOUDEST_CLICK = row(SIMD_WIDTH)  # in the last chunk
LOUDEST_TACTOR = row(SIMD_WIDTH)
# between the stages: a row for each sample of a chunk
ROWS = layout.CHUNK * SIMD_WIDTH
TORQUE = row(ROWS)
OMEGA = row(ROWS)
PHASE = row(ROWS)
POSITION = row(ROWS)
APPROACH = row(ROWS)
AMPLITUDE = row(ROWS)  # then the envelope that follows it
SINE = row(ROWS)
TEXTURE_LEVEL = row(ROWS)
BRIGHTNESS = row(ROWS)
RING = row(ROWS)
CLICK = row(ROWS)
TACTOR = row(ROWS)
SPEED = row(ROWS)  # from here on for traces alone
THETA2 = row(ROWS)
FRICTION = row(ROWS)
SIZE = row.end
MEMORY = SIZE + SIMD_WIDTH * layout.TOTAL  # the lanes, then the voices' blocks


def of_state(column: int) -> int:
    """Return the lanes' offset of a state column."""
    return STATE + MOVED.index(column) * SIMD_WIDTH


def of_coefficient(column: int) -> int:
    """Return the lanes' offset of a coefficient."""
    return COEFFICIENTS + (column - layout.COEFF) * SIMD_WIDTH


@inlined
def start_of(lane):
    """Return the offset of the block of a lane's voice."""
    return SIZE + lane * layout.TOTAL


@inlined
def block(memory, lane):
    """Return the block of a lane's voice, in any of the memory's three views."""
    return memory[SIZE + lane * layout.TOTAL : SIZE + (lane + 1) * layout.TOTAL]


@inlined
def column(batch_f64, at, lane, frames):
    """Return a view of one lane in the rows from `at` on: one number per sample."""
    return batch_f64[at + lane : at + lane + frames * SIMD_WIDTH : SIMD_WIDTH]


@inlined
def load_lane(batch_f64, f64, lane):
    """Copy a voice's coefficients and state to its lane."""
    for i in range(layout.COEFFS):
        batch_f64[COEFFICIENTS + i * SIMD_WIDTH + lane] = f64[layout.COEFF + i]
    for i in range(len(MOVED)):
        batch_f64[STATE + i * SIMD_WIDTH + lane] = f64[MOVED[i]]


@inlined
def store_lane(batch_f64, f64, lane):
    """Copy a lane's state back to its voice."""
    for i in range(len(MOVED)):
        f64[MOVED[i]] = batch_f64[STATE + i * SIMD_WIDTH + lane]
