"""Measurement of a motor knob whose own board runs the surface: events, torques and energy.

    python tools/measure_knob.py                         # with the matches of $OVERVIEW_TEST_DATA
    python tools/measure_knob.py --data FOLDER           # matches, `*.json` anywhere in it
    python tools/measure_knob.py --only events --matches 3

The firmware is the real one. `knob_rig.c` has knob and hand: 5e-5 kg m2, 3e-4 N m of dry friction,
an encoder of 14 bits, a hand of 0.1 N m/rad that corrects the pull to the start. The *real* knob
has fingers of 2e-5 kg m2 as well, an encoder that is 0.3 ms late and noisy (1e-4 rad), a winding of
0.4 ms, and 84 cogs of 0.3 mN m a turn. The matches are the bundled one, those of the folder, and
random ones.

Every event of every match counts. An event that the disk hasn't passed half a second after the hand
arrived is never passed. The torque of an event is that at the fingers: its maximum until 50 ms
after the disk has left the event, or until the next goal or card, above the mean of the 50 ms
before. A knock is the motor's torque above that before it; its length is the time above half of its
peak.

The energy returned is the greatest rise, between any two moments, of the motor's work plus the
energy that the pull to the start and the ends store; the knob's own friction isn't credited. A
figure beyond its limit is marked, and the exit code is their number.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import math
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from knob_session import (
    IDEAL,
    JITTER,
    REAL,
    TICK_S,
    TURN,
    Stroke,
    frames_for,
    glide,
    simulate,
    stroke,
)
from simulated_board import BoardMotor

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import Sensor, load_sensor

KNOBS = {"ideal": IDEAL, "real": REAL}
SWEEPS_S = (1.0, 2.0, 3.0, 4.0, 6.0)
ARMS_S = (2.0, 4.0)
DELAYS_MS = (0.0, 2.0, 5.0, 10.0, 20.0)
STIFFNESS = 0.1  # of the hand, N m/rad
HOME = 0.55  # of the ceiling, most of the pull to the start
BEFORE_S = AFTER_S = 0.05
CARDS = ("yellow_card", "red_card")
LOUD = ("goal", "own_goal", *CARDS)
STOPS = np.linspace(0.1, 0.98, 12)

HandPath = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Match:
    """A match, its surface, and what a host sends to a board for it."""

    name: str
    timeline: ov.Timeline
    surface: ov.Surface
    frames: bytes

    @functools.cached_property
    def kinds(self) -> list[str]:
        """Kind of each event."""
        return [self.surface.kind_names[kind] for kind in self.surface.kind]

    def positions(self, kind: str) -> np.ndarray:
        """Return the positions of a kind's events."""
        return self.surface.position[np.array(self.kinds) == kind]


def matches(folder: Path | None, count: int) -> Iterator[tuple[str, ov.Timeline]]:
    """Yield names and timelines: the bundled match, those of a folder, random ones."""
    found = 1
    yield "world-cup-final-2018", ov.load_timeline("world-cup-final-2018")
    for path in sorted(folder.rglob("*.json")) if folder else ():
        try:
            timeline = ov.load_timeline(path)
        except ov.InputError:  # a line-up, a list of matches
            continue
        if {"goal", "foul", "yellow_card"} <= set(timeline.kinds()):
            found += 1
            yield path.stem, timeline
    for seed in range(max(0, count - found)):
        yield f"random {seed}", ov.measure.random_match(seed)


# --- the hand ------------------------------------------------------------------------------------


