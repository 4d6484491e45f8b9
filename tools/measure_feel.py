"""Measure the feel of football and of the presets of curves: Markdown tables with limits.

R are five real matches (external data, in the folder that OVERVIEW_TEST_DATA names), F are new
random ones. Each cell shows how many cases fail, of how many, and the worst; bold figures miss
their limit. Limits of the observer are for the mean of R and F.

python tools/measure_feel.py [--quick] [--preset NAME] [--random N] [--observers N] [--write] [PART]

Parts are observer, arm, levels, output, curves. --write puts the tables into
docs/explanation/observer.md, between its markers.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.signal import butter, resample_poly, sosfilt, sosfiltfilt

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

import overview_dsp as ov  # noqa: E402
from overview_dsp.design.gestures.scripts import CONTROL_RATE  # noqa: E402
from overview_dsp.measure import arm  # noqa: E402
from overview_dsp.measure.event_table import FeltEvents, stroke_events  # noqa: E402
from overview_dsp.offline.rendering.stems import ClickMeter, loudness_of  # noqa: E402
from tests.feel import curves  # noqa: E402
from tests.feel.whole_matches import CARDS, GOALS, real_files  # noqa: E402

PAGE = ROOT / "docs" / "explanation" / "observer.md"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"

ARMS, STEADY, SLOW = (1, 2, 4, 6), (1, 2, 4, 6), (15, 30)
SOUND_RATE, FEEL_RATE = 48_000, 16_000
FIRST_SEED = 700

# --- limits ---------------------------------------------------------------------------------------

ARM_LAG_MS = {1: (400, None), 2: (100, 220), 4: (60, 100), 6: (60, 100)}  # median, 95 %
STEADY_LAG_MS = {2: (None, 110), 4: (None, 110), 6: (None, 110)}
Limits = Mapping[str, float]


def at(pattern: str, values: Mapping[int, float]) -> dict[str, float]:
    return {pattern.format(seconds): value for seconds, value in values.items()}


CLASS_LIMITS: Limits = {
    **at("arm {} s", {1: 0.68, 2: 0.72, 4: 0.92, 6: 0.95}),
    **at("{} s", {1: 0.70, 2: 0.86, 4: 0.96, 6: 0.96, 15: 0.94, 30: 0.94}),
    "recoil": 0.74,
    "tap": 0.86,
}
GOAL_RECALL: Limits = {
    **at("arm {} s", {1: 0.91, 2: 0.94, 4: 0.97, 6: 0.97}),
    **at("{} s", dict.fromkeys((*STEADY, *SLOW), 0.94)),
}
GOAL_PRECISION: Limits = dict.fromkeys(GOAL_RECALL, 0.93)
CARD_F1: Limits = dict.fromkeys(CLASS_LIMITS, 0.83)

TURN_WITHIN = 0.012
TAPS = (0.1, 0.25, 0.4, 0.55, 0.7, 0.8, 0.9, 0.97)
PACES = (0.25, 0.5, 1.0, 2.0, 4.0)
SWIPE_TO = 0.6
SPREAD_DB, RECOIL_SPREAD_DB, LAST_PART = 6.0, 9.0, 0.98
EARLY_GOAL, MIDDLE_GOAL, EARLY_DB = 0.06, 0.5, 3.0
NEAR_WEAKEST_SHARE = 10 / 150
CURVE_DB, THIRDS, SHAPES = 3.8, 0.80, {2.0: 0.90, 4.0: 0.95, 8.0: 0.95}
GOAL_CLICK_MS, CLICK_MS = (5.0, 20.0), 50.0
TREMOR, TREMOR_HZ, TREMOR_S, TREMOR_CLICKS = 0.001, (6.0, 12.0), 5.5, 1
LUFS, PEAK_DB, TEXTURE_DB, TEXTURE_HZ = -28.0, -1.0, -45.0, 500.0

Sets = Mapping[str, Sequence[ov.Timeline]]


def way_out(
    preset: ov.Preset, matches: Sequence[ov.Timeline], gesture: ov.Gesture
) -> list[FeltEvents]:
    return arm.outward(preset, matches, {"": gesture})[""]


def row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def heading(*cells: str) -> Iterator[str]:
    yield row(*cells)
    yield "|---" * len(cells) + "|"


def marked(holds: bool, text: str) -> str:
    return text if holds else f"**{text}**"


def judged(values: Sequence[float], limit: float, digits: int = 1, least: bool = False) -> str:
    """Return how many values are beyond a limit, of how many, and the worst."""
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return "-"
    fails = sum(value < limit if least else value > limit for value in known)
    worst = min(known) if least else max(known)
    return marked(not fails, f"{fails} of {len(known)} ({worst:.{digits}f})")


# --- what an observer identifies ------------------------------------------------------------------


def observed(
    preset: ov.Preset, real: Sequence[ov.Timeline], observers: int, held_out: int, learned: int
) -> Iterator[str]:
    names = {"timelines given": "R", "random timelines": "F"}
    found: dict[str, list[ov.measure.SetScores]] = {}
    for number in range(observers):
        report = ov.measure.observe(
            preset,
            real,
            modalities=("touch",),
            held_out=held_out,
            learned=learned,
            seed=1000 * number,
        )
        for one in report.sets:
            found.setdefault(names[one.name], []).append(one)
    sets = [name for name in names.values() if name in found]
    yield from heading("by touch alone", "stroke", *sets, "mean", "limit")
    for title, limits, scored in (
        ("goal, card, minor: mean recall", CLASS_LIMITS, lambda s: s.groups.balanced),
        ("goals, recall", GOAL_RECALL, group("goal", "recall")),
        ("goals, precision", GOAL_PRECISION, group("goal", "precision")),
        ("cards, F1", CARD_F1, group("card", "f1")),
    ):
        for stroke, least in limits.items():
            means = [
                float(np.nanmean([scored(one.strokes[stroke]["touch"]) for one in found[name]]))
                for name in sets
            ]
            mean = float(np.mean(means))
            cells = (f"{value:.3f}" for value in means)
            yield row(
                title,
                stroke,
                *cells,
                marked(round(mean, 3) >= least, f"{mean:.3f}"),
                f"{least:.2f}",
            )


def group(name: str, value: str) -> Callable[[ov.measure.StrokeScores], float]:
    def of(scores: ov.measure.StrokeScores) -> float:
        groups = scores.groups
        return float(getattr(groups, value)[groups.kinds.index(name)])

    return of


# --- an arm: lag, events never met, taps, scrubbing -----------------------------------------------


def arms(preset: ov.Preset, sets: Sets) -> Iterator[str]:
    yield from heading("an arm and a sweep", "stroke", "limit", *sets)
    gestures = {f"arm {s} s": ov.arm(s) for s in ARMS} | {"flick 0.15 s": ov.flick(0.15)}
    gestures |= {f"sweep {s} s": ov.sweep(s) for s in STEADY}
    tables = {
        name: {key: way_out(preset, matches, gesture) for key, matches in sets.items()}
        for name, gesture in gestures.items()
    }
    for name, by_set in tables.items():
        yield row(
            "never met: events, goals",
            name,
            "0, 0",
            *(unreached_events(one) for one in by_set.values()),
        )
    for pattern, limits in (("arm {} s", ARM_LAG_MS), ("sweep {} s", STEADY_LAG_MS)):
        for seconds, (middle, most) in limits.items():
            limit = ", ".join("-" if value is None else f"{value}" for value in (middle, most))
            cells = (lag(one, middle, most) for one in tables[pattern.format(seconds)].values())
            yield row("lag, ms: median, 95 % (worst)", pattern.format(seconds), limit, *cells)
    for name, by_set in tables.items():
        cells = (lag(one, None, None, "lag_percent") for one in by_set.values())
        yield row("lag, % of the timeline", name, "-", *cells)
    for name, by_set in tables.items():
        cells = (felt_goals(one) for one in by_set.values())
        yield row("goals felt, above every foul", name, "-", *cells)
    for hz in arm.SCRUB_HZ:
        yield row(
            "scrubbing a goal: crossings felt, followed",
            f"{hz:g} Hz",
            "all",
            *(scrubs(preset, matches, hz) for matches in sets.values()),
        )
    for target in TAPS:
        turns = [turned(preset, matches, ov.tap(target, 1.5), target) for matches in sets.values()]
        yield row("a tap turns back, off by", f"tap:{target:g}:1.5", f"{TURN_WITHIN}", *turns)
    for pace in PACES:
        gesture = swipe(pace)
        turns = [turned(preset, matches, gesture, SWIPE_TO) for matches in sets.values()]
        name = f"to {SWIPE_TO:g} at {pace:g} timelines/s"
        yield row("released at full pace, off by", name, f"{TURN_WITHIN}", *turns)


def swipe(pace: float) -> ov.Gesture:
    """Return a steady movement that releases without slowing down."""
    moving = ov.sweep(SWIPE_TO / pace, 0.0, SWIPE_TO)
    times = np.append(moving.time_s[:-1], moving.time_s[-2])
    return ov.Gesture(times, moving.theta2, moving.touching, float(times[-1]))


def unreached_events(tables: Sequence[FeltEvents]) -> str:
    counts = []
    for kinds in ((), GOALS):
        rows = [(one.of(*kinds) & ~one.reached, one.of(*kinds)) for one in tables]
        counts.append([sum(int(part[i].sum()) for part in rows) for i in (0, 1)])
    (missed, of), (goals, of_goals) = counts
    return marked(not missed, f"{missed} of {of}, {goals} of {of_goals}")


def lag(
    tables: Sequence[FeltEvents],
    middle: float | None,
    most: float | None,
    column: str = "lag_ms",
) -> str:
    values = np.concatenate([getattr(one, column)[one.of()] for one in tables])
    found = arm.percentiles(values)
    holds = all(
        limit is None or value <= limit
        for value, limit in zip(found[:2], (middle, most), strict=True)
    )
    digits = 0 if column == "lag_ms" else 1
    median, p95, worst = (f"{value:.{digits}f}" for value in found)
    return marked(holds, f"{median}, {p95} ({worst})")


def felt_goals(tables: Sequence[FeltEvents]) -> str:
    felt = sum(int(arm.felt_above(one, one.of(*GOALS), "foul").sum()) for one in tables)
    return f"{felt} of {sum(int(one.of(*GOALS).sum()) for one in tables)}"


def scrubs(preset: ov.Preset, matches: Sequence[ov.Timeline], hz: float) -> str:
    found = [both for one in arm.scrubbed(preset, matches, GOALS, hz) for both in one]
    followed, felt = (sum(one[i] for one in found) for i in (0, 1))
    return marked(felt == len(found), f"{felt}, {followed} of {len(found)}")


def turned(
    preset: ov.Preset, matches: Sequence[ov.Timeline], gesture: ov.Gesture, target: float
) -> str:
    off = [abs(one.turn - target) for one in way_out(preset, matches, gesture)]
    return judged(off, TURN_WITHIN, 3)


# --- levels of whole matches ----------------------------------------------------------------------


def levels(preset: ov.Preset, sets: Sets) -> Iterator[str]:
    yield from heading("levels: fails of (worst)", "stroke", "limit", *sets)
    gestures = {f"sweep {s} s": ov.sweep(s) for s in STEADY} | {
        f"arm {s} s": ov.arm(s) for s in ARMS
    }
    gestures |= {"tap": ov.tap(1.0, 3.0)}
    out = {
        name: {key: way_out(preset, matches, gesture) for key, matches in sets.items()}
        for name, gesture in gestures.items()
    }
    for name, by_set in out.items():
        last = LAST_PART if name.startswith("arm") else 1.0
        cells = (judged(spreads(tables, last), SPREAD_DB) for tables in by_set.values())
        yield row("spread of equal goals, dB", name, f"{SPREAD_DB:g}", *cells)
    for name in (f"arm {s} s" for s in ARMS):
        cells = (last_goals(tables) for tables in out[name].values())
        yield row("goals in the last 2 %, dB under the strongest", name, "-", *cells)
    for name, by_set in out.items():
        every = ([over for one in t for over in arm.cards_over_goals(one)] for t in by_set.values())
        cells = (judged(over, -arm.CARD_MARGIN_DB) for over in every)
        yield row("card over the goal before it, dB", name, f"{-arm.CARD_MARGIN_DB:g}", *cells)
    for name, by_set in out.items():
        cells = (red_over_yellow(tables) for tables in by_set.values())
        yield row("red over yellow, medians, dB", name, "> 0", *cells)
    back = {key: recoils(preset, matches) for key, matches in sets.items()}
    yield row(
        "spread of equal goals, dB",
        "recoil",
        f"{RECOIL_SPREAD_DB:g}",
        *(judged(spreads(tables, 1.0), RECOIL_SPREAD_DB) for tables in back.values()),
    )
    near = [near_weakest(tables) for tables in back.values()]
    holds = sum(close for close, _ in near) <= NEAR_WEAKEST_SHARE * sum(of for _, of in near)
    cells = (marked(holds, f"{close} of {of}") for close, of in near)
    yield row("cards within 2.5 dB of the weakest goal", "recoil", "10 of 150 in all", *cells)
    yield row("red over yellow, medians, dB", "recoil", "> 0", *map(red_over_yellow, back.values()))
    two = (
        recoils(preset, [with_two_goals(match) for match in matches]) for matches in sets.values()
    )
    cells = (judged([arm.spread_db(one, "goal") for one in tables], EARLY_DB) for tables in two)
    yield row("a goal at 6 % against one at 50 %, dB", "recoil", f"{EARLY_DB:g}", *cells)
    sweep = {key: way_out(preset, matches, ov.sweep(4.0)) for key, matches in sets.items()}
    ranges = [[arm.felt_range_db(one) for one in tables] for tables in sweep.values()]
    medians = (
        marked(
            bool(np.nanmedian(values) >= CURVE_DB),
            f"{np.nanmedian(values):.1f} ({min(values):.1f})",
        )
        for values in ranges
    )
    yield row(
        "felt range of the curve, dB: median (flattest)", "sweep 4 s", f"{CURVE_DB}", *medians
    )


def recoils(preset: ov.Preset, matches: Sequence[ov.Timeline]) -> list[FeltEvents]:
    """Return the recoil of a sweep of 2 s over each match."""
    jobs = [ov.RenderJob(match, preset, ov.sweep(2.0)) for match in matches]
    return [list(stroke_events(done))[1] for done in ov.render_many(jobs, FEEL_RATE, trace=True)]


def spreads(tables: Sequence[FeltEvents], last: float) -> list[float]:
    return [
        arm.spread_db(one, "goal", last)
        for one in tables
        if (one.of("goal") & one.reached & (one.position <= last)).sum() > 1
    ]


def last_goals(tables: Sequence[FeltEvents]) -> str:
    found = []
    for one in tables:
        goals = one.of("goal") & one.reached
        late = goals & (one.position > LAST_PART)
        if late.any() and (goals & ~late).any():
            found += (one.level_db[goals].max() - one.level_db[late]).tolist()
    return ", ".join(f"{value:.1f}" for value in found) or "none"


def red_over_yellow(tables: Sequence[FeltEvents]) -> str:
    by_kind = [
        np.concatenate([one.level_db[one.of(kind) & one.reached] for one in tables])
        for kind in ("red_card", "yellow_card")
    ]
    if not all(len(values) for values in by_kind):
        return "-"
    over = float(np.median(by_kind[0]) - np.median(by_kind[1]))
    return marked(over > 0.0, f"{over:+.1f} ({len(by_kind[0])} red)")


def near_weakest(tables: Sequence[FeltEvents]) -> tuple[int, int]:
    """Return how many cards are within 2.5 dB of their match's weakest goal, and of how many."""
    near = count = 0
    for one in tables:
        goals = one.level_db[one.of(*GOALS) & one.reached]
        cards = one.level_db[one.of(*CARDS) & one.reached]
        if len(goals):
            count += len(cards)
            near += int((cards > goals.min() - arm.CARD_MARGIN_DB).sum())
    return near, count


