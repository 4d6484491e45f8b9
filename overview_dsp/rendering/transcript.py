"""A render in words, for who can't hear or feel it: which events were passed, and how hard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.engine.meters import Strikes
from overview_dsp.timeline import Timeline

MOST = 12
"""Lines of a transcript: the strongest events; a match of an hour has hundreds of weak ones."""


def transcript(
    strikes: Strikes,
    timeline: Timeline,
    held: NDArray[np.float64] | None,
    sample_rate: float,
    most: int = MOST,
) -> tuple[str, ...]:
    """The strongest strikes in order of time, a line each.

    Parameters
    ----------
    strikes
        Of a render; those of the bare surface are left out.
    timeline
        The one that was rendered: gives kinds, labels and moments.
    held
        The trace's `touching`, one value a frame, or None where there is no trace: says which
        strikes belong to the recoil.
    sample_rate
        Hz, of `held`.
    most
        Lines.

    Returns
    -------
    tuple of str
        "1.75 s: goal, 1-0 Perez, at 27:00.0, 12 dB below the strongest"; empty if nothing was
        passed.
    """
    passed = strikes.of_events()
    if not len(passed):
        return ()
    strongest = float(passed.level.max())
    kept = np.sort(np.argsort(-passed.level, kind="stable")[:most])
    lines = []
    for at in kept:
        time_s = float(passed.time_s[at])
        event = timeline.events[passed.event[at]]
        words = event.kind.replace("_", " ") + (f", {event.label}" if event.label else "")
        if held is not None and len(held):
            frame = min(int(time_s * sample_rate), len(held) - 1)
            words += "" if held[frame] > 0.5 else ", on the way back"
        below = round(-20.0 * np.log10(max(float(passed.level[at]) / strongest, 1e-6)))
        level = f"{below} dB below the strongest" if below else "the strongest"
        lines.append(f"{time_s:.2f} s: {words}, at {timeline.moment_text(event.time_s)}, {level}")
    return tuple(lines)
