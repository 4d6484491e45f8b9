"""Control events: who holds the disk, where, and what parameters and surfaces change when.

Each source (touch, twist, serial, OSC, MIDI, remote) has a ring of its own, written by one control
thread and read here. An event applies at its sample, or at once if that has passed. The last source
to touch holds the disk until it lets go; another that still touches then takes it over.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.glide import smooth_step

PI = 3.141592653589793
CELLS_PER_RAD = layout.CELLS / PI
NEVER = 0x7FFFFFFFFFFFFFFF


@point
def engage(m, w, source):
    """Shaft 2 takes hold of `source`'s finger: a step, wherever the hand was before."""
    place = m[layout.SOURCE_THETA2 + source] * CELLS_PER_RAD
    m[layout.INPUT] = place
    m[layout.SMOOTH_1] = place
    m[layout.SMOOTH_2] = place
    w[layout.HOLDER] = source
    w[layout.TOUCHING] = 1


@point
def let_go(m, w):
    """The holder has let go: another hand takes over, or disk 1 recoils."""
    latest = 0
    heir = -1
    for source in range(layout.SOURCES):
        if (
            w[layout.SOURCE_TOUCHING + source] == 1
            and w[layout.SOURCE_TOUCHED_AT + source] > latest
        ):
            latest = w[layout.SOURCE_TOUCHED_AT + source]
            heir = source
    w[layout.HOLDER] = heir
    if heir >= 0:
        m[layout.INPUT] = m[layout.SOURCE_THETA2 + heir] * CELLS_PER_RAD
    elif w[layout.S_RELEASE_RETURNS] == 1:
        m[layout.INPUT] = 0.0
    else:
        w[layout.TOUCHING] = 0


@point
def log_applied(m, w, source, touching):
    """Keep an event as it is applied, so that a recording of the log replays every bit."""
    at = w[layout.APPLIED] % layout.APPLIED_LOG
    w[layout.APPLIED_TIME + at] = w[layout.CLOCK]
    w[layout.APPLIED_SOURCE + at] = source
    m[layout.APPLIED_THETA2 + at] = m[layout.SOURCE_THETA2 + source]
    w[layout.APPLIED_TOUCHING + at] = touching
    w[layout.APPLIED] += 1


@point
def apply_control(m, w, source, theta2, touching):
    """One hand's event: theta2 in rad (kept to [0, pi]; not finite: as before), touching 0 or 1."""
    if theta2 - theta2 != 0.0:  # NaN or infinite
        w[layout.M_REJECTED] += 1
    else:
        if theta2 < 0.0:
            theta2 = 0.0
            w[layout.M_CLAMPED] += 1
        elif theta2 > PI:
            theta2 = PI
            w[layout.M_CLAMPED] += 1
        m[layout.SOURCE_THETA2 + source] = theta2
    log_applied(m, w, source, touching)
    was = w[layout.SOURCE_TOUCHING + source]
    w[layout.SOURCE_TOUCHING + source] = touching
    if touching == 1 and was == 0:
        w[layout.TOUCH_COUNT] += 1
        w[layout.SOURCE_TOUCHED_AT + source] = w[layout.TOUCH_COUNT]
        engage(m, w, source)
    elif w[layout.HOLDER] == source:
        if touching == 1:
            m[layout.INPUT] = m[layout.SOURCE_THETA2 + source] * CELLS_PER_RAD
        else:
            let_go(m, w)


@point
def events_below(m, w, slot, place):
    """How many events of a slot lie at or below `place` (cells): binary search."""
    low = 0
    high = w[slot + layout.SLOT_EVENTS]
    while low < high:
        middle = (low + high) // 2
        if m[slot + layout.SLOT_PLACE + middle] <= place:
            low = middle + 1
        else:
            high = middle
    return low


@point
def apply_host(m, w, what, value):
    """One parameter or surface event: a glide to a new coefficient, or a crossfade to a slot."""
    if 0 <= what < layout.COEFFS:
        m[layout.TARGET + what] = value
        m[layout.GLIDE_FROM + what] = m[what]
        w[layout.GLIDE_LEFT + what] = w[layout.S_GLIDE]
    elif what == layout.COMMAND_SURFACE:
        w[layout.FADING_SLOT] = w[layout.ACTIVE_SLOT]
        w[layout.ACTIVE_SLOT] = int(value)
        w[layout.FADE_LEFT] = w[layout.S_FADE]
        w[layout.NEXT_EVENT] = events_below(
            m, w, layout.SURFACES + int(value) * layout.SLOT_SIZE, m[layout.X]
        )
    elif what == layout.COMMAND_RELEASE_RETURNS:
        w[layout.S_RELEASE_RETURNS] = int(value)


@point
def apply_due(m, w):
    """Apply every event due at the clock's sample: parameters and surfaces, then hands in order."""
    now = w[layout.CLOCK]
    while w[layout.HOST_READ] < w[layout.HOST_WRITTEN]:
        at = w[layout.HOST_READ] % layout.HOST_RING
        if w[layout.HOST_TIME + at] > now:
            break
        apply_host(m, w, w[layout.HOST_WHAT + at], m[layout.HOST_VALUE + at])
        w[layout.HOST_TIME + at] = now  # for a recording
        w[layout.HOST_READ] += 1
    for source in range(layout.SOURCES):
        while w[layout.RING_READ + source] < w[layout.RING_WRITTEN + source]:
            at = source * layout.RING + w[layout.RING_READ + source] % layout.RING
            time = w[layout.RING_TIME + at]
            if time > now:
                break
            if 0 <= time < now:
                w[layout.M_LATE] += 1
            apply_control(m, w, source, m[layout.RING_THETA2 + at], w[layout.RING_TOUCHING + at])
            w[layout.RING_READ + source] += 1


@point
def next_due(w):
    """The sample of the next event that waits in any ring, or NEVER."""
    due = NEVER
    if w[layout.HOST_READ] < w[layout.HOST_WRITTEN]:
        due = w[layout.HOST_TIME + w[layout.HOST_READ] % layout.HOST_RING]
    for source in range(layout.SOURCES):
        if w[layout.RING_READ + source] < w[layout.RING_WRITTEN + source]:
            time = w[
                layout.RING_TIME + source * layout.RING + w[layout.RING_READ + source] % layout.RING
            ]
            if time < due:
                due = time
    return due


@point
def drop_waiting(w):
    """Forget every event that waits."""
    w[layout.HOST_READ] = w[layout.HOST_WRITTEN]
    for source in range(layout.SOURCES):
        w[layout.RING_READ + source] = w[layout.RING_WRITTEN + source]


@point
def glide_all(m, w):
    """One sample of every gliding coefficient, exact at its end; how many still glide."""
    gliding = 0
    per_glide = 1.0 / float(w[layout.S_GLIDE])
    for i in range(layout.C_SPRING_HELD, layout.COEFFS):
        if w[layout.GLIDE_LEFT + i] > 0:
            w[layout.GLIDE_LEFT + i] -= 1
            if w[layout.GLIDE_LEFT + i] == 0:
                m[i] = m[layout.TARGET + i]
            else:
                left = smooth_step(float(w[layout.GLIDE_LEFT + i]) * per_glide)
                m[i] = (
                    m[layout.TARGET + i] + (m[layout.GLIDE_FROM + i] - m[layout.TARGET + i]) * left
                )
                gliding += 1
    return gliding
