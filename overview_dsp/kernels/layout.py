"""Memory layout: offsets of coefficients, state, rings, meters and surface slots in one block.

The block has `TOTAL` 8-byte-aligned float64 columns with three views: `f64` (float64),
`i64` (int64: counters, indices, times) and `u64` (uint64: random state). It is the engine's memory
offline, PortAudio's user data live and the heap image in the browser, so every offset is a
compile-time constant. `reset` (in `block.py`) writes every column between `STATE` and
`TOTAL_STATE`; coefficients, rings and surface slots survive it.

Units: the disk's angle is kept as a position on the surface table (cells, 0 to `CELLS` for the
whole timeline) and its speed in cells per sample, so that the angle is the table's index.
"""

from __future__ import annotations


class Columns:
    """Allocator of consecutive columns: `columns(size)` returns the first of the next `size`."""

    def __init__(self) -> None:
        self.end = 0  # number of columns allocated

    def __call__(self, size: int) -> int:
        """Allocate `size` columns and return the first."""
        start = self.end
        self.end += size
        return start


# --- capacities -----------------------------------------------------------------------------
# Surface table: cells of the whole half turn, CELLS + 1 points. At 16384 the kinks of the linear
# interpolation, met at 2 cells per sample in a tap, cost the disk 2e-4 rad; here they don't count.
CELLS = 65536
STEEP_BLOCK = 32  # cells (a power of two) that share a mark of how B is found there
MAX_EVENTS = 16384  # of a slot
MAX_KINDS = 32  # event kinds with clicks of their own
BANKS = MAX_KINDS + 1  # clicks: of each kind, and of the base surface (the last)
MAX_MODES = 6  # modal resonators of a kind
PHASES = 8  # samples of a mode that are turned side by side: as many as there are lanes
SOURCES = 6  # touch, twist, serial, OSC, MIDI, remote: this order settles ties
RING = 4096  # control events waiting, per source (a power of two)
HOST_RING = 1024  # parameter and surface events waiting
CONTACT = 8  # pulses of one strike
STRIKE_LOG = 16384  # strikes kept until they are read
APPLIED_LOG = 16384  # control events kept, as applied, until they are read (a power of two)
DELAY_LINE = 131072  # frames of the outputs' delay: 100 ms at the highest rate (a power of two)
SLOTS = 3  # surfaces: active, fading from, being written
COEFFS = 36
GAIN_GRID = 64  # samples between two values of the output gains (a power of two)
CHUNK = 64  # samples that pass from one stage to the next at a time
SIGNALS = 2
CLICK, TACTOR = range(SIGNALS)  # the order of the signals

# --- coefficients that glide (float64), see derive.py ------------------------------------------
column = Columns()
COEFF = column(COEFFS)
(
    C_SPRING_HELD,  # (k1 + k2) / J * dt**2, cells per sample**2 a cell
    C_SPRING_FREE,  # k1 / J * dt**2
    C_INERTIA,  # J / dt, N m s/rad
    C_THETA,  # cells -> theta1, rad
    C_OMEGA,  # cells per sample -> omega1, rad/s
    C_SMOOTH,  # the input smoother's one-pole coefficient
    C_TORQUE,  # 1 / the tactor's full torque, rad/(N m)
    C_GATE,  # torque below which nothing vibrates, of the full torque
    C_EXPONENT,  # the tactor's compression
    C_DECAY,  # the envelope's fall, per sample
    C_RISE,  # the envelope's rise, per sample
    C_CARRIER,  # carrier turns per sample
    C_TACTOR_GAIN,
    C_CLICK_GAIN,
    C_STRIKE_TORQUE,  # 1 / the torque of a full strike
    C_STRIKE_EXPONENT,
    C_TEXTURE_GAIN,
    C_TEXTURE_CUTOFF,  # one-pole coefficient per rad/s of omega1
    C_CEILING,
    C_DC_POLE,
    C_TEXTURE_LEVEL,  # the texture's level smoothing, per sample
    C_FORGET,  # decay of the disk's approach speed per sample
    C_SPEED_RATIO,  # clutch: highest speed of the disk, relative to the input's pace
    C_REACH,  # clutch: stretch at a speed and a friction of 1, cells; clutch.OFF = rigid shaft
    C_TAP_RATE,  # clutch: least part of the stretch that is covered per sample
    C_LAG_RATE,  # clutch: part of the lag that is recovered per sample
    C_WINDUP,  # clutch: growth of the stretch, relative to the input's pace
    C_MAX_SPEED,  # clutch: highest speed of the disk, cells per sample
    C_BACKLASH,  # clutch: play between input and shaft, cells
    C_PACE,  # smoothing of the input's pace, per sample
    C_PACE_LEAST,  # slower inputs are at rest, cells per sample
    C_PACE_MOST,  # faster inputs are jumps, cells per sample
    C_SLOW_EXPONENT,  # output gain of slow inputs
    C_RECOIL_EXPONENT,  # output gain of the recoil
) = range(COEFF, COEFF + 34)
TARGET = column(COEFFS)
GLIDE_FROM = column(COEFFS)
GLIDE_LEFT = column(COEFFS)  # i64: samples left of each glide
SETTINGS = column(8)

