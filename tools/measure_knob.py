"""Measurement of torque and energy on a motor knob whose own board runs the surface.

    python tools/measure_knob.py                         # the bundled match
    python tools/measure_knob.py --data FOLDER           # matches, `*.json` anywhere in it
    python tools/measure_knob.py --delays 0 20 --sweeps 4

The knob is `simulated_board.py` (5e-5 kg m2, 3e-4 N m dry friction, 14-bit encoder) with the real
firmware. The wire has delay, jitter and loss in both directions. The host is the part of
`overview play` for such a board. The program prints each figure with its limit. The exit code is
the number of figures beyond their limits.

The torque of an event is its maximum above the mean of the 50 ms before its span; the median over
the events of a kind is printed. Passivity is the greatest rise of the energy (returned to the user
plus stored in springs and disk) between any two times, without the knob's own friction. It is the
worst of jiggling about the start, a goal, the middle and the end at every delay.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
from knob_session import JITTER, TICK_S, TURN, Course, glide, simulate
from simulated_board import BoardMotor
from simulated_motor import flick, jiggle

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import Sensor, load_sensor

DELAYS_MS = (0.0, 2.0, 5.0, 10.0, 20.0)
SWEEPS_S = (1.0, 2.0, 3.0, 4.0, 6.0)

HandPath = Callable[[float], float | None]

REACH = np.array([-2.0, 2.0]) / 8192
"""Enlargement of an event in the board's table, two points each way."""


def torque_rises(course: Course, surface: ov.Surface, kind: str) -> list[float]:
    """Return the rise of the braking torque for each event of a kind, N m."""
    found = []
    brake = -course.torque
    dt = course.time[1] - course.time[0]
    for at in np.flatnonzero(surface.kind == list(surface.kind_names).index(kind)):
        first, last = surface.span[at] + REACH
        if not (math.isfinite(first) and first > 0.03 and last < 0.95):
            continue  # where the speed of the sweep changes
        enters, leaves = (int(np.argmax(course.disk >= position)) for position in (first, last))
        before = slice(max(0, enters - round(0.05 / dt)), enters)
        if enters and leaves and before.start < before.stop:
            peak = brake[enters : leaves + round(0.02 / dt)].max()
            found.append(float(peak - brake[before].mean()))
    return found


def impact_rises(course: Course, surface: ov.Surface, kind: str = "goal") -> list[float]:
    """Return the rise of the torque within 10 ms after each event's start, N m."""
    found = []
    dt = course.time[1] - course.time[0]
    for at in np.flatnonzero(surface.kind == list(surface.kind_names).index(kind)):
        first = surface.span[at, 0] + REACH[0]
        enters = int(np.argmax(course.disk >= first))
        if math.isfinite(first) and 0.03 < first < 0.95 and enters:
            part = -course.torque[enters - round(0.001 / dt) : enters + round(0.01 / dt)]
            found.append(float(part.max() - part[0]))
    return found


# --- the table -----------------------------------------------------------------------------------


class Table:
    """Printed figures with their limits."""

    def __init__(self) -> None:
        self.failures = 0

    def line(
        self, what: str, figure: float, unit: str, least: float | None, most: float | None
    ) -> None:
        holds = (least is None or figure >= least) and (most is None or figure <= most)
        self.failures += not holds
        limits = " and ".join(
            f"{sign} {limit:g}"
            for sign, limit in ((">=", least), ("<=", most))
            if limit is not None
        )
        mark = "" if holds else "   FAILS"
        print(f"{what:64s} {figure:9.3f} {unit:5s} {limits}{mark}", flush=True)


def matches(folder: Path | None) -> Iterator[tuple[str, ov.Timeline]]:
    """Yield names and timelines of matches."""
    if folder is None:
        yield "world-cup-final-2018", ov.load_timeline("world-cup-final-2018")
        return
    for path in sorted(folder.rglob("*.json")):
        try:
            timeline = ov.load_timeline(path)
        except ov.InputError:  # a line-up, a list of matches
            continue
        if {"goal", "foul", "yellow_card"} <= set(timeline.kinds()):
            yield path.stem, timeline


