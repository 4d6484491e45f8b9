"""What football and the presets of curves promise to a hand, measured: tables in Markdown.

Of real matches (R, where OVERVIEW_TEST_DATA is a folder of them) and of random ones (F). What an
observer tells is the mean of several, each taught by other random matches and asked about others,
with five draws of noise; in brackets the least of them, and the limit. In the other tables, each
cell says how many cases fail the limit, of how many, and the worst one.

python tools/measure_feel.py [--preset NAME] [--observers N] [--random N] [PART ...]
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

import overview_dsp as ov  # noqa: E402
from tests.feel import curves, whole_matches  # noqa: E402
from tests.feel.whole_matches import Stroke  # noqa: E402

STROKES = ("1 s", "2 s", "4 s", "6 s", "recoil", "tap")
SWEEPS = (1.0, 2.0, 3.0, 4.0, 6.0)
CURVED = ("series", "stocks", "weather", "heart", "crowd", "plain")

# the least that is asked, of R and of F
Limits = Mapping[str, tuple[float, float]]
GOAL_LIMITS: Limits = {"1 s": (0.93, 0.90)} | dict.fromkeys(STROKES[1:], (0.95, 0.92))
CARD_LIMITS: Limits = dict.fromkeys(("2 s", "4 s", "6 s"), (0.85, 0.85)) | {"recoil": (0.65, 0.65)}
GROUP_LIMITS: Limits = {
    "2 s": (0.80, 0.75),
    "4 s": (0.88, 0.81),
    "6 s": (0.90, 0.85),
    "recoil": (0.70, 0.70),
    "tap": (0.74, 0.74),
}
KIND_LIMITS: Limits = {"2 s": (0.78, 0.73), "4 s": (0.86, 0.79), "6 s": (0.88, 0.85)}

Scored = Callable[[ov.measure.StrokeScores], float]
CARD_UNDER_DB, GOALLESS_DB, HALVING_DB, KNOCKS = 2.5, 2.5, 3.0, 0.6
LAG_MS, LAG_OF_95_MS = 24.0, 40.0
UNFOLDS_S = (0.9, 2.5)


def row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def heading(*cells: str) -> Iterator[str]:
    yield row(*cells)
    yield "|---" * len(cells) + "|"


def marked(holds: bool, text: str) -> str:
    return text if holds else f"**{text}**"


# --- what an observer tells -----------------------------------------------------------------------


def observed(
    preset: ov.Preset, real: Sequence[ov.Timeline], observers: int, held_out: int
) -> Iterator[str]:
    names = {"timelines given": "R", "random timelines": "F"}
    found: dict[str, list[ov.measure.SetScores]] = {}
    for seed in range(observers):
        report = ov.measure.observe(
            preset, real, modalities=("touch", "both"), held_out=held_out, seed=1000 * seed
        )
        for one in report.sets:
            found.setdefault(names[one.name], []).append(one)
    sets = [name for name in names.values() if name in found]
    yield from heading("an observer, by touch", "stroke", *sets)
    for title, limits, modality, scored in (
        ("goals, recall", GOAL_LIMITS, "touch", group("goal", "recall")),
        ("goals, precision", GOAL_LIMITS, "touch", group("goal", "precision")),
        ("cards, F1", CARD_LIMITS, "touch", group("card", "f1")),
        ("goal, card, minor: balanced", GROUP_LIMITS, "touch", lambda s: s.groups.balanced),
        ("seven kinds, with sound: balanced", KIND_LIMITS, "both", lambda s: s.kinds.balanced),
    ):
        for stroke, least in limits.items():
            cells = []
            for name in sets:
                values = [scored(one.strokes[stroke][modality]) for one in found[name]]
                limit = least[0 if name == "R" else 1]
                mean = float(np.mean(values))
                text = f"{mean:.3f} ({min(values):.2f}; {limit:.2f})"
                cells.append(marked(round(mean, 3) >= limit, text))
            yield row(title, stroke, *cells)


def group(name: str, value: str) -> Scored:
    def of(scores: ov.measure.StrokeScores) -> float:
        groups = scores.groups
        return float(getattr(groups, value)[groups.kinds.index(name)])

    return of


# --- levels and times of whole matches ------------------------------------------------------------


def crowded(preset: ov.Preset, sets: Mapping[str, Sequence[ov.Timeline]]) -> Iterator[str]:
    yield from heading("fails / of (worst)", "stroke", *sets)
    hands = {f"{seconds:g} s": ov.sweep(seconds) for seconds in SWEEPS} | {"tap": ov.tap(1.0, 3.0)}
    felt = {
        hand: {
            name: whole_matches.felt_strokes(matches, preset, gesture)
            for name, matches in sets.items()
        }
        for hand, gesture in hands.items()
    }

    def table(title: str, cell: Callable[[list[Stroke], str], str], ways: int) -> Iterator[str]:
        for hand, by_set in felt.items():
            for way in range(ways):
                parts = ([match[way] for match in found] for found in by_set.values())
                place = f"{hand}, recoil" if way else hand
                yield row(title, place, *(cell(part, hand) for part in parts))

    yield from table("card 2.5 dB under a goal, dB", card_cell, 2)
    yield from table("spread of equal goals, dB", spread_cell, 1)
    yield from table("red over yellow, medians, dB", red_cell, 1)
    yield from table("lag, median, 95 of 100, ms", lag_cell, 2)
    yield from table("close goals, two knocks", close_cell, 1)
    yield from table("goalless peak under goals, dB", goalless_cell, 2)
    yield from table("events not met", unmet_cell, 1)
    for fast, slow in ((1.0, 2.0), (2.0, 4.0), (3.0, 6.0)):
        cells = []
        for name in sets:
            pairs = zip(felt[f"{fast:g} s"][name], felt[f"{slow:g} s"][name], strict=True)
            over = [one[0].free_db - other[0].free_db for one, other in pairs]
            cells.append(failing([value < HALVING_DB for value in over], min(over)))
        yield row("halved sweep, event-free, dB", f"{slow:g} to {fast:g} s", *cells)
    cells, times = [], []
    for found in felt["tap"].values():
        knocks = sum(len(match[0].knocks_s) for match in found)
        there = sum(whole_matches.moments(match[0]) for match in found)
        cells.append(marked(knocks >= KNOCKS * there, f"{knocks} of {there}"))
        out, back = (np.array([match[way].length_s for match in found]) for way in (0, 1))
        holds = (out >= UNFOLDS_S[0]) & (out <= UNFOLDS_S[1]) & (back > out)
        text = f"{out.min():.2f} to {out.max():.2f}, back {back.min():.2f} to {back.max():.2f}"
        times.append(marked(bool(holds.all()), text))
    yield row("separate knocks of a full tap", "tap", *cells)
    yield row("unfolds and recoils in, s", "tap", *times)


def failing(fails: Sequence[bool], worst: float) -> str:
    return marked(not any(fails), f"{sum(fails)} / {len(fails)} ({worst:+.1f})")


def card_cell(parts: list[Stroke], _hand: str) -> str:
    over = [value for part in parts for value in whole_matches.cards_over_goals(part)]
    over = [value for value in over if np.isfinite(value)]
    return failing([value > -CARD_UNDER_DB for value in over], max(over))


def spread_cell(parts: list[Stroke], hand: str) -> str:
    spreads = [whole_matches.spread_of_goals(part) for part in parts]
    spreads = [value for value in spreads if value > 0.0]
    if hand in ("1 s", "tap"):
        return f"- / {len(spreads)} ({max(spreads):+.1f})"
    limit = 6.0 if hand in ("4 s", "6 s") else 8.0
    return failing([value > limit for value in spreads], max(spreads))


def red_cell(parts: list[Stroke], _hand: str) -> str:
    red, yellow = (
        np.concatenate([part.level_db[part.kind == kind] for part in parts])
        for kind in ("red_card", "yellow_card")
    )
    over = float(np.nanmedian(red) - np.nanmedian(yellow))
    return marked(over > 0.0, f"{over:+.1f} ({len(red)} red)")


def lag_cell(parts: list[Stroke], _hand: str) -> str:
    lag = 1000.0 * np.concatenate([whole_matches.lags_s(part) for part in parts])
    median, most = np.percentile(lag, [50, 95])
    holds = median <= LAG_MS and most <= LAG_OF_95_MS
    return marked(bool(holds), f"{median:.1f}, {most:.1f} of {len(lag)} ({lag.max():.0f})")


def close_cell(parts: list[Stroke], hand: str) -> str:
    both = [felt for part in parts for felt in whole_matches.close_goals_felt(part)]
    text = f"{sum(both)} of {len(both)}"
    return text if hand in ("1 s", "tap") else marked(sum(both) >= 0.9 * len(both), text)


def goalless_cell(parts: list[Stroke], _hand: str) -> str:
    under = whole_matches.peaks_under_goals(parts)
    if not under:
        return "-"
    return marked(min(under) >= GOALLESS_DB, f"{min(under):.1f} ({len(under)} matches)")


def unmet_cell(parts: list[Stroke], _hand: str) -> str:
    unmet = sum(int(np.isnan(part.level_db).sum()) for part in parts)
    return marked(not unmet, f"{unmet} of {sum(len(part.kind) for part in parts)}")


# --- curves ---------------------------------------------------------------------------------------


def curved(data: Path | None) -> Iterator[str]:
    seconds = (2.0, 4.0, 8.0)
    with tempfile.TemporaryDirectory() as folder:
        loaded = curves.loader(Path(folder) / "year.csv")
        lessons = curves.shape_lessons(loaded)
        years = curves.real_share_years(data, loaded) if data else []
        shapes = (f"shapes told at {s:g} s, %" for s in seconds)
        thirds = (f"thirds told at {s:g} s, %" for s in seconds)
        yield from heading("preset", "felt, dB", "uneven by, dB", "heard, dB", *shapes, *thirds)
        for name in ("football", *CURVED):
            preset = ov.load_preset(name)
            steps = [curves.steps_of(preset, course) for course in curves.RAMPS]
            uneven = max(float(np.ptp(one)) for one in steps)
            low, high = curves.grain_db(preset)
            cells = [f"{min(one.sum() for one in steps):.1f}", f"{uneven:.1f}"]
            cells.append(f"{high - low:.1f} (up to {high:.0f})")
            told = name in CURVED[:3]
            for s in seconds:
                part = curves.shapes_told(lessons, preset, s).mean() if told else None
                cells.append("" if part is None else f"{100 * part:.0f}")
            for s in seconds:
                share = told and name != "weather" and years
                right = curves.thirds_told(loaded, years, preset, s) if share else None
                cells.append("" if right is None else f"{100 * right.mean():.0f}")
            yield row(name, *cells)


def show(lines: Iterable[str]) -> None:
    for line in lines:
        print(line, flush=True)
    print()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--preset", default="football", help="name or file")
    parser.add_argument("--observers", type=int, default=2)
    parser.add_argument("--random", type=int, default=60, help="matches")
    parser.add_argument("parts", nargs="*", metavar="PART", help="observer, matches, curves")
    options = parser.parse_args()
    parts = options.parts or ["observer", "matches", "curves"]
    place = os.environ.get("OVERVIEW_TEST_DATA")
    data = Path(place) if place else None
    preset = ov.load_preset(options.preset)
    real = whole_matches.real_matches(data) if data else []
    if "observer" in parts:
        show(observed(preset, real, options.observers, options.random))
    if "matches" in parts:
        sets = {"R": real} if real else {}
        show(crowded(preset, sets | {"F": whole_matches.random_matches(options.random)}))
    if "curves" in parts:
        show(curved(data))


if __name__ == "__main__":
    main()
