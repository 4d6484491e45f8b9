"""Write the bundled presets' feel reports (presets/feel/NAME.json), as `presets feel` prints them.

Each holds what an observer tells apart too, on random timelines of the preset's kinds (`presets
feel --observer`), with a digest of the preset it was asked about. That takes most of the time;
--no-observer keeps what the file has of it.

With --characters it writes nothing, but prints by how many just noticeable steps any two presets
differ with their levels matched: in Markdown, the most of a match, a share, a recording and the
matches in OVERVIEW_TEST_DATA, where that is a folder of them.

python tools/measure_presets.py [--no-observer | --characters] [NAME ...]
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.batch.grid import KEY_DIGITS, preset_digest
from overview_dsp.measure.pictures import pages

FOLDER = Path(__file__).parent.parent / "presets" / "feel"


def observed(preset: ov.Preset) -> dict[str, Any]:
    """Return an observer's scores on random timelines, in all strokes and at mixed pace."""
    found: dict[str, Any] = {"preset_digest": preset_digest(preset)[:KEY_DIGITS], "strokes": []}
    for movement in ("all", "mixed"):
        (scores,) = (report := ov.measure.observe(preset, movement=movement)).to_json()["sets"]
        found |= {"learned": report.learned, "timelines": scores["timelines"]}
        found["strokes"] += scores["strokes"]
    return found


def lines_of(report: dict[str, Any]) -> str:
    """Return JSON with one line for each stroke, so that a diff shows which one changed."""
    parts = [f'"{key}": {json.dumps(report[key])}' for key in ("preset", "timelines")]
    parts.append(f'"strokes": {_rows(report["strokes"])}')
    parts.append(f'"arm": {json.dumps(report["arm"])}')
    if "observer" in report:
        observer = dict(report["observer"])
        rows = _rows(observer.pop("strokes"))
        parts.append(f'"observer": {json.dumps(observer)[:-1]}, "strokes": {rows}}}')
    return f"{{{', '.join(parts)}}}\n"


def _rows(rows: list[Any]) -> str:
    return "[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]"


def character_rows(names: Sequence[str]) -> Iterator[str]:
    """Yield the level-matched table: one row and one column for each preset."""
    timelines = [ov.load_timeline(name) for name in ("world-cup-final-2018", "made-up-share")]
    timelines.append(ov.measure.random_crowd(1))
    data = os.environ.get("OVERVIEW_TEST_DATA")
    if data:
        matches = sorted(Path(data, "football", "statsbomb").glob("*.json"))
        timelines += [ov.load_timeline(path) for path in matches]
    most: dict[tuple[str, str], float] = {}
    for timeline in timelines:
        with warnings.catch_warnings():
            # kinds of other data are felt as the default
            warnings.filterwarnings("ignore", "preset .* has no ", ov.OverviewWarning)
            found = {
                name: ov.measure.perceptual_features(ov.load_preset(name), timeline)
                for name in names
            }
        for one, other in itertools.combinations(names, 2):
            steps = ov.measure.level_matched_distance(found[one], found[other])
            most[one, other] = most[other, one] = max(steps, most.get((one, other), 0.0))
    yield f"| |{'|'.join(names)}|"
    yield "|---" * (len(names) + 1) + "|"
    for one in names:
        cells = (f"{most[one, other]:.1f}" if other != one else "" for other in names)
        yield f"|{one}|{'|'.join(cells)}|"
    (one, other), least = min(most.items(), key=lambda item: item[1])
    yield f"\nthe nearest: {one} and {other}, {least:.2f} steps"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--no-observer", action="store_true")
    parser.add_argument("--characters", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    if options.characters:
        for row in character_rows(options.names or ov.bundled_presets()):
            print(row, flush=True)
        return
    FOLDER.mkdir(exist_ok=True)
    for name in options.names or ov.bundled_presets():
        path = FOLDER / f"{name}.json"
        preset = ov.load_preset(name)
        found = ov.measure.feel_report(preset, pages(preset))
        arm = ov.measure.arm_report(preset, pages(preset))
        report = {**found.to_json(), "arm": arm.to_json()}
        if not options.no_observer:
            report["observer"] = observed(preset)
        elif path.is_file():
            before = json.loads(path.read_text(encoding="utf-8"))
            report |= {"observer": before["observer"]} if "observer" in before else {}
        path.write_text(lines_of(report), encoding="utf-8", newline="\n")
        print(f"{name}: {len(found.warnings())} warnings", flush=True)


if __name__ == "__main__":
    main()
