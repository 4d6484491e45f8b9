"""The facts of the bundled match, and the Timeline they give.

Run it (`python -m tests.data.readers.world_cup_final`, or by its path) to write the
bundled file anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from overview_dsp.data.analysis.crowd_excitement import crowd_curve
from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.timeline.model import Event, Intensity, Timeline

BUNDLED_FILE = (
    Path(__file__).parents[3] / "overview_dsp/data/readers/bundled/world_cup_final_2018.json"
)

FIRST_HALF_S = 48 * 60.0  # 45 + about 3 minutes
SECOND_HALF_S = 50 * 60.0  # 45 + about 5 minutes

SIDES = ("France", "Croatia")

# public facts: minute (of the match as reported), kind, label, side
FIRST_HALF_FACTS = (
    (18, "own_goal", "1-0 own goal, Mandžukić", 1),
    (27, "yellow_card", "Kanté (France)", 1),
    (28, "goal", "1-1 Perišić", 2),
    (38, "goal", "2-1 Griezmann (pen)", 1),
    (41, "yellow_card", "Hernández (France)", 1),
)
SECOND_HALF_FACTS = (
    (59, "goal", "3-1 Pogba", 1),
    (65, "goal", "4-1 Mbappé", 1),
    (69, "goal", "4-2 Mandžukić", 2),
    (92, "yellow_card", "Vrsaljko (Croatia)", 2),  # 90+2
)

# not facts: nobody publishes when these were, so they are made up, and say so
SYNTHETIC_FOULS_S = (
    *(175, 430, 760, 900, 1170, 1370, 1840, 2120),
    *(2600, 3020, 3400, 3870, 4490, 4700, 5160, 5400),
)
SYNTHETIC_NEAR_MISSES_S = (590, 1980, 3190, 4960)


def synthetic_touches(duration_s: float) -> tuple[Event, ...]:
    """Passes and the like, in spells of play with pauses between them, all made up."""
    random = np.random.default_rng(2018)
    touches: list[Event] = []
    time_s = 2.0
    while time_s < duration_s:
        for _ in range(random.integers(4, 16)):
            if time_s < duration_s:
                touches.append(Event(round(time_s, 1), "touch"))
            time_s += float(random.uniform(1.5, 4.0))
        time_s += float(random.uniform(5.0, 25.0))
    return tuple(touches)


def made_up(kind: str, label: str, times: tuple[int, ...]) -> list[Event]:
    """Events of made-up times; the teams take turns."""
    return [Event(t, kind, label, side=1 + i % 2) for i, t in enumerate(times)]


def final() -> Timeline:
    """Lay the facts out, each in the middle of its minute: the m-th lasts from m - 1 to m."""
    events = [
        Event(0.0, "period", "kick-off"),
        Event(FIRST_HALF_S, "period", "half-time"),
        Event(FIRST_HALF_S + SECOND_HALF_S, "period", "full time"),
    ]
    events += [Event((m - 0.5) * 60, *fact, 1.0, side) for m, *fact, side in FIRST_HALF_FACTS]
    events += [
        Event(FIRST_HALF_S + (m - 45 - 0.5) * 60, *fact, 1.0, side)
        for m, *fact, side in SECOND_HALF_FACTS
    ]
    events += made_up("foul", "foul (synthetic)", SYNTHETIC_FOULS_S)
    events += made_up("near_miss", "near miss (synthetic)", SYNTHETIC_NEAR_MISSES_S)
    duration_s = FIRST_HALF_S + SECOND_HALF_S
    curve = crowd_curve(events, duration_s)
    return Timeline(
        title="France 4-2 Croatia, World Cup final, Moscow, 15 July 2018",
        duration_s=duration_s,
        events=tuple(events),
        intensity=Intensity(
            curve.time_s,
            np.round(curve.value, 4),
            "synthetic crowd excitement 0..1, derived from the events",
        ),
        provenance=(
            "goals and cards: public facts, each in the middle of its reported minute (true to "
            "30 s); halves of 48 and 50 minutes (approximate) laid end to end; fouls, near "
            "misses and touches: synthetic; intensity: synthetic, the crowd-excitement formula "
            "applied to the events, not a recording"
        ),
        notes=(
            "fouls and near misses labelled (synthetic) are made up: their times aren't public",
            "the intensity is synthetic: no crowd was recorded",
            "the touches felt when zoomed are made up",
        ),
        details=synthetic_touches(duration_s),
        sides=SIDES,
    )


if __name__ == "__main__":
    save_timeline(final(), BUNDLED_FILE)