# --- settings that don't glide (w) -----------------------------------------------------------
(
    S_GLIDE,  # i64: samples of a parameter's glide
    S_FADE,  # i64: samples of a surface's crossfade
    S_RELEASE_RETURNS,  # i64: 1 = shaft 2 stays on release and theta2 falls to 0
    S_CLICK_CHANNEL,  # i64: output channel of the clicks, -1 = none
    S_TACTOR_CHANNEL,  # i64: output channel of the tactor, -1 = none
    S_SEED,  # u64: random state at reset
    S_SAMPLE_RATE,  # Hz
    S_ARRIVAL,  # i64: samples that shaft 2 stays after a release at most
) = range(SETTINGS, SETTINGS + 8)

# --- parameters, from which derive.py makes coefficients -----------------------------------------
PARAMETERS = 28
PARAMS = column(32)
(  # each is named after its parameter's id, and in its unit
    PARAM_DISK_INERTIA,
    PARAM_DISK_K1,
    PARAM_DISK_K2,
    PARAM_DISK_RELEASE,  # 0 = recoil, 1 = return
    PARAM_CLUTCH_MAX_SPEED_RATIO,
    PARAM_CLUTCH_TAP_DURATION_S,
    PARAM_CLUTCH_TIME_CONSTANT_S,
    PARAM_CLUTCH_WINDUP_RATIO,
    PARAM_CLUTCH_MAX_SPEED,
    PARAM_CLUTCH_BACKLASH_PERCENT,
    PARAM_INPUT_SMOOTHING_MS,
    PARAM_TACTOR_REFERENCE_TORQUE_MNM,
    PARAM_TACTOR_COMPRESSION,
    PARAM_TACTOR_THRESHOLD_DB,
    PARAM_TACTOR_RISE_MS,
    PARAM_TACTOR_DECAY_MS,
    PARAM_TACTOR_FREQUENCY_HZ,
    PARAM_TACTOR_GAIN_DB,
    PARAM_TACTOR_MUTE,  # 0 or 1
    PARAM_TACTOR_SLOW_GAIN_EXPONENT,
    PARAM_TACTOR_RECOIL_GAIN_EXPONENT,
    PARAM_CLICK_REFERENCE_TORQUE_MNM,
    PARAM_CLICK_COMPRESSION,
    PARAM_CLICK_GAIN_DB,
    PARAM_CLICK_MUTE,  # 0 or 1
    PARAM_TEXTURE_GAIN_DB,
    PARAM_TEXTURE_BRIGHTNESS_HZ,
    PARAM_OUTPUT_CEILING_DB,
) = range(PARAMS, PARAMS + PARAMETERS)
ASKED = column(COEFFS)  # coefficients requested last
ASKED_RETURNS = column(1)  # i64: S_RELEASE_RETURNS requested last
DERIVED = column(COEFFS)  # new coefficients, for comparison
SET_UP = column.end  # end of the columns that `derive` reads and writes

