"""Replay of trials: the recorded movement of a participant with the same stimulus.

A take has the samples at which the kernel applied control events, so the render is bit-identical to
the output in any browser.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import Gesture, render, save_gesture
from overview_dsp.cli.extensions import CLICK, SOURCES, TACTOR, atomic_folder, sound_bytes
from overview_dsp.errors import InputError
from overview_studies.answers import Answers
from overview_studies.design import Design
from overview_studies.row_checks import is_take
from overview_studies.static_mapping import static_mapping
from overview_studies.steps import find_step
from overview_studies.stimuli import Stimulus, stimuli_of
from overview_studies.tables import csv_text

INDEX = "takes.csv"
COLUMNS = (
    "participant", "trial", "stimulus", "mapping", "timeline", "preset", "seed", "sample_rate",
    "duration_s", "events", "take", "sound",
)  # fmt: skip


def take_gesture(take: dict[str, Any]) -> Gesture:
    """Return the gesture of a take (docs/explanation/study-format.md).

    Raises
    ------
    InputError
        The take is not valid.
    """
    try:
        rate, samples = float(take["sample_rate"]), int(take["samples"])
        events = [(int(s), float(a), bool(h), str(by)) for s, a, h, by in take["events"]]
        if not events:
            raise ValueError("no events")
        at = np.array([sample for sample, *_ in events])
        return Gesture(
            at / rate,
            np.array([angle for _, angle, *_ in events]),
            np.array([holds for _, _, holds, _ in events]),
            max(samples, int(at[-1])) / rate,
            # key events belong to the touch input of the page
            np.array([SOURCES.index(by) if by in SOURCES else 0 for *_, by in events]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"take is not valid ({error})") from None


def replay_trial(
    item: Stimulus, take: dict[str, Any], output: dict[str, Any]
) -> NDArray[np.float32]:
    """Render the output of a trial: float32 (frames, 2), before the gains of the device.

    Parameters
    ----------
    output
        Output settings of the step: mapping and gains.
    """
    gesture, rate = take_gesture(take), round(take["sample_rate"])
    if output["mapping"] == "static":
        samples = static_mapping(item, rate).render(gesture, 0.0)
    else:
        samples = render(
            item.timeline, item.preset, gesture, rate, item.seed, tail="none", trace=False
        ).samples
    gains = np.zeros(2)
    for channel, gain_db in ((CLICK, output["click_db"]), (TACTOR, output["tactor_db"])):
        gains[channel] = 0.0 if gain_db is None else 10.0 ** (gain_db / 20.0)
    return samples * gains.astype(np.float32)


def _recorded_takes(
    answers: Answers,
) -> Iterator[tuple[str, str, dict[str, Any], str, dict[str, Any]]]:
    """Yield participant, trial, step, key and take of each trial with a movement."""
    for session in answers.sessions:
        for trial, _, row in session.trials:
            step = find_step(trial, answers.lists[session.number])
            if step is None:
                continue
            found: list[tuple[str, Any, Any]] = [(trial, row.get("stimulus"), row.get("take"))]
            for number, take in enumerate(row.get("takes") or [], 1):
                found.append((f"{trial}_{number}", take["stimulus"], take))
            for name, key, take in found:
                if is_take(take) and take["events"]:
                    yield session.participant, name, step, key or step["stimuli"][-1], take


def export_takes(
    answers: Answers,
    design: Design,
    path: str | Path,
    sounds: bool,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Write each trial's take, and optionally its output as WAV; return the number of takes.

    Raises
    ------
    InputError
        No trial has a take, or the answers belong to another version of the study.
    """
    if design.sha256 != answers.study["design_sha256"]:
        raise InputError(f"{design.path}: the answers belong to another version of this study")
    items = {item.key: item for item in stimuli_of(design)}
    found = list(_recorded_takes(answers))
    if not found:
        raise InputError('no trial has a take; only the gesture "free" records takes')
    rows = []
    with atomic_folder(path, INDEX) as folder:
        for number, (who, trial, step, key, take) in enumerate(found, 1):
            item = items[key]
            stem = re.sub(r"[^A-Za-z0-9_-]", "-", f"{who}_{trial}")
            gesture = take_gesture(take)
            save_gesture(gesture, folder / f"{stem}.csv")
            if sounds:
                samples = replay_trial(item, take, step["output"])
                data = sound_bytes(f"{stem}.wav", samples, round(take["sample_rate"]), "FLOAT")
                (folder / f"{stem}.wav").write_bytes(data)
            rows.append(
                {"participant": who, "trial": trial, "stimulus": key,
                 "mapping": step["output"]["mapping"], "timeline": item.names["timeline"],
                 "preset": item.names["preset"], "seed": item.seed,
                 "sample_rate": take["sample_rate"], "duration_s": gesture.duration_s,
                 "events": len(gesture.time_s), "take": f"{stem}.csv",
                 "sound": f"{stem}.wav" if sounds else None}
            )  # fmt: skip
            if progress is not None:
                progress(number / len(found))
        (folder / INDEX).write_text(csv_text(COLUMNS, rows), encoding="utf-8")
    return len(found)
