"""Control events: queues of inputs, active input, and changes of parameters and surfaces.

Each source (touch, twist, serial, OSC, MIDI, remote) has its own ring, written by one thread
at a time and read by the audio thread. An event applies at its sample, or at once if it is late.
The last source to touch controls the disk until its release. Then the latest source that still
touches takes over.

Thread: audio, except `push_control`.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import load_acquire, store_release
from overview_dsp.kernels.clutch import with_backlash
from overview_dsp.kernels.compiling import briefly_called, inlined
from overview_dsp.kernels.event_crossing import edges_below
from overview_dsp.kernels.parameter_smoothing import smooth_step
from overview_dsp.kernels.release import arrive, stop_waiting, wait_for_disk

PI = 3.141592653589793
CELLS_PER_RAD = layout.CELLS / PI
LEAST_ANGLE = 1e-150  # rad: smaller would become denormal
NEVER = 0x7FFFFFFFFFFFFFFF


@inlined
def engage(f64, i64, source):
    """Engage shaft 2 at the angle of `source`: a step, independent of the previous angle."""
    position = f64[layout.SOURCE_THETA2 + source] * CELLS_PER_RAD
    f64[layout.INPUT] = position
    f64[layout.TARGET_POSITION] = position
    f64[layout.SMOOTH_1] = position
    f64[layout.SMOOTH_2] = position
    f64[layout.PACE] = f64[layout.C_TAP_RATE] * layout.CELLS
    f64[layout.WANTED] = f64[layout.PACE]
    f64[layout.WOUND] = 0.0
    f64[layout.SLIP] = 0.0
    stop_waiting(f64, i64)
    i64[layout.HOLDER] = source
    i64[layout.ENGAGED] = 1


@inlined
def release(f64, i64):
    """Release the active input: another input takes over, or the disk moves to the last target."""
    latest = 0
    heir = -1
    for source in range(layout.SOURCES):
        if (
            i64[layout.SOURCE_TOUCHING + source] == 1
            and i64[layout.SOURCE_TOUCHED_AT + source] > latest
        ):
            latest = i64[layout.SOURCE_TOUCHED_AT + source]
            heir = source
    i64[layout.HOLDER] = heir
    if heir >= 0:
        f64[layout.INPUT] = f64[layout.SOURCE_THETA2 + heir] * CELLS_PER_RAD
        f64[layout.TARGET_POSITION] = f64[layout.INPUT]
    else:
        wait_for_disk(f64, i64)


@inlined
def log_applied(f64, i64, source, touching):
    """Log an event as applied, so that a recording of the log replays every bit."""
    at = i64[layout.APPLIED] % layout.APPLIED_LOG
    i64[layout.APPLIED_TIME + at] = i64[layout.CLOCK]
    i64[layout.APPLIED_SOURCE + at] = source
    f64[layout.APPLIED_THETA2 + at] = f64[layout.SOURCE_THETA2 + source]
    i64[layout.APPLIED_TOUCHING + at] = touching
    store_release(i64, layout.APPLIED, i64[layout.APPLIED] + 1)


@inlined
def apply_control(f64, i64, source, theta2, touching):
    """Apply an input's event: theta2 in rad (clamped; ignored if not finite), touching 0 or 1."""
    if theta2 - theta2 != 0.0:  # NaN or infinite
        i64[layout.M_REJECTED] += 1
    else:
        if theta2 < 0.0:
            theta2 = 0.0
            i64[layout.M_CLAMPED] += 1
        elif theta2 > PI:
            theta2 = PI
            i64[layout.M_CLAMPED] += 1
        elif theta2 < LEAST_ANGLE:
            theta2 = 0.0
        f64[layout.SOURCE_THETA2 + source] = theta2
    log_applied(f64, i64, source, touching)
    was = i64[layout.SOURCE_TOUCHING + source]
    i64[layout.SOURCE_TOUCHING + source] = touching
    if touching == 1 and was == 0:
        i64[layout.TOUCH_COUNT] += 1
        i64[layout.SOURCE_TOUCHED_AT + source] = i64[layout.TOUCH_COUNT]
        engage(f64, i64, source)
    elif i64[layout.HOLDER] == source:
        position = f64[layout.SOURCE_THETA2 + source] * CELLS_PER_RAD
        if touching == 1:
            backlash = f64[layout.C_BACKLASH]
            f64[layout.INPUT] = with_backlash(f64[layout.INPUT], position, backlash)
            f64[layout.TARGET_POSITION] = position
        else:
            f64[layout.INPUT] = f64[layout.TARGET_POSITION]
            release(f64, i64)