def with_two_goals(match: ov.Timeline) -> ov.Timeline:
    """Return a match with a goal early and one in the middle in place of its own."""
    rest = [event for event in match.events if event.kind not in GOALS]
    goals = [ov.Event(part * match.duration_s, "goal") for part in (EARLY_GOAL, MIDDLE_GOAL)]
    return replace(match, events=tuple(sorted([*rest, *goals], key=lambda event: event.time_s)))


# --- click and vibration, tremor, loudness --------------------------------------------------------


def output(preset: ov.Preset, sets: Sets) -> Iterator[str]:
    yield from heading("click and vibration", "stroke", "limit", *sets)
    gestures = {f"sweep {s} s": ov.sweep(s) for s in STEADY} | {
        f"arm {s} s": ov.arm(s) for s in ARMS
    }
    for name, gesture in gestures.items():
        both = {key: there_and_back(preset, matches, gesture) for key, matches in sets.items()}
        for way in (0, 1) if name.startswith("sweep") else (0,):
            stroke = f"{name}, recoil" if way else name
            parts = [[ways[way] for ways in found if len(ways) > way] for found in both.values()]
            cells = (click_lag(part, GOALS, GOAL_CLICK_MS) for part in parts)
            limit = ", ".join(f"{value:g}" for value in GOAL_CLICK_MS)
            yield row("click to vibration, goals, ms: median, 95 %", stroke, limit, *cells)
            cells = (click_lag(part, (), (np.inf, CLICK_MS)) for part in parts)
            yield row("the same, all events", stroke, f"-, {CLICK_MS:g}", *cells)
    cells = (judged(tremor(preset, matches), TREMOR_CLICKS, 0) for matches in sets.values())
    name = f"{100 * TREMOR:g} % rms at a goal's edge"
    yield row(f"clicks in {TREMOR_S:g} s of tremor", name, f"{TREMOR_CLICKS}", *cells)
    cells = (judged(loudness(preset, m), LUFS, least=True) for m in sets.values())
    yield row("loudness of the click, LUFS", "sweep 4 s", f"{LUFS:g}", *cells)
    for name, gesture in (("flick 0.15 s", ov.flick(0.15)), ("arm 1 s", ov.arm(1.0))):
        cells = (judged(true_peaks(preset, matches, gesture), PEAK_DB) for matches in sets.values())
        yield row("true peak, dB", name, f"{PEAK_DB:g}", *cells)
    for seconds in (2.0, 4.0, 8.0):
        cells = (
            judged(textures(preset, matches, seconds), TEXTURE_DB, least=True)
            for matches in sets.values()
        )
        yield row("texture above 500 Hz, dBFS", f"sweep {seconds:g} s", f"{TEXTURE_DB:g}", *cells)