def measure_feel(
    table: Table, options: argparse.Namespace, sensor: Sensor, preset: ov.Preset
) -> None:
    """Measure goal, card and foul for each sweep and delay."""
    surfaces = [(name, ov.build_surface(one, preset)) for name, one in matches(options.data)]
    surfaces = surfaces[: options.matches]
    print(f"{len(surfaces)} matches: {', '.join(name for name, _ in surfaces)}")
    print("median torque, mN m: goal / yellow card / foul at each sweep and delay")
    for seconds in options.sweeps:
        first: dict[str, float] = {}
        for delay_ms in options.delays:
            values: dict[str, list[float]] = {"goal": [], "yellow_card": [], "foul": []}
            impacts: list[float] = []
            for _, surface in surfaces:
                course = simulate(
                    surface, preset, sensor, glide(seconds), seconds + 0.3, delay_ms * 1e-3
                )
                for kind in values:
                    values[kind] += torque_rises(course, surface, kind)
                impacts += impact_rises(course, surface)
            middle = {kind: 1e3 * float(np.median(ones)) for kind, ones in values.items()}
            goal, card, foul = middle.values()
            name = f"{seconds:g} s, {delay_ms:g} ms: {goal:.2f} / {card:.2f} / {foul:.2f};"
            strict = seconds >= 2.0
            table.line(f"{name} goal : yellow", goal / card, "", 1.5 if strict else 1.0, None)
            table.line(
                f"{'':{len(name)}s} goal : foul", goal / foul, "", 2.5 if strict else 1.0, None
            )
            table.line(f"{'':{len(name)}s} yellow : foul", card / foul, "", 1.0, None)
            if seconds == 4.0:
                table.line(f"{'':{len(name)}s} goal within 10 ms",
                           1e3 * float(np.median(impacts)), "mN m", 5.0, None)  # fmt: skip
            first = first or middle
            change = max(abs(middle[kind] / first[kind] - 1.0) for kind in middle)
            table.line(f"{'':{len(name)}s} from the first delay", 100.0 * change, "%", None, 5.0)


def worst_rise(
    table: Table,
    what: str,
    delays_ms: Iterable[float],
    paths: Mapping[str, HandPath],
    rise: Callable[[HandPath, float], float],
) -> None:
    """Print the greatest rise over all paths and delays; `rise` takes both (s) and returns J."""
    found = {
        (name, delay_ms): 1e6 * rise(path, delay_ms * 1e-3)
        for name, path in paths.items()
        for delay_ms in delays_ms
    }
    name, delay_ms = worst = max(found, key=found.__getitem__)
    table.line(f"{what}: rise{name}, {delay_ms:g} ms", found[worst], "uJ", None, 10.0)


