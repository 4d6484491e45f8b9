"""Export of answers to Psych-DS, BIDS, psignifit, R and CSV.

This module writes the formats itself and does not import those tools.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from overview_dsp.cli.extensions import atomic_folder
from overview_dsp.errors import InputError
from overview_studies.answers import Answers
from overview_studies.columns import COLUMN_DESCRIPTIONS
from overview_studies.measures import (
    condition_of,
    conditions_of,
    level_counts,
)
from overview_studies.scales import scale_of
from overview_studies.scripts import MEASURES, R_SCRIPT, measures_csv, r_script
from overview_studies.tables import csv_text, forms_csv, one_line, responses_csv

BIDS_VERSION = "1.10.0"
README = "README.md"
_CSV, _TSV_MISSING = ".csv", "n/a"

Files = Iterator[tuple[str, str]]


def export_answers(answers: Answers, to: str, path: str | Path) -> list[str]:
    """Write answers in one of `FORMATS` into a folder; return the names of its files.

    Raises
    ------
    InputError, OutputError
        The format does not fit the task, or the folder cannot be written.
    """
    made = dict(FORMATS[to](answers))
    mark = next(iter(made))
    with atomic_folder(path, mark) as folder:
        for name, text in made.items():
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="")
    return sorted(made)


def _tidy(answers: Answers) -> Files:
    yield answers.marked("responses.csv"), responses_csv(answers)
    yield answers.marked("forms.csv"), forms_csv(answers)


def _r(answers: Answers) -> Files:
    yield answers.marked(R_SCRIPT), r_script(answers)
    yield answers.marked(MEASURES), measures_csv(answers)
    yield from _tidy(answers)


def _meaning(answers: Answers, column: str) -> str:
    factor = answers.study["factors"].get(column)
    if factor is not None:
        return f"factor {column}: {', '.join(map(str, factor['levels']))}"
    return COLUMN_DESCRIPTIONS[column]


def _labels(answers: Answers) -> dict[str, str]:
    """Return each participant's code with letters and digits only, without duplicates."""
    found: dict[str, str] = {}
    for number, session in enumerate(answers.sessions, 1):
        plain = re.sub(r"[^A-Za-z0-9]", "", answers.marked(session.participant)) or f"s{number}"
        found[session.participant] = plain if plain not in found.values() else f"{plain}x{number}"
    return found


def _by_participant(answers: Answers) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    rows: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in answers.rows():
        rows[row["participant"]].append(row)
    labels = _labels(answers)
    return ((labels[code], own) for code, own in rows.items())


def _about(answers: Answers) -> str:
    study = answers.study
    who = "simulated observers, not of people," if answers.simulated else "participants"
    return (
        f"Answers of {len(answers.sessions)} {who} to the study {study['title']!r}; "
        f"made with overview-dsp {study['program']}, study file SHA-256 {study['design_sha256']}."
    )


def _psych_ds(answers: Answers) -> Files:
    study, columns = answers.study, answers.columns
    name = re.sub(r"[^A-Za-z0-9]", "", study["name"])
    variables = [
        {"@type": "PropertyValue", "name": column, "description": _meaning(answers, column)}
        for column in columns
    ]
    described = {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": study["title"],
        "description": _about(answers),
        "schemaVersion": "Psych-DS 0.4.0",
        "variableMeasured": variables,
    }
    yield "dataset_description.json", _json(described)
    yield README, f"# {one_line(study['title'])}\n\n{_about(answers)}\n"
    yield "CHANGES.md", "# Changes\n\n- First export.\n"
    for label, rows in _by_participant(answers):
        yield f"data/raw/study-{name}_subject-{label}_data{_CSV}", csv_text(columns, rows)


_BIDS_FIRST = ("trial_type", "response_time", "response", "stim_file")


def _bids(answers: Answers) -> Files:
    study, task = answers.study, answers.study["task"]["name"]
    described = {
        "Name": study["title"],
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [{"Name": "overview-dsp", "Version": study["program"]}],
    }
    rest = [column for column in answers.columns if column not in ("response", "rt_ms")]
    about = {
        "trial_type": {"Description": "phase of the trial: practice, main, catch or attention"},
        "response_time": {"Description": _meaning(answers, "rt_ms"), "Units": "s"},
        "response": {"Description": _meaning(answers, "response")},
        "stim_file": {"Description": "stimulus, rendered from its key by overview-dsp"},
        **{column: {"Description": _meaning(answers, column)} for column in rest},
    }
    yield "dataset_description.json", _json(described)
    yield README, f"# {one_line(study['title'])}\n\n{_about(answers)}\n"
    labels = _labels(answers)
    participants = (
        {"participant_id": f"sub-{labels[one.participant]}", "list": one.number, **answers.mark,
         **answers.lists[one.number]["factors"]}
        for one in answers.sessions
    )  # fmt: skip
    between = [n for n, factor in study["factors"].items() if factor["kind"] == "between"]
    more = ["list", *answers.mark, *between]
    yield "participants.tsv", _tsv(["participant_id", *more], participants)
    sidecar = {name: {"Description": _meaning(answers, name)} for name in more}
    yield "participants.json", _json(sidecar)
    yield f"task-{task}_beh.json", _json({"TaskName": task, **about})
    for label, rows in _by_participant(answers):
        table = (
            {**row, "trial_type": row["phase"], "stim_file": None,
             "response_time": None if row["rt_ms"] is None else row["rt_ms"] / 1000.0}
            for row in rows
        )  # fmt: skip
        yield (
            f"sub-{label}/beh/sub-{label}_task-{task}_beh.tsv",
            _tsv([*_BIDS_FIRST, *rest], table),
        )


def _tsv(columns: list[str], rows: Any) -> str:
    return csv_text(columns, rows, "\t", _TSV_MISSING)


def _psignifit(answers: Answers) -> Files:
    """Yield level, correct answers and trials, for all participants and for each of them."""
    study = answers.study
    if study["task"]["name"] not in ("compare", "staircase", "quest"):
        raise InputError(
            "psignifit requires answers by level; allowed tasks: compare, staircase and quest"
        )
    names, scale = conditions_of(study), scale_of(study)
    parts: dict[tuple[str, Any], list[dict[str, Any]]] = defaultdict(list)
    for row in answers.rows():
        if row["phase"] == "main":
            condition = condition_of(row, names)
            parts["all", condition].append(row)
            parts[row["participant"], condition].append(row)
    table = []
    for (who, condition), own in parts.items():
        for level, right, trials in zip(*level_counts(study, own), strict=True):
            table.append(
                {**answers.mark, "participant": who, **dict(condition),
                 "level": round(scale.level(float(level)), 9),
                 "right": int(right), "trials": int(trials)}
            )  # fmt: skip
    columns = [*answers.mark, "participant", *names, "level", "right", "trials"]
    yield answers.marked("psignifit.csv"), csv_text(columns, table)


FORMATS: dict[str, Callable[[Answers], Files]] = {
    "psych-ds": _psych_ds,
    "bids": _bids,
    "csv": _tidy,
    "r": _r,
    "psignifit": _psignifit,
}
"""Writer of each format."""


def _json(document: Any) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