# --- state: everything `reset` clears ---------------------------------------------------------
STATE = column(48)
(
    CLOCK,  # i64: samples since reset
    APPROACH,  # highest recent |omega1|, rad/s
    X,  # disk 1, cells
    V,  # disk 1, cells per sample
    INPUT,  # smoother: its target theta2 behind the clutch's backlash, cells
    SMOOTH_1,  # smoother: first pole, cells
    SMOOTH_2,  # smoother: second pole = the theta2 in use, cells
    ENGAGED,  # i64: 1 = shaft 2 is engaged
    HOLDER,  # i64: active input (source that controls the disk), -1 = none
    TOUCH_COUNT,  # i64: touches so far, which orders the sources
    NEXT_LOWER,  # i64: lower edges of the active surface's events at or below the disk
    NEXT_UPPER,  # i64: upper edges
    ACTIVE_SLOT,  # i64
    FADING_SLOT,  # i64: slot faded from, -1 = none
    FADE_LEFT,  # i64: samples left of the crossfade
    FOLLOWER,  # tactor: peak follower
    ENVELOPE_1,
    ENVELOPE_2,
    PHASE,  # tactor: carrier, turns
    TACTOR_DC_IN,
    TACTOR_DC_OUT,
    TEXTURE_LEVEL,  # texture: its level
    TEXTURE,  # texture: the low-pass
    CLICK_DC_IN,
    CLICK_DC_OUT,
    NOISE,  # u64
    RINGING,  # i64: number of kinds that sound
    BRISTLE,  # deflection of the bristles, cells
    BRISTLE_STIFFNESS,  # of the bristles deflected, N m/rad
    SLIP_PEAK,  # highest |torque| of the bristles since they stuck, N m; -1 = they slide
    PACE,  # of the input, cells per sample
    TARGET_POSITION,  # of the active or last input, without backlash, cells
    WOUND,  # clutch: stretch of shaft 2 in the last sample, cells
    SLIP,  # clutch: stretch of a rigid shaft minus that, cells
    WANTED,  # clutch: allowed speed of the disk, cells per sample
    WAITING,  # i64: 1 = released, and shaft 2 stays until the disk has arrived
    RELEASE_DUE,  # i64: sample at which it disengages at the latest
    ARRIVAL_ABOVE,  # position (cells) from which on the disk has arrived; FAR if none is expected
    ARRIVAL_BELOW,  # position below which it has
    GAIN_FROM,  # output gain at the last sample of the grid
    GAIN_STEP,  # its growth per sample
    GAIN_TO,  # at the next
    TEXTURE_GAIN,  # output gain of the texture, since the last sample of the grid
) = range(STATE, STATE + 43)
SOURCE_TOUCHING = column(SOURCES)  # i64: of each source
SOURCE_TOUCHED_AT = column(SOURCES)  # i64: TOUCH_COUNT when it last touched
SOURCE_THETA2 = column(SOURCES)  # rad
RINGING_KIND = column(BANKS)  # i64: the RINGING first entries name the kinds that sound
BANK_LEFT = column(BANKS)  # i64: samples until a kind is silent
BANK_MODES = column(BANKS)  # i64: modes of a kind when struck
BANK_SIZE = 2 * PHASES + 8
BANK = column(BANKS * MAX_MODES * BANK_SIZE)  # the modes, kind by kind: see "a mode that rings"
PULSE_KEY = column(2)  # i64: strike of the factors below, of even and odd pulses
PULSE_REST = column(2)  # samples
PULSE_RE = column(2 * MAX_MODES)  # state of each mode at the end of the pulse's sample
PULSE_IM = column(2 * MAX_MODES)
METERS = column(16)

# --- meters (cleared by reset) ----------------------------------------------------------------
(
    M_BLOCKS,  # i64
    M_LATE,  # i64: control events that came after their sample
    M_REJECTED,  # i64: control events with a theta2 that is not finite
    M_CLAMPED,  # i64: control events with a theta2 outside [0, pi]
    M_RESETS,  # i64: blocks silenced because the state was not finite
    M_LIMITED,  # i64: samples bent by the limiter
    M_STRIKES,  # i64: strikes so far
    M_PEAK_CLICK,  # of the last block
    M_PEAK_TACTOR,  # of the last block
    M_TORQUE,  # last
    M_ENVELOPE,  # last
    M_FRICTION,  # last
    M_SILENT,  # i64: samples since the last one that was not zero on both channels
    M_STILL,  # i64: samples since the disk was last away from where its springs rest
    M_IMPULSE,  # sum of the torque over the samples so far, N m samples
    M_SUMMED,  # i64: samples in that sum
) = range(METERS, METERS + 16)
TOTAL_STATE = column.end