def there_and_back(
    preset: ov.Preset, matches: Sequence[ov.Timeline], gesture: ov.Gesture
) -> list[list[FeltEvents]]:
    jobs = [ov.RenderJob(match, preset, gesture) for match in matches]
    return [list(stroke_events(done)) for done in ov.render_many(jobs, FEEL_RATE, trace=True)]


def click_lag(
    tables: Sequence[FeltEvents], kinds: Sequence[str], limits: tuple[float, float]
) -> str:
    values = np.concatenate(
        [one.click_lag_ms[np.isin(one.kind, kinds) if kinds else ...] for one in tables]
    )
    found = arm.percentiles(values)
    holds = found[0] <= limits[0] and found[1] <= limits[1]
    return marked(holds, f"{found[0]:.1f}, {found[1]:.1f} ({found[2]:.0f})")


def tremor(preset: ov.Preset, matches: Sequence[ov.Timeline]) -> list[int]:
    """Count the clicks while a finger that trembles rests at the edge of each goal."""
    jobs: list[ov.RenderJob] = []
    settled_s = 3.0
    for match in matches:
        surface = ov.build_surface(match, preset)
        for position, event in zip(surface.edges[:, 0], surface.event, strict=True):
            if match.events[event].kind in GOALS:
                gesture = trembling(float(position), settled_s, len(jobs))
                jobs.append(ov.RenderJob(match, preset, gesture))
    return [
        int((done.strikes.of_events().time_s > settled_s).sum())
        for done in ov.render_many(jobs, FEEL_RATE, tail="none")
    ]


