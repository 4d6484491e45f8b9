"""A render in words, for who can't hear or feel it: which events were passed, and how hard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.signal.engine.meters import Strikes

MOST = 8
"""Lines for each way: the strongest events; a match has hundreds of weak ones."""


def transcript(
    strikes: Strikes,
    timeline: Timeline,
    engaged: NDArray[np.float64] | None,
    sample_rate: float,
    most: int = MOST,
) -> tuple[str, ...]:
    """The strongest strikes of the way out and of the recoil, in order of time, a line each.

    Parameters
    ----------
    strikes
        Of a render; those of the bare surface are left out.
    timeline
        The one that was rendered: gives kinds, labels and moments.
    engaged
        The trace's column, one value a frame, or None where there is no trace: says which
        strikes belong to the recoil; without it all count as one way.
    sample_rate
        Hz, of `engaged`.
    most
        Lines for each way.

    Returns
    -------
    tuple of str
        "1.75 s: goal, 1-0 Perez, at 27:00.0, 12 dB below the strongest"; empty if nothing was
        passed.
    """
    passed = strikes.of_events()
    if not len(passed):
        return ()
    out = np.ones(len(passed), dtype=bool)
    if engaged is not None and len(engaged):
        frames = np.minimum((passed.time_s * sample_rate).astype(int), len(engaged) - 1)
        out = engaged[frames] > 0.5
    order = np.argsort(-passed.level, kind="stable")
    kept = np.sort(np.concatenate([order[out[order]][:most], order[~out[order]][:most]]))
    strongest = float(passed.level.max())
    lines = []
    for at in kept:
        event = timeline.events[passed.event[at]]
        words = event.kind.replace("_", " ") + (f", {event.words}" if event.words else "")
        words += "" if out[at] else ", on the way back"
        below = round(-20.0 * np.log10(max(float(passed.level[at]) / strongest, 1e-6)))
        level = f"{below} dB below the strongest" if below else "the strongest"
        moment = timeline.moment_text(event.time_s)
        lines.append(f"{passed.time_s[at]:.2f} s: {words}, at {moment}, {level}")
    return tuple(lines)