# --- rings: written by the control thread, read by the audio thread ----------------------------
RING_WRITTEN = column(SOURCES)  # i64: events ever written, per source
RING_READ = column(SOURCES)  # i64: events ever read, per source
HOST_WRITTEN = column(1)  # i64
HOST_READ = column(1)  # i64
STRIKES_READ = column(1)  # i64: strikes the reader has taken (of M_STRIKES)
RING_TIME = column(SOURCES * RING)  # i64: sample, -1 = as soon as possible
RING_THETA2 = column(SOURCES * RING)  # rad
RING_TOUCHING = column(SOURCES * RING)  # i64
HOST_TIME = column(HOST_RING)  # i64: sample, -1 = as soon as possible; then: applied
HOST_WHAT = column(HOST_RING)  # i64: a coefficient, or one of the commands below
HOST_VALUE = column(HOST_RING)
COMMAND_SURFACE = -1  # value: slot to crossfade to
COMMAND_RELEASE_RETURNS = -2  # value: 0 or 1
LOG_TIME = column(STRIKE_LOG)  # strike log: sample with its fraction
LOG_EVENT = column(STRIKE_LOG)  # i64: index in the surface's event table, -1 = the base surface
LOG_TORQUE = column(STRIKE_LOG)  # torque released, N m
LOG_LEVEL = column(STRIKE_LOG)  # strike amplitude after compression
STRIKES_SOUNDED = column(CONTACT)  # i64: strikes the bank has taken, a pulse of CONTACT
APPLIED = column(1)  # i64: control events applied since reset
APPLIED_TIME = column(APPLIED_LOG)  # i64: sample
APPLIED_SOURCE = column(APPLIED_LOG)  # i64
APPLIED_THETA2 = column(APPLIED_LOG)  # rad
APPLIED_TOUCHING = column(APPLIED_LOG)  # i64
SCRATCH = column.end  # columns between the stages, one chunk long
D_TORQUE = column(CHUNK)  # from the disk
D_OMEGA = column(CHUNK)
D_PHASE = column(CHUNK)
D_POSITION = column(CHUNK)
D_SPEED = column(CHUNK)
D_THETA2 = column(CHUNK)
D_FRICTION = column(CHUNK)
D_ENGAGED = column(CHUNK)  # for traces alone
D_AMPLITUDE = column(CHUNK)  # from the shaping
D_SINE = column(CHUNK)
D_TEXTURE_LEVEL = column(CHUNK)
D_BRIGHTNESS = column(CHUNK)
D_RING = column(CHUNK)  # from the modes
D_CLICK = column(CHUNK)  # from the voice
D_TACTOR = column(CHUNK)
LIVE = column(16)  # the audio device's own columns, kept by reset
(
    L_CHANNELS,  # i64: output channels of the stream
    L_STOP,  # i64: 1 = fade out, then end the stream
    L_FADED,  # i64: frames faded so far
    L_CALLBACKS,  # i64
    L_FRAMES,  # i64: frames delivered
    L_UNDERFLOWS,  # i64: callbacks with an output underflow
    L_LATE,  # i64: callbacks that took longer than their own frames last
    L_LONGEST,  # longest callback, s
    L_SECONDS,  # i64: clock_gettime's two fields
    L_NANOSECONDS,  # i64
    L_LINE,  # i64: frames ever written to the delay lines
    L_ALSO_CLICK,  # i64: bit mask of the click's additional channels
    L_ALSO_TACTOR,  # i64
    L_ROUTER,  # i64: address of the memory of a router (router.py), 0 = one tactor
) = range(LIVE, LIVE + 14)
BUSY_BINS = 96
# what the device does to each of click and tactor after the engine: one column a signal
L_GAIN = column(SIGNALS)  # in use, linear
L_CEILING = column(SIGNALS)
L_LIMITED = column(SIGNALS)  # part of the limited signal in the output, 0 to 1
L_GLIDED = 3 * SIGNALS  # the three above glide, in the same order as:
L_WANTED = column(L_GLIDED)  # asked for by the control thread
L_TARGET = column(L_GLIDED)
L_FROM = column(L_GLIDED)
L_LEFT = column(L_GLIDED)  # i64
L_DELAY = column(SIGNALS)  # i64: in use, frames
L_DELAY_FROM = column(SIGNALS)  # i64: crossfaded from
L_DELAY_LEFT = column(SIGNALS)  # i64: frames left of that crossfade
L_DELAY_WANTED = column(SIGNALS)  # i64
L_PEAK = column(SIGNALS)  # highest since the control thread cleared it
L_LINES = column(SIGNALS * DELAY_LINE)  # the two delay lines
L_BUSY = column(BUSY_BINS)  # i64: histogram of callback times, BINS_PER_OCTAVE from SHORTEST_S up
BINS_PER_OCTAVE = 4
SHORTEST_S = 1e-7
# an actuator's drive (actuator.py), relative to its start: coefficients, state, meters, and inputs
# of the coefficients (derive_actuator.py)
(
    ACT_ON,  # i64: 1 = the signal goes through it
    ACT_NOMINAL,  # drive of a signal of 1, of full scale
    ACT_BEND,  # requested drive above which it is soft-limited to the peak
    ACT_PEAK,  # highest drive
    ACT_ROOM,  # from ACT_BEND to the peak
    ACT_FORWARD,  # inverse filter: gain of the requested drive
    ACT_FROM_POSITION,  # feedback from the modelled mass's position
    ACT_FROM_SPEED,  # feedback from its speed
    ACT_A11,  # the modelled mass, per sample: position from position
    ACT_A12,  # position from speed
    ACT_A21,
    ACT_A22,
    ACT_B1,  # position from drive
    ACT_B2,
    ACT_LEAK,  # loss of heat per sample
    ACT_LIMIT,  # highest heat, full scale squared
    ACT_KNEE,  # 1 / the range of heat below ACT_LIMIT in which the drive is reduced
    ACT_FOLLOW,  # smoothing of the reduction per sample
    ACT_W0,  # the skin's weighting: a second-order section
    ACT_W1,
    ACT_W2,
    ACT_W_BACK_1,
    ACT_W_BACK_2,
    ACT_STATE,
) = range(24)
(
    ACT_W_DELAY_1,
    ACT_W_DELAY_2,
    ACT_POSITION,  # of the modelled mass, in drives: where a steady drive of 1 would hold it
    ACT_SPEED,  # over its resonance's angular frequency
    ACT_HEAT,  # mean square of the drive, leaking
    ACT_TAKEN,  # reduction of the drive's power, 0 to 1
    ACT_MOST_TAKEN,  # highest reduction so far
    ACT_AT_PEAK,  # i64: samples held at the peak so far
    ACT_SILENT,  # i64: samples since the last non-zero drive
) = range(ACT_STATE, ACT_STATE + 9)
(
    GIVEN_NOMINAL,  # amplitude of the rated drive, of full scale
    GIVEN_GAIN_DB,  # of the signal
    GIVEN_PEAK,  # of full scale
    GIVEN_MEAN_SQUARE,  # of full scale squared, that the mean over the window may not pass
    GIVEN_WINDOW_S,
    GIVEN_DUTY,  # share of time at the rated drive
    GIVEN_RESONANCE_HZ,
    GIVEN_Q,
    GIVEN_OVERDRIVE_Q,
    GIVEN_PERCEPTUAL_WEIGHTING,  # 0 or 1
) = range(ACT_STATE + 9, ACT_STATE + 19)
ACT_SIZE = 48
L_ACTUATOR = column(ACT_SIZE)
SURFACES = column.end  # the slots, one after the other

