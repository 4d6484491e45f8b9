"""Lists for PsychoPy: one conditions file per list, and the stimuli as WAV files.

PsychoPy reads a list by
``data.TrialHandler2(data.importConditions("list-07.csv"), nReps=1, method="sequential")``.
Its reader requires header names of letters, digits and underscores.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from overview_dsp.cli.extensions import atomic_folder, sound_bytes
from overview_dsp.errors import InputError
from overview_studies.design import ADAPTIVE, Design
from overview_studies.folder import make_lists, presented_stimuli
from overview_studies.static_mapping import static_mapping
from overview_studies.stimuli import RATE, stimuli_of
from overview_studies.tables import csv_text

FIRST_LIST = "list-01.csv"
_FIRST = ("trial_id", "phase", "block", "repeat")
_LAST = ("sound_file", "sound_file_2", "click_db", "tactor_db", "correct_response")


def export_psychopy(
    design: Design, path: str | Path, progress: Callable[[float], None] | None = None
) -> int:
    """Write every list and its sounds; return the number of sounds.

    Raises
    ------
    InputError
        The participant makes the movement, or the task is adaptive. Neither has fixed sounds.
    """
    items = stimuli_of(design)
    lists = make_lists(design, items)
    if design.file.task.name in (*ADAPTIVE, "adjust"):
        raise InputError(
            f"{design.path}: task.name: PsychoPy requires a fixed sound per trial; "
            f"{design.file.task.name} does not have one (use PsychoPy's own QuestPlusHandler)"
        )
    if any(item.free for item in items):
        raise InputError(
            f"{design.path}: stimuli.gestures: PsychoPy requires fixed sounds; replace "
            '"free" by a gesture ("sweep:2")'
        )
    used, by = presented_stimuli(lists), {item.key: item for item in items}
    names = [_plain(name) for name in design.file.factors]
    with atomic_folder(path, FIRST_LIST) as folder:
        (folder / "sounds").mkdir()
        for number, (key, mappings) in enumerate(used.items(), 1):
            for mapping in mappings:
                samples = (
                    static_mapping(by[key], RATE).render(by[key].gesture)
                    if mapping == "static"
                    else by[key].render_stimulus().samples
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
