"""Write the bundled presets' feel reports (presets/feel/NAME.json), as `presets feel` prints them.

Each holds what an observer tells apart too, on random timelines of the preset's kinds (`presets
feel --observer`), with a digest of the preset it was asked about. That takes most of the time;
--no-observer keeps what the file has of it.

python tools/measure_presets.py [--no-observer] [NAME ...]
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.batch.cache_keys import KEY_DIGITS, preset_digest
from overview_dsp.rendering.audition import pages

FOLDER = Path(__file__).parent.parent / "presets" / "feel"


def observed(preset: ov.Preset) -> dict[str, Any]:
    """What an observer tells apart on random timelines, in both sorts of hands."""
    found: dict[str, Any] = {"preset_digest": preset_digest(preset)[:KEY_DIGITS], "strokes": []}
    for hands in ("steady", "mixed"):
        (scores,) = (report := ov.measure.observe(preset, hands=hands)).to_json()["sets"]
        found |= {"learned": report.learned, "timelines": scores["timelines"]}
        found["strokes"] += scores["strokes"]
    return found


def lines_of(report: dict[str, Any]) -> str:
    """JSON with a line for each stroke, so that a change of one is seen as one."""
    parts = [f'"{key}": {json.dumps(report[key])}' for key in ("preset", "timeline")]
    parts.append(f'"strokes": {_rows(report["strokes"])}')
    if "observer" in report:
        observer = dict(report["observer"])
        rows = _rows(observer.pop("strokes"))
        parts.append(f'"observer": {json.dumps(observer)[:-1]}, "strokes": {rows}}}')
    return f"{{{', '.join(parts)}}}\n"


def _rows(rows: list[Any]) -> str:
    return "[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--no-observer", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    FOLDER.mkdir(exist_ok=True)
    for name in options.names or ov.bundled_presets():
        path = FOLDER / f"{name}.json"
        preset = ov.load_preset(name)
        found = ov.measure.feel_report(preset, pages(preset))
        report = found.to_json()
        if not options.no_observer:
            report["observer"] = observed(preset)
        elif path.is_file():
            before = json.loads(path.read_text(encoding="utf-8"))
            report |= {"observer": before["observer"]} if "observer" in before else {}
        path.write_text(lines_of(report), encoding="utf-8", newline="\n")
        print(f"{name}: {len(found.warnings())} warnings", flush=True)


if __name__ == "__main__":
    main()