class User:
    """Paths of a user who balances the pull, so that the knob goes where the path does."""

    def __init__(self, sensor: Sensor, preset: ov.Preset) -> None:
        k1, k2 = (float(preset.values[f"disk.{name}"]) for name in ("k1", "k2"))
        gain = sensor.number("motor.board_scale") * sensor.number("motor.home")
        most = HOME * sensor.number("motor.ceiling_nm") / TURN
        self._pull = min(gain * k1 * k2 / (k1 + k2), most) / STIFFNESS

    def balanced(self, angle: np.ndarray) -> np.ndarray:
        """Return the targets of a user whose knob should be at `angle`."""
        return angle + self._pull * np.clip(angle, 0.0, TURN)

    def over(self, seconds: float, arm: bool) -> HandPath:
        """Return a path over the whole timeline and half a percent more."""
        shape = minimum_jerk if arm else even
        return lambda time: self.balanced(1.005 * TURN * shape(np.minimum(time / seconds, 1.0)))

    def stopping(self, at: float, seconds: float, arm: bool) -> HandPath:
        """Return a path that stops at the position `at`, at once unless it is an arm."""

        def path(time: np.ndarray) -> np.ndarray:
            part = np.minimum(time / (seconds * at), 1.0)
            return self.balanced(TURN * at * (minimum_jerk(part) if arm else part))

        return path

    def jiggling(self, about: float, hertz: float, degrees: float) -> HandPath:
        """Return a path to `about` (rad) within a second; it then oscillates from 1.2 s on."""
        reach, turning = math.radians(degrees), 2.0 * math.pi * hertz

        def path(time: np.ndarray) -> np.ndarray:
            middle = about * np.minimum(time, 1.0)
            swing = reach * np.sin(turning * np.maximum(time - 1.2, 0.0))
            return self.balanced(middle) + swing

        return path


def minimum_jerk(part: np.ndarray) -> np.ndarray:
    """Return positions of an arm's movement from 0 to 1."""
    return part**3 * (10.0 - part * (15.0 - 6.0 * part))


def even(part: np.ndarray) -> np.ndarray:
    """Return positions at constant speed from 0 to 1, with a slower tenth at each end."""
    ease = 0.1
    begins, ends = part**2 / (2.0 * ease), 1.0 - ease - (1.0 - part) ** 2 / (2.0 * ease)
    middle = part - 0.5 * ease
    found = np.where(part < ease, begins, np.where(part > 1.0 - ease, ends, middle))
    return found / (1.0 - ease)


# --- one stroke ----------------------------------------------------------------------------------


def first_at(values: np.ndarray, least: float) -> int | None:
    """Return the index of the first value of at least `least`."""
    found = np.flatnonzero(values >= least)
    return int(found[0]) if len(found) else None


def never_passed(match: Match, course: Stroke) -> int:
    """Return how many events the disk has not passed."""
    return int((match.surface.position > course.disk.max()).sum())


def felt_rises(match: Match, course: Stroke) -> np.ndarray:
    """Return the rise of the torque at the fingers for each event, N m; NaN where it has none."""
    spans = match.surface.span
    enters = [first_at(course.disk, max(first, 0.0)) for first, _ in spans]
    loud = sorted(one for one, kind in zip(enters, match.kinds, strict=True)
                  if one is not None and kind in LOUD)  # fmt: skip
    rises = np.full(len(spans), math.nan)
    before, after = round(BEFORE_S * course.hertz), round(AFTER_S * course.hertz)
    for at, (enter, span) in enumerate(zip(enters, spans, strict=True)):
        if enter is None or enter < before or not np.isfinite(span).all():
            continue  # the halves at both ends of the timeline have one side only
        left = first_at(course.disk, span[1])
        ends = [len(course.felt) if left is None else left + after]
        ends += [one for one in loud if one > enter]
        part = course.felt[enter : min(ends)]
        rises[at] = part.max() - course.felt[enter - before : enter].mean()
    return rises


def knocks(match: Match, course: Stroke) -> dict[str, list[tuple[float, float]]]:
    """Return length (ms) and push (uN m s) of the knocks of each kind."""
    found: dict[str, list[tuple[float, float]]] = {}
    length = round(0.0055 * course.hertz)
    for start in np.flatnonzero(course.knocks):
        event = int(np.argmin(np.abs(match.surface.span[:, 0] - course.disk[start])))
        rise = -(course.torque[start : start + 2 * length] - course.torque[start - 1])
        above = float((rise > 0.5 * rise.max()).sum()) / course.hertz
        push = float(rise[:length].sum()) / course.hertz
        found.setdefault(match.kinds[event], []).append((1e3 * above, 1e6 * push))
    return found


def late_by(course: Stroke, seconds: float) -> float:
    """Return how long after `seconds` the disk is farther than 0.5 % from the knob."""
    gap = np.abs(course.disk - course.angle / TURN)[round(seconds * course.hertz) :]
    far = np.flatnonzero(gap > 0.005)
    return float(far[-1] + 1) / course.hertz if len(far) else 0.0


# --- the table -----------------------------------------------------------------------------------