def measure_safety(
    table: Table, options: argparse.Namespace, sensor: Sensor, preset: ov.Preset
) -> None:
    """Measure energy, silence, ends and recoil."""
    _, timeline = next(matches(options.data))
    surface = ov.build_surface(timeline, preset)
    delay = max(options.delays) * 1e-3
    goal = surface.position[surface.kind == list(surface.kind_names).index("goal")][0]
    places = {"start": 0.0, "goal": TURN * float(goal), "middle": 1.5, "end": TURN}
    for steps in (4000, 1000):

        def jiggled(path: HandPath, delay_s: float, steps: int = steps) -> float:
            course = simulate(surface, preset, sensor, path, 3.0, delay_s, hertz=steps)
            return course.greatest_rise(since=1.5)

        for hertz, degrees in ((2.0, 25.0), (5.0, 11.0), (10.0, 11.0), (15.0, 11.0), (20.0, 8.0)):
            paths = {
                f" about the {name}": jiggle(hertz, math.radians(degrees), 1.5, about)
                for name, about in places.items()
            }
            name = f"{steps} steps/s, jiggle {hertz:g} Hz by {degrees:g} deg"
            worst_rise(table, name, options.delays, paths, jiggled)

    def moved(path: HandPath, delay_s: float) -> float:
        return simulate(surface, preset, sensor, path, 4.0, delay_s).greatest_rise()

    worst_rise(table, "sweep of 2 s", options.delays, {"": glide(2.0)}, moved)
    worst_rise(table, "thrown and released", options.delays, {"": flick(0.8, 2.0, 0.3)}, moved)

    course = simulate(surface, preset, sensor, glide(4.0), 3.0, 0.0, 0.0, killed_at=1.5)
    after = course.time > 1.5 + TICK_S + 0.04
    table.line("host killed, 40 ms later", 1e3 * float(np.abs(course.torque[after]).max()), "mN m",
               None, 0.0)  # fmt: skip
    before = (course.time > 1.4) & (course.time < 1.5)
    table.line("          and before", 1e3 * float(np.abs(course.torque[before]).max()), "mN m",
               0.1, None)  # fmt: skip
    motor = BoardMotor()
    highest = 0.0
    for _ in range(8000):
        motor.loop(b"")
        motor.step(0.01 * math.sin(20.0 * motor.time))
        highest = max(highest, abs(motor.torque))
    table.line("power on, no data, the knob turned", 1e3 * highest, "mN m", None, 0.0)

    for name, push in (("end", lambda t: 1.25 * TURN * min(1.0, t / 1.5)),
                      ("start", lambda t: -0.25 * TURN * min(1.0, t / 0.5))):  # fmt: skip
        course = simulate(surface, preset, sensor, push, 3.0, delay, stiffness=0.02)
        held = course.time > 2.5
        table.line(f"pushed 45 deg beyond the {name} (20 mN m/rad): torque",
                   1e3 * float(np.abs(course.torque[held]).min()), "mN m", 3.0, None)  # fmt: skip
        beyond = course.angle[held] - TURN if name == "end" else -course.angle[held]
        table.line("    it yields by", math.degrees(float(beyond.max())), "deg", None, 8.0)
        table.line(
            "    and moves, peak to peak", math.degrees(float(np.ptp(beyond))), "deg", None, 0.2
        )

    for reach in (74.0, 144.0):

        def tapped(t: float, reach: float = math.radians(reach)) -> float | None:
            return reach * min(1.0, t / 0.15) if t < 0.25 else None

        course = simulate(surface, preset, sensor, tapped, 3.0, delay)
        took = float(course.time[course.angle > math.radians(18.0)][-1]) - 0.25
        table.line(f"a tap to {reach:g} deg: back within 18 deg after", took, "s", None, 1.5)


def measure_sound(
    table: Table, options: argparse.Namespace, sensor: Sensor, preset: ov.Preset
) -> None:
    """Measure the time from an event on the board's disk to the same event in the sound."""
    _, timeline = next(matches(options.data))
    surface = ov.build_surface(timeline, preset)
    for delay_ms in options.delays:
        late: list[float] = []
        for seconds in (2.0, 4.0):
            course = simulate(surface, preset, sensor, glide(seconds), seconds + 0.5,
                              delay_ms * 1e-3, timeline=timeline)  # fmt: skip
            for at, event in enumerate(surface.event):
                passes = int(np.argmax(course.disk >= surface.edges[at, 0]))
                if passes and 0.1 < surface.position[at] < 0.95 and event in course.strike_times:
                    late.append(1e3 * (course.strike_times[event] - course.time[passes]))
        low, middle, high = np.percentile(late, [5.0, 50.0, 95.0])
        most = delay_ms * (1.0 + 0.5 * JITTER) + 10.0
        table.line(f"{delay_ms:g} ms: sound after force, median", middle, "ms", -10.0, most)
        table.line("    5 % point", low, "ms", -10.0, None)
        table.line("    95 % point", high, "ms", None, most + 10.0)


MEASURED = {"feel": measure_feel, "safety": measure_safety, "sound": measure_sound}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, help="folder of matches")
    parser.add_argument("--matches", type=int, default=4, help="number of matches")
    parser.add_argument("--preset", default="football")
    parser.add_argument("--sensor", default="simplefoc", help="profile of the knob")
    parser.add_argument("--sweeps", type=float, nargs="+", default=SWEEPS_S, help="durations, s")
    parser.add_argument(
        "--delays", type=float, nargs="+", default=DELAYS_MS, help="delays each way, ms"
    )
    parser.add_argument("--only", choices=MEASURED)
    options = parser.parse_args()
    table, sensor, preset = Table(), load_sensor(options.sensor), ov.load_preset(options.preset)
    for name, measure in MEASURED.items():
        if options.only in (None, name):
            measure(table, options, sensor, preset)
    print(f"{table.failures} figures are beyond their limits")
    sys.exit(min(table.failures, 100))


if __name__ == "__main__":
    main()