# --- a surface slot, relative to its start -----------------------------------------------------
slot = Columns()
SLOT_EVENTS = slot(1)  # i64: number of events
SLOT_MODELS = slot(1)  # i64: its friction models, HAS_... added up; 0 = viscous only
HAS_BRISTLES = 1
HAS_DETENTS = 2  # or end stops
SLOT_END_STIFFNESS = slot(1)  # of the springs beyond the ends, N m/rad
SLOT_END_DAMPING = slot(1)  # N m s/rad
SLOT_HOLD = slot(1)  # highest torque of bristles and detents, N m
slot(3)  # unused
SLOT_TABLE = slot(2 * (CELLS + 1))  # friction and its slope to the next point, interleaved
SLOT_INTEGRAL = slot(CELLS + 1)  # friction's integral from 0, N m s/rad cells
SLOT_STEEP = slot(CELLS // STEEP_BLOCK + 1)  # i64: 1 = a step takes friction's mean over its way
SLOT_LOWER = slot(MAX_EVENTS)  # where events are struck upwards, cells, ascending
SLOT_LOWER_EVENT = slot(MAX_EVENTS)  # i64: which event that is
SLOT_UPPER = slot(MAX_EVENTS)  # where events are struck downwards, cells, ascending
SLOT_UPPER_EVENT = slot(MAX_EVENTS)  # i64
SLOT_RELEASE = slot(MAX_EVENTS)  # friction released there, N m s/rad
SLOT_KIND = slot(MAX_EVENTS)  # i64: kind of each event
KIND_MODES = slot(BANKS)  # i64: modes of each kind
KIND_RING = slot(BANKS)  # i64: samples per kind rings
MODE_SIZE = 4 * PHASES + 8
MODES = slot(BANKS * MAX_MODES * MODE_SIZE)  # of each kind: see "a mode of a surface"
KIND_CLICK = slot(BANKS)  # i64: modes of each kind, including those too high for the sample rate
CLICK_SIZE = 3
CLICKS = slot(BANKS * MAX_MODES * CLICK_SIZE)  # of each kind, in the preset's units:
CLICK_FREQUENCY_HZ, CLICK_DECAY_MS, CLICK_GAIN_DB = range(CLICK_SIZE)
SLOT_SLIDING_TORQUE = slot(2 * (CELLS + 1))  # sliding torque, N m, as SLOT_TABLE
SLOT_OWNER = slot(CELLS + 1)  # i64: the event whose bristles are there, -1 = the surface
SLOT_PULL = slot(2 * (CELLS + 1))  # pull of the detents and its slope, N m, as SLOT_TABLE
SLOT_DETENT_ENERGY = slot(CELLS + 1)  # its integral: their energy, N m cells
BRISTLE_PARAMETERS = 8
BRISTLES = slot(BANKS * BRISTLE_PARAMETERS)  # the parameters of each bank's bristles:
(
    P_STIFFNESS,  # N m/rad
    P_DAMPING,  # N m s/rad
    P_STATIC,  # static torque over sliding torque
    P_STRIBECK,  # rad/s
    P_BREAK_AWAY,  # part of the deflection that is elastic only
    P_STRIKE,  # i64: how hard the kind's events strike, one of:
) = range(6)
STRIKE_BY_APPROACH = 0  # release times the highest recent speed, for viscous friction
STRIKE_BY_TORQUE = 1  # release at any speed, for bristles and stops
STRIKE_BY_SPEED = 2  # release times the present speed, for detents
SLOT_SIZE = (slot.end + 7) // 8 * 8
TOTAL = SURFACES + SLOTS * SLOT_SIZE

# --- a mode that rings, relative to its start -----------------------------------------------------
BANK_RE = 0  # its state, of each phase of the clock
BANK_IM = PHASES
BANK_COS = 2 * PHASES  # rotation and decay in PHASES samples, loaded at the strike
BANK_SIN = 2 * PHASES + 1

# --- a mode of a surface, relative to its start ---------------------------------------------------
MODE_RE = 0  # rotation and decay in 0 to PHASES - 1 samples, twice over
MODE_IM = 2 * PHASES
(
    MODE_COS,  # the same in PHASES samples
    MODE_SIN,
    MODE_TURNS,  # turns per sample
    MODE_DECAY,  # ln of the decay per sample
    MODE_GAIN,
) = range(4 * PHASES, 4 * PHASES + 5)

# --- trace: columns of one frame ----------------------------------------------------------------
TRACE_COLUMNS = (
    "time",
    "theta2",
    "touching",
    "theta1",
    "omega1",
    "cursor",
    "friction",
    "torque",
    "envelope",
    "engaged",
)
TRACE = len(TRACE_COLUMNS)