class Table:
    """Printed figures with their limits."""

    def __init__(self) -> None:
        self.failures = 0

    def line(
        self,
        what: str,
        figure: float,
        unit: str,
        least: float | None = None,
        most: float | None = None,
    ) -> None:
        """Print a figure and its limits."""
        holds = (least is None or figure >= least) and (most is None or figure <= most)
        self.failures += not holds
        limits = " and ".join(
            f"{sign} {limit:g}"
            for sign, limit in ((">=", least), ("<=", most))
            if limit is not None
        )
        mark = "" if holds else "   FAILS"
        print(f"{what:64s} {figure:9.3f} {unit:7s} {limits}{mark}", flush=True)


@dataclass(frozen=True)
class Run:
    """Options, data and result of all measurements."""

    table: Table
    matches: list[Match]
    sensor: Sensor
    preset: ov.Preset
    user: User
    delays: list[float]


def measure_events(run: Run) -> None:
    """Measure what is passed and felt at each speed, and when the disk arrives."""
    count = sum(len(match.kinds) for match in run.matches)
    omitted = sum(sum(match.surface.omitted_events.values()) for match in run.matches)
    print(f"{len(run.matches)} matches, {count} events, {omitted} omitted: "
          f"{', '.join(match.name for match in run.matches)}")  # fmt: skip
    speeds = [(seconds, False) for seconds in SWEEPS_S] + [(seconds, True) for seconds in ARMS_S]
    for (seconds, arm), (name, knob) in itertools.product(speeds, KNOBS.items()):
        measure_speed(run, seconds, arm, name, knob)
    scrubbed(run)


def measure_speed(run: Run, seconds: float, arm: bool, name: str, knob: dict[str, float]) -> None:
    """Measure one speed on one knob."""
    table, user = run.table, run.user
    print(f"--- {'arm' if arm else 'sweep'} of {seconds:g} s, {name} knob")
    never, silent, late, weak, pairs = 0, 0, 0.0, [], 0
    rises: dict[str, list[float]] = {}
    struck: list[tuple[float, float]] = []
    for match in run.matches:
        course = stroke(match.frames, user.over(seconds, arm), seconds + 0.5, knob)
        never += never_passed(match, course)
        found: dict[str, list[float]] = {}
        for kind, rise in zip(match.kinds, felt_rises(match, course), strict=True):
            if rise == rise:
                found.setdefault(kind, []).append(1e3 * float(rise))
                rises.setdefault(kind, []).append(1e3 * float(rise))
        cards = [rise for kind in CARDS for rise in found.get(kind, [])]
        for goal, card in itertools.product(found.get("goal", []), cards):
            pairs += 1
            if goal <= card:
                weak.append(f"{match.name} {goal:.2f} <= {card:.2f}")
        goals = knocks(match, course).get("goal", [])
        silent += max(0, match.kinds.count("goal") - len(goals))
        struck += goals
        for at in STOPS:
            path = user.stopping(float(at), seconds, arm)
            course = stroke(match.frames, path, seconds * at + 0.7, knob)
            late = max(late, late_by(course, seconds * at))
    table.line("events never passed", never, "", None, 0.0)
    table.line("goals without a knock", silent, "", None, 0.0)
    table.line("within 0.5 % of the hand after a stop anywhere, worst", late, "s", None, 0.2)
    middle = {kind: float(np.median(ones)) for kind, ones in rises.items()}
    print("median at the fingers, mN m: "
          + ", ".join(f"{kind} {middle[kind]:.2f}" for kind in sorted(middle)))  # fmt: skip
    strict = name == "real" and seconds >= 2.0 and not arm
    card = float(np.median([one for kind in CARDS for one in rises.get(kind, [])]))
    table.line("goal : card", middle["goal"] / card, "", 2.0 if strict else None)
    table.line("goal : foul", middle["goal"] / middle["foul"], "", 3.5 if strict else None)
    print(f"goal at or under a card: {len(weak)} of {pairs} pairs (mN m)")
    for one in weak:
        print(f"    {one}")
    lengths, pushes = np.array(struck).T
    table.line("knock of a goal, median", float(np.median(lengths)), "ms", 3.0, 5.0)
    table.line("    shortest", float(lengths.min()), "ms")
    table.line("    longest", float(lengths.max()), "ms")
    table.line("    push, median", float(np.median(pushes)), "uN m s", 30.0)
    table.line("    push, least", float(pushes.min()), "uN m s")


