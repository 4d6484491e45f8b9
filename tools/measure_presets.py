"""Write the bundled presets' feel reports (presets/feel/NAME.json), as `presets feel` prints them.

python tools/measure_presets.py [NAME ...]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.measure.report import feel_report
from overview_dsp.rendering.audition import pages

FOLDER = Path(__file__).parent.parent / "presets" / "feel"


def lines_of(report: dict[str, Any]) -> str:
    """JSON with a line for each stroke, so that a change of one is seen as one."""
    strokes = ",\n".join(json.dumps(stroke) for stroke in report["strokes"])
    head = json.dumps({key: value for key, value in report.items() if key != "strokes"})
    return f'{head[:-1]}, "strokes": [\n{strokes}\n]}}\n'


def main(names: list[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in names or ov.bundled_presets():
        preset = ov.load_preset(name)
        report = feel_report(preset, pages(preset))
        text = lines_of(report.to_json())
        (FOLDER / f"{name}.json").write_text(text, encoding="utf-8", newline="\n")
        print(f"{name}: {len(report.warnings())} warnings")


if __name__ == "__main__":
    main(sys.argv[1:])
