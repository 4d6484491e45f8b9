"""The working memory of voices side by side: each column is `LANES` wide, a voice's number in each.

A voice's own block (`layout.py`) is the truth between calls. `take_in` copies what changes from
sample to sample into the lanes, `put_back` returns it.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.lanes import LANES

COEFFICIENTS = 0  # all of a voice's own, in their order
STATE = COEFFICIENTS + layout.COEFFS * LANES
# what the lanes' loops change in the state; the rest of it stays with the voice
MOVED = (
    layout.APPROACH,
    layout.X,
    layout.V,
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
INPUT = STATE + len(MOVED) * LANES
HOLD = INPUT + LANES  # 1 while shaft 2 is engaged, else 0
SPRING = HOLD + LANES
DENOMINATOR = SPRING + LANES
HIGHEST = DENOMINATOR + LANES  # place in the last chunk, cells
LOWEST = HIGHEST + LANES
TABLE = LOWEST + LANES  # w: where the voice's friction table begins
DUE = TABLE + LANES  # w: sample of the voice's next control event
WANTED = DUE + LANES  # w: 1 = the lane has a voice
MEMBER = WANTED + LANES  # w: 1 = which goes with the others
BEFORE = MEMBER + LANES  # place before the chunk, cells
ECHO = BEFORE + LANES  # w: 1 = its RING columns are not all zero
LOUDEST_CLICK = ECHO + LANES  # in the last chunk
LOUDEST_TACTOR = LOUDEST_CLICK + LANES
# between the stages: a row for each sample of a chunk
ROWS = layout.CHUNK * LANES
TORQUE = LOUDEST_TACTOR + LANES
OMEGA = TORQUE + ROWS
PHASE = OMEGA + ROWS
PLACE = PHASE + ROWS
APPROACH = PLACE + ROWS
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
MEMORY = SIZE + LANES * layout.TOTAL  # the lanes' own, then the voices' blocks


def of_state(column: int) -> int:
    """Where the lanes keep a column of the voices' state."""
    return STATE + MOVED.index(column) * LANES


def of_coefficient(column: int) -> int:
    """Where the lanes keep a coefficient of the voices."""
    return COEFFICIENTS + (column - layout.COEFF) * LANES


@point
def start_of(lane):
    """Where a lane's voice has its own block."""
    return SIZE + lane * layout.TOTAL


@point
def block(memory, lane):
    """A voice's own block, of any of the memory's three views."""
    return memory[SIZE + lane * layout.TOTAL : SIZE + (lane + 1) * layout.TOTAL]


@point
def column(b, at, lane, frames):
    """One lane of the rows from `at` on: a view of one number for each of `frames` samples."""
    return b[at + lane : at + lane + frames * LANES : LANES]


@point
def take_in(b, m, lane):
    """Copy a voice's coefficients and state into its lane."""
    for i in range(layout.COEFFS):
        b[COEFFICIENTS + i * LANES + lane] = m[layout.COEFF + i]
    for i in range(len(MOVED)):
        b[STATE + i * LANES + lane] = m[MOVED[i]]


@point
def put_back(b, m, lane):
    """Return a lane's state to its voice."""
    for i in range(len(MOVED)):
        m[MOVED[i]] = b[STATE + i * LANES + lane]