def scrubbed(run: Run) -> None:
    """Count the passes of goals that are scrubbed."""
    for hertz in (1.0, 2.0):
        missed = 0
        for match, knob in itertools.product(run.matches, KNOBS.values()):
            for goal in match.positions("goal"):
                path = run.user.jiggling(TURN * float(goal), hertz, 12.0)
                course = stroke(match.frames, path, 5.2, knob)
                hand, disk = (
                    int(np.count_nonzero(np.diff(where[4800:] > goal)))
                    for where in (course.angle / TURN, course.disk)
                )
                missed += max(0, hand - disk - 1)  # the last one may still come
        run.table.line(f"goals scrubbed at {hertz:g} Hz by 12 deg: passes missed", missed, "",
                       None, 0.0)  # fmt: skip


HERTZ = (1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 15.0, 20.0)
DEGREES = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 11.0, 25.0)
FASTEST = 18.0  # of a hand, rad/s
LIMITS_UJ = {16384: 10.0, 4096: 16.0}


def measure_energy(run: Run) -> None:
    """Measure the energy that the motor returns to the user."""
    grid = [(hertz, degrees) for hertz, degrees in itertools.product(HERTZ, DEGREES)
            if 2.0 * math.pi * hertz * math.radians(degrees) <= FASTEST]  # fmt: skip
    for counts, hertz, (name, knob) in itertools.product(LIMITS_UJ, (4000, 1000), KNOBS.items()):
        worst = (0.0, "")
        for match in run.matches:
            places = [("start", 0.0), ("middle", 1.5), ("end", TURN)]
            places += [("goal", TURN * float(one)) for one in match.positions("goal")]
            for (place, about), (often, degrees) in itertools.product(places, grid):
                path = run.user.jiggling(about, often, degrees)
                course = stroke(match.frames, path, 2.7, knob, hertz, counts)
                what = f"{match.name}, {place}, {often:g} Hz, {degrees:g} deg"
                worst = max(worst, (1e6 * course.greatest_rise(1.2), what))
        board = f"{counts.bit_length() - 1} bits, {hertz} steps/s, {name}"
        run.table.line(f"{board}: any jiggle", worst[0], "uJ", None, LIMITS_UJ[counts])
        print(f"    {worst[1]}")
    sweep = thrown = held = 0.0
    for match, knob in itertools.product(run.matches, KNOBS.values()):
        for seconds in SWEEPS_S:
            course = stroke(match.frames, run.user.over(seconds, False), seconds, knob)
            sweep = max(sweep, course.greatest_rise())
        thrown = max(thrown, stroke(match.frames, flung(0.8, 0.3), 4.0, knob).greatest_rise())
        course = stroke(match.frames, run.user.stopping(0.5, 1.0, False), 4.0, knob)
        held = max(held, course.greatest_rise(1.5))
    for what, energy in (("sweeps", sweep), ("thrown and released", thrown), ("held", held)):
        run.table.line(what, 1e6 * energy, "uJ", None, 10.0)


def flung(reach: float, rest: float) -> HandPath:
    """Return a path that throws the knob by `reach` (rad) in 0.2 s after a rest and releases it."""
    return lambda time: np.where(
        time <= rest + 0.2, reach * (np.maximum(time - rest, 0.0) / 0.2) ** 2, math.nan
    )


def measure_wire(run: Run) -> None:
    """Compare the torques at delays of a wire that loses frames; the bits should be equal."""
    match = run.matches[0]
    torques = [
        simulate(match.surface, run.preset, run.sensor, glide(2.0), 2.3, delay * 1e-3).torque
        for delay in run.delays
    ]
    for delay, torque in zip(run.delays, torques, strict=True):
        differ = int((torque[: len(torques[0])] != torques[0][: len(torque)]).sum())
        run.table.line(f"wire of {delay:g} ms: torques with other bits", differ, "", None, 0.0)


