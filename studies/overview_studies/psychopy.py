"""Lists for PsychoPy: a conditions file each, and the stimuli as WAV files.

Python there reads one by
``data.TrialHandler2(data.importConditions("list-07.csv"), nReps=1, method="sequential")``.
Header names are letters, digits and underscores, as its reader wants them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from overview_dsp.cli.extensions import atomic_folder, sound_bytes
from overview_dsp.errors import InputError
from overview_studies.design import ADAPTIVE, Design
from overview_studies.folder import make_lists, played
from overview_studies.items import RATE, items_of
from overview_studies.static_mapping import static_mapping
from overview_studies.tables import csv_text

MARK = "list-01.csv"
_FIRST = ("trial_id", "phase", "block", "repeat")
_LAST = ("sound_file", "sound_file_2", "click_db", "tactor_db", "correct_response")


def export_psychopy(
    design: Design, path: str | Path, progress: Callable[[float], None] | None = None
) -> int:
    """Write every list and the sounds that they name; how many sounds.

    Raises
    ------
    InputError
        A hand that is the person's own, an adaptive task: neither is a row of fixed sounds.
    """
    items = items_of(design)
    lists = make_lists(design, items)
    if design.file.task.name in (*ADAPTIVE, "adjust"):
        raise InputError(
            f"{design.where}: task.name: PsychoPy's conditions are fixed rows; "
            f"{design.file.task.name} has none (PsychoPy has a QuestPlusHandler of its own)"
        )
    if any(item.free for item in items):
        raise InputError(
            f"{design.where}: stimuli.gestures: PsychoPy plays sounds; a free hand has none, name "
            'a gesture ("sweep:2")'
        )
    used, by = played(lists), {item.key: item for item in items}
    names = [_plain(name) for name in design.file.factors]
    with atomic_folder(path, MARK) as folder:
        (folder / "sounds").mkdir()
        for number, (key, mappings) in enumerate(used.items(), 1):
            for mapping in mappings:
                samples = (
                    static_mapping(by[key], RATE).render(by[key].gesture)
                    if mapping == "static"
                    else by[key].rendered().samples
                )
                name = _sound(key, mapping)
                (folder / name).write_bytes(sound_bytes(name, samples, RATE, "PCM_24"))
            if progress is not None:
                progress(number / len(used))
        for one in lists:
            rows = [_row(step) for step in one["steps"] if step["type"] == "trial"]
            text = csv_text([*_FIRST, *names, *_LAST], rows)
            (folder / f"list-{one['list']:02d}.csv").write_text(text, encoding="utf-8")
    return sum(len(mappings) for mappings in used.values())


def _sound(key: str, mapping: str) -> str:
    return f"sounds/{key}.wav" if mapping == "friction" else f"sounds/{key}-{mapping}.wav"


def _plain(name: str) -> str:
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if plain[:1].isalpha() else f"f_{plain}"


def _row(step: dict[str, Any]) -> dict[str, Any]:
    output = step["output"]
    files = [_sound(key, output["mapping"]) for key in step["stimuli"]]
    return {
        "trial_id": step["id"],
        "phase": step["phase"],
        "block": step["block"],
        "repeat": step["repeat"],
        **{_plain(name): level for name, level in step["factors"].items()},
        "sound_file": files[0],
        "sound_file_2": files[1] if len(files) > 1 else None,
        "click_db": output["click_db"],
        "tactor_db": output["tactor_db"],
        "correct_response": step["correct"],
    }