def trembling(position: float, settled_s: float, seed: int) -> ov.Gesture:
    """Return the gesture of a finger that trembles at a position, before and after it settles."""
    count = round((settled_s + TREMOR_S) * CONTROL_RATE)
    noise = np.random.default_rng(seed).standard_normal(count)
    sos = butter(2, TREMOR_HZ, "bandpass", fs=CONTROL_RATE, output="sos")
    shake = sosfiltfilt(sos, noise)
    times = np.arange(count + 1) / CONTROL_RATE
    positions = np.clip(position + TREMOR * shake / shake.std(), 0.0, 1.0)
    positions = np.append(positions, positions[-1])
    return ov.Gesture(times, positions * np.pi, np.arange(count + 1) < count, float(times[-1]))


def loudness(preset: ov.Preset, matches: Sequence[ov.Timeline]) -> list[float]:
    found = []
    for done in sounded(preset, matches, ov.sweep(4.0)):
        meter = ClickMeter(SOUND_RATE)
        meter.feed(done.samples)
        found.append(loudness_of(meter.steps()) or -np.inf)
    return found


def true_peaks(
    preset: ov.Preset, matches: Sequence[ov.Timeline], gesture: ov.Gesture
) -> list[float]:
    """Return the highest peak between samples of each match, both channels, dB (BS.1770-4)."""
    return [
        20.0 * float(np.log10(np.abs(resample_poly(done.samples, 4, 1, axis=0)).max()))
        for done in sounded(preset, matches, gesture)
    ]