def measure_safety(run: Run) -> None:
    """Measure silence, ends and recoil."""
    match, table = run.matches[0], run.table
    course = simulate(match.surface, run.preset, run.sensor, glide(4.0), 3.0, 0.0, 0.0,
                      killed_at=1.5)  # fmt: skip
    after = course.time > 1.5 + TICK_S + 0.04
    table.line("host killed, 40 ms later", 1e3 * float(np.abs(course.torque[after]).max()), "mN m",
               None, 0.0)  # fmt: skip
    before = (course.time > 1.4) & (course.time < 1.5)
    table.line(
        "          and before", 1e3 * float(np.abs(course.torque[before]).max()), "mN m", 0.1
    )
    motor = BoardMotor()
    highest = 0.0
    for _ in range(8000):
        motor.loop(b"")
        motor.step(0.01 * math.sin(20.0 * motor.time))
        highest = max(highest, abs(motor.torque))
    table.line("power on, no data, the knob turned", 1e3 * highest, "mN m", None, 0.0)
    for (name, knob), (place, target) in itertools.product(
        KNOBS.items(), (("end", 1.25 * TURN), ("start", -0.25 * TURN))
    ):
        push = functools.partial(lambda target, time: target * np.minimum(time, 1.0), target)
        yielding = stroke(match.frames, push, 3.0, knob, stiffness=0.02)
        held = yielding.time > 2.5
        print(f"pushed 45 deg beyond the {place} with 20 mN m/rad, {name} knob")
        table.line("    torque", 1e3 * float(np.abs(yielding.torque[held]).min()), "mN m", 3.0)
        beyond = yielding.angle[held] - TURN if place == "end" else -yielding.angle[held]
        table.line("    it yields by", math.degrees(float(beyond.max())), "deg", None, 8.0)
        table.line("    and moves, peak to peak", math.degrees(float(np.ptp(beyond))), "deg",
                   None, 0.2)  # fmt: skip
    for (name, knob), reach in itertools.product(KNOBS.items(), (74.0, 144.0)):

        def tapped(time: np.ndarray, reach: float = math.radians(reach)) -> np.ndarray:
            return np.where(time < 0.25, reach * np.minimum(time / 0.15, 1.0), math.nan)

        released = stroke(match.frames, tapped, 3.0, knob)
        took = float(released.time[released.angle > math.radians(18.0)][-1]) - 0.25
        table.line(f"a tap to {reach:g} deg, {name} knob: back within 18 deg after", took, "s",
                   None, 1.5)  # fmt: skip


def measure_sound(run: Run) -> None:
    """Measure the time from an event on the board's disk to the same event in the sound."""
    match = run.matches[0]
    surface = match.surface
    for delay_ms in run.delays:
        late: list[float] = []
        for seconds in (2.0, 4.0):
            course = simulate(surface, run.preset, run.sensor, glide(seconds), seconds + 0.5,
                              delay_ms * 1e-3, timeline=match.timeline)  # fmt: skip
            for at, event in enumerate(surface.event):
                passes = int(np.argmax(course.disk >= surface.edges[at, 0]))
                if passes and 0.1 < surface.position[at] < 0.95 and event in course.strike_times:
                    late.append(1e3 * (course.strike_times[event] - course.time[passes]))
        low, middle, high = np.percentile(late, [5.0, 50.0, 95.0])
        most = delay_ms * (1.0 + 0.5 * JITTER) + 10.0
        run.table.line(f"{delay_ms:g} ms: sound after force, median", middle, "ms", -10.0, most)
        run.table.line("    5 % point", low, "ms", -10.0, None)
        run.table.line("    95 % point", high, "ms", None, most + 10.0)


MEASURED = {
    "events": measure_events,
    "energy": measure_energy,
    "wire": measure_wire,
    "safety": measure_safety,
    "sound": measure_sound,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    parser.add_argument("--data", type=Path, help="folder of matches",
                        default=Path(folder) / "football" if folder else None)  # fmt: skip
    parser.add_argument("--matches", type=int, default=11, help="number of matches")
    parser.add_argument("--preset", default="football")
    parser.add_argument("--sensor", default="simplefoc", help="profile of the knob")
    parser.add_argument(
        "--delays", type=float, nargs="+", default=DELAYS_MS, help="delays each way, ms"
    )
    parser.add_argument("--only", choices=MEASURED)
    options = parser.parse_args()
    sensor, preset = load_sensor(options.sensor), ov.load_preset(options.preset)
    played = []
    for name, timeline in itertools.islice(matches(options.data, options.matches), options.matches):
        surface = ov.build_surface(timeline, preset)
        played.append(Match(name, timeline, surface, frames_for(surface, preset, sensor)))
    run = Run(Table(), played, sensor, preset, User(sensor, preset), options.delays)
    for name, measure in MEASURED.items():
        if options.only in (None, name):
            measure(run)
    print(f"{run.table.failures} figures are beyond their limits")
    sys.exit(min(run.table.failures, 100))


if __name__ == "__main__":
    main()