@inlined
def apply_host(f64, i64, what, value):
    """Apply a parameter or surface event: smoothing to a coefficient, or a crossfade to a slot."""
    if 0 <= what < layout.COEFFS:
        f64[layout.TARGET + what] = value
        f64[layout.GLIDE_FROM + what] = f64[what]
        i64[layout.GLIDE_LEFT + what] = i64[layout.S_GLIDE]
    elif what == layout.COMMAND_SURFACE:
        # in this order, so that a search for a free slot never misses one in use
        store_release(i64, layout.FADING_SLOT, i64[layout.ACTIVE_SLOT])
        store_release(i64, layout.ACTIVE_SLOT, int(value))
        i64[layout.FADE_LEFT] = i64[layout.S_FADE]
        slot = layout.SURFACES + int(value) * layout.SLOT_SIZE
        x = f64[layout.X]
        i64[layout.NEXT_LOWER] = edges_below(f64, i64, slot, layout.SLOT_LOWER, x)
        i64[layout.NEXT_UPPER] = edges_below(f64, i64, slot, layout.SLOT_UPPER, x)
    elif what == layout.COMMAND_RELEASE_RETURNS:
        i64[layout.S_RELEASE_RETURNS] = int(value)


@briefly_called
def push_control(f64, i64, source, stamp, theta2, touching):
    """Write an event to a source's ring and publish it; return False if the ring is full.

    f64, i64 : [layout.TOTAL]; source, stamp : int; theta2 : float, rad; touching : bool.

    Thread: any but audio; one at a time for each source.
    """
    written = i64[layout.RING_WRITTEN + source]
    if written - load_acquire(i64, layout.RING_READ + source) >= layout.RING:
        return False
    at = source * layout.RING + written % layout.RING
    i64[layout.RING_TIME + at] = stamp
    f64[layout.RING_THETA2 + at] = theta2
    i64[layout.RING_TOUCHING + at] = 1 if touching else 0
    store_release(i64, layout.RING_WRITTEN + source, written + 1)
    return True


@inlined
def is_pending(i64, read, written):
    """Return whether the ring of these two counters has a readable event."""
    return i64[read] < load_acquire(i64, written)


@inlined
def apply_pending(f64, i64):
    """Apply all events due at the present sample: parameters and surfaces, then inputs in order."""
    now = i64[layout.CLOCK]
    if i64[layout.WAITING] == 1 and i64[layout.RELEASE_DUE] <= now:
        arrive(f64, i64)
    while is_pending(i64, layout.HOST_READ, layout.HOST_WRITTEN):
        at = i64[layout.HOST_READ] % layout.HOST_RING
        if i64[layout.HOST_TIME + at] > now:
            break
        apply_host(f64, i64, i64[layout.HOST_WHAT + at], f64[layout.HOST_VALUE + at])
        i64[layout.HOST_TIME + at] = now  # for a recording
        store_release(i64, layout.HOST_READ, i64[layout.HOST_READ] + 1)
    for source in range(layout.SOURCES):
        while is_pending(i64, layout.RING_READ + source, layout.RING_WRITTEN + source):
            at = source * layout.RING + i64[layout.RING_READ + source] % layout.RING
            time = i64[layout.RING_TIME + at]
            if time > now:
                break
            if 0 <= time < now:
                i64[layout.M_LATE] += 1
            apply_control(
                f64, i64, source, f64[layout.RING_THETA2 + at], i64[layout.RING_TOUCHING + at]
            )
            store_release(i64, layout.RING_READ + source, i64[layout.RING_READ + source] + 1)


@inlined
def next_event_time(i64):
    """Return the sample of the next pending event or release, or NEVER."""
    due = i64[layout.RELEASE_DUE] if i64[layout.WAITING] == 1 else NEVER
    if is_pending(i64, layout.HOST_READ, layout.HOST_WRITTEN):
        due = min(due, i64[layout.HOST_TIME + i64[layout.HOST_READ] % layout.HOST_RING])
    for source in range(layout.SOURCES):
        if is_pending(i64, layout.RING_READ + source, layout.RING_WRITTEN + source):
            time = i64[
                layout.RING_TIME
                + source * layout.RING
                + i64[layout.RING_READ + source] % layout.RING
            ]
            if time < due:
                due = time
    return due


@inlined
def discard_pending(i64):
    """Discard all pending events."""
    store_release(i64, layout.HOST_READ, load_acquire(i64, layout.HOST_WRITTEN))
    for source in range(layout.SOURCES):
        written = load_acquire(i64, layout.RING_WRITTEN + source)
        store_release(i64, layout.RING_READ + source, written)


@inlined
def is_gliding(i64):
    """Return whether any coefficient is being smoothed."""
    left = 0
    for i in range(layout.COEFFS):
        left |= i64[layout.GLIDE_LEFT + i]
    return left > 0


@inlined
def glide_all(f64, i64):
    """Smooth all coefficients by one sample; return how many are not finished."""
    gliding = 0
    per_glide = 1.0 / float(i64[layout.S_GLIDE])
    for i in range(layout.C_SPRING_HELD, layout.COEFFS):
        if i64[layout.GLIDE_LEFT + i] > 0:
            i64[layout.GLIDE_LEFT + i] -= 1
            if i64[layout.GLIDE_LEFT + i] == 0:
                f64[i] = f64[layout.TARGET + i]
            else:
                left = smooth_step(float(i64[layout.GLIDE_LEFT + i]) * per_glide)
                f64[i] = (
                    f64[layout.TARGET + i]
                    + (f64[layout.GLIDE_FROM + i] - f64[layout.TARGET + i]) * left
                )
                gliding += 1
    return gliding