def textures(preset: ov.Preset, matches: Sequence[ov.Timeline], seconds: float) -> list[float]:
    """Return the level above 500 Hz of each match's click channel without its events, dBFS."""
    bare = [replace(match, events=()) for match in matches]
    sos = butter(4, TEXTURE_HZ, "highpass", fs=SOUND_RATE, output="sos")
    found = []
    for done in sounded(preset, bare, ov.sweep(seconds)):
        middle = slice(round(0.1 * seconds * SOUND_RATE), round(0.9 * seconds * SOUND_RATE))
        power = np.mean(sosfilt(sos, done.samples[:, 0].astype(float))[middle] ** 2)
        found.append(10.0 * float(np.log10(power + 1e-20)))
    return found


def sounded(
    preset: ov.Preset, matches: Sequence[ov.Timeline], gesture: ov.Gesture
) -> Iterator[ov.RenderedJob[None]]:
    jobs = [ov.RenderJob(match, preset, gesture) for match in matches]
    return ov.render_many(jobs, SOUND_RATE, tail=arm.TAIL_S)


# --- curves ---------------------------------------------------------------------------------------


def curved(data: Path | None) -> Iterator[str]:
    presets = ("football", "series", "stocks", "weather", "heart", "crowd", "plain")
    with tempfile.TemporaryDirectory() as folder:
        loaded = curves.loader(Path(folder) / "year.csv")
        lessons = curves.shape_lessons(loaded)
        years = curves.real_share_years(data, loaded) if data else []
        shapes = (f"five shapes, {s:g} s, % ({100 * SHAPES[s]:g})" for s in SHAPES)
        thirds = ("thirds, 2 s, %", "4 s, %", f"mean, % ({100 * THIRDS:g})")
        titles = ("curve from .1 to .9", "felt, dB", "uneven by, dB", "heard, dB")
        yield from heading(*titles, *shapes, *thirds)
        for name in presets:
            preset = ov.load_preset(name)
            steps = [curves.steps_of(preset, course) for course in curves.RAMPS]
            uneven = max(float(np.ptp(one)) for one in steps)
            low, high = curves.grain_db(preset)
            cells = [f"{min(one.sum() for one in steps):.1f}", f"{uneven:.1f}"]
            cells.append(f"{high - low:.1f} (up to {high:.0f})")
            for s, least in SHAPES.items():
                if name not in ("series", "stocks", "weather"):
                    cells.append("")
                    continue
                part = float(curves.shapes_told(lessons, preset, s).mean())
                cells.append(marked(part >= least, f"{100 * part:.0f}"))
            if name in ("series", "stocks") and years:
                told = [curves.thirds_told(loaded, years, preset, s).mean() for s in (2.0, 4.0)]
                mean = float(np.mean(told))
                cells += [f"{100 * part:.0f}" for part in told]
                cells.append(marked(mean >= THIRDS, f"{100 * mean:.0f}"))
            else:
                cells += ["", "", ""]
            yield row(name, *cells)


# --- the command ----------------------------------------------------------------------------------


def print_lines(lines: Iterable[str]) -> list[str]:
    found = []
    for line in lines:
        print(line, flush=True)
        found.append(line)
    print()
    return [*found, ""]


def write(lines: Sequence[str]) -> None:
    """Put the tables between the markers of the page."""
    before, found, rest = PAGE.read_text().partition(BEGIN)
    _, ended, after = rest.partition(END)
    if not found or not ended:
        raise SystemExit(f"{PAGE}: {BEGIN} or {END} is missing")
    PAGE.write_text("\n".join([f"{before}{BEGIN}", "", *lines, f"{END}{after}"]))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", default="football", help="name or file")
    parser.add_argument("--observers", type=int, default=4)
    parser.add_argument("--random", type=int, default=20, help="number of random matches")
    parser.add_argument("--quick", action="store_true", help="few random matches, one observer")
    parser.add_argument("--write", action="store_true", help=f"write to {PAGE.name}")
    parser.add_argument("parts", nargs="*", metavar="PART")
    options = parser.parse_args()
    warnings.simplefilter("ignore", ov.OverviewWarning)
    count, observers = (5, 1) if options.quick else (options.random, options.observers)
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    data = Path(folder) if folder else None
    preset = ov.load_preset(options.preset)
    real = [ov.load_timeline(file) for file in real_files(data)] if data else []
    fresh = [ov.measure.random_match(FIRST_SEED + number) for number in range(count)]
    sets: Sets = {**({"R": real} if real else {}), "F": fresh}
    held_out, learned = (10, 40) if options.quick else (60, 120)
    parts: dict[str, Callable[[], Iterator[str]]] = {
        "observer": lambda: observed(preset, real, observers, held_out, learned),
        "arm": lambda: arms(preset, sets),
        "levels": lambda: levels(preset, sets),
        "output": lambda: output(preset, sets),
        "curves": lambda: curved(data),
    }
    unknown = set(options.parts) - set(parts)
    if unknown:
        parser.error(f"PART is {', '.join(sorted(unknown))}; must be one of {', '.join(parts)}")
    started = time.perf_counter()
    counts = ", ".join(f"{name}: {len(matches)} matches" for name, matches in sets.items())
    lines = print_lines([f"{preset.name}; {counts}; observers: {observers}", ""])
    for name in options.parts or parts:
        lines += print_lines(parts[name]())
    print(f"{time.perf_counter() - started:.0f} s", file=sys.stderr)
    if options.write:
        write(lines)


if __name__ == "__main__":
    main()
