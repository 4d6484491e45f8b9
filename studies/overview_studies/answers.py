"""Answers of a study as rows, from a server's SQLite file or from CSV files of offline pages."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError
from overview_studies.folder import read_study
from overview_studies.row_checks import is_part, is_take
from overview_studies.scoring import is_correct, response_error, search_path
from overview_studies.steps import answered_steps, find_among, find_step, missing_steps
from overview_studies.store import SIMULATED, Session, Store

OFFLINE = ("session", "participant", "list", "trial", "received_utc", "row")
"""Required columns of an offline page's CSV."""

MARK = "SIMULATED"
"""Mark of names, titles and rows made from simulated answers."""

_HEAD = (
    "participant",
    "session",
    "list",
    "complete",
    "position",
    "trial",
    "phase",
    "block",
    "repeat",
)
_TAIL = (
    "task", "stimulus", "stimulus_sha256", "seed", "timeline", "preset", "gesture", "level",
    "correct_response", "response", "correct", "error", "rt_ms", "presentations", "source",
    "started_utc", "received_utc", "sample_rate", "output_latency_ms", "user_agent",
    "take_events", "design_sha256", "program",
)  # fmt: skip

_SEARCH = ("time_s", "path", "returns")

FOUND_TOLERANCE = 0.05
"""Maximum error of a found event, as a share of the timeline."""


@dataclass(frozen=True)
class Answers:
    """A study with its answers.

    Attributes
    ----------
    study : dict
        Content of study.json.
    lists : dict
        Lists by number.
    sessions : list of Session
    simulated : bool
        Whether no person took part. Title and name of the study are then marked, and all tables
        have a column ``simulated``.
    """

    study: dict[str, Any]
    lists: dict[int, dict[str, Any]]
    sessions: Sequence[Session]
    simulated: bool = False

    def __post_init__(self) -> None:
        title, name = self.study["title"], self.study["name"]
        is_marked = title.startswith(f"{MARK}: ") and name.startswith(f"{MARK}-")
        if self.simulated and not is_marked:
            marked = {"title": f"{MARK}: {title}", "name": f"{MARK}-{name}"}
            object.__setattr__(self, "study", {**self.study, **marked})

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of `rows`."""
        factors = (name for name in self.study["factors"] if name not in (*_HEAD, *_TAIL))
        search = _SEARCH if self.study["task"]["name"] == "search" else ()
        return (*self.mark, *_HEAD, *factors, *_TAIL, *search)

    @property
    def mark(self) -> dict[str, str]:
        """Column and value that mark each row of simulated answers; empty for those of people."""
        return {"simulated": MARK} if self.simulated else {}

    def marked(self, name: str) -> str:
        """Return a file name, which begins with `MARK` for simulated answers."""
        return f"{MARK}-{name}" if self.simulated else name

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield one row per answered trial, in order; forms are not included."""
        for session in self.sessions:
            steps = answered_steps(self.lists[session.number])
            for position, (trial, received, row) in enumerate(session.trials, 1):
                step = find_among(trial, steps)
                if step is not None and step["type"] != "form":
                    yield self._row(session, position, trial, received, row, step)

    def _row(
        self,
        session: Session,
        position: int,
        trial: str,
        received: str,
        answer: dict[str, Any],
        step: dict[str, Any],
    ) -> dict[str, Any]:
        adaptive = step["type"] == "adaptive"
        phase, keys = step["phase"], step["stimuli"]
        correct: Any = step.get("correct")
        if adaptive:
            index = int(trial.rpartition("-")[2]) - 1
            answer = {**answer, "trial_index": index}
            phase = "catch" if step["catch"][index] else "main"
            keys = [answer["stimulus"]] if answer.get("stimulus") in keys else [step["standard"]]
            correct = step["sides"][index] if step["method"] == "2afc" else int(phase == "main")
        stimuli = [self.study["stimuli"][key] for key in keys]
        # the stimulus of a pair that is not the standard
        standard = self.study["task"]["standard"]
        varied = next((one for one in stimuli if one["level"] != standard), stimuli[0])
        hashed = "static_sha256" if step["output"]["mapping"] == "static" else "sha256"
        right = is_correct(step["task"], step, answer)
        device = answer.get("device") or {}
        takes = answer.get("takes")
        own = answer.get("take")
        takes = [one for one in (own, *(takes if isinstance(takes, list) else ()))
                 if is_take(one)]  # fmt: skip
        return {
            **self.mark,
            "participant": session.participant,
            "session": session.id,
            "list": session.number,
            "complete": int(session.finished_utc is not None),
            "position": position,
            "trial": trial,
            "phase": phase,
            "block": step["block"],
            "repeat": step.get("repeat"),
            **self.lists[session.number]["factors"],
            **step["factors"],
            "task": step["task"],
            "stimulus": " ".join(keys),
            "stimulus_sha256": " ".join(one[hashed] or one["sha256"] for one in stimuli),
            "seed": varied["seed"],
            "timeline": varied["timeline"],
            "preset": varied["preset"],
            "gesture": varied["gesture"],
            "level": answer.get("level") if adaptive else varied["level"],
            "correct_response": correct,
            "response": answer.get("response"),
            "correct": None if right is None else int(right),
            "error": response_error(step["task"], step, answer, stimuli[0]),
            **self._search(step, answer, next((one for one in takes if one is own), None)),
            "rt_ms": answer.get("rt_ms"),
            "presentations": answer.get("presentations"),
            "source": answer.get("source"),
            "started_utc": answer.get("started_utc"),
            "received_utc": received,
            "sample_rate": device.get("sample_rate"),
            "output_latency_ms": device.get("output_latency_ms"),
            "user_agent": device.get("user_agent"),
            "take_events": sum(len(one["events"]) for one in takes) or None,
            "design_sha256": self.study["design_sha256"],
            "program": self.study["program"],
        }

    def _search(
        self, step: dict[str, Any], answer: dict[str, Any], take: dict[str, Any] | None
    ) -> dict[str, Any]:
        """Return the columns of a search task; empty in other tasks."""
        places = step.get("correct")
        if step["task"] != "search" or not places:
            return {}
        response = answer.get("response")
        place = min(places, key=lambda one: abs(one - response)) if is_part(response) else places[0]
        return search_path(take, place, FOUND_TOLERANCE)

    def forms(self) -> Iterator[dict[str, Any]]:
        """Yield one row per answered item of a form."""
        for session in self.sessions:
            content = self.lists[session.number]
            steps = answered_steps(content)
            for trial, received, answer in session.trials:
                step = find_among(trial, steps)
                if step is None or step["type"] != "form":
                    continue
                response = answer.get("response")
                for item, value in (response if isinstance(response, dict) else {}).items():
                    yield {
                        **self.mark,
                        "participant": session.participant,
                        "session": session.id,
                        "list": session.number,
                        "block": step["block"],
                        **content["factors"],
                        **step["factors"],
                        "form": step["form"],
                        "item": item,
                        "value": value,
                        "received_utc": received,
                    }


def read_answers(sources: Iterable[str | Path], folder: str | Path | None = None) -> Answers:
    """Read SQLite files and offline CSV files; the latter need the study's `folder`.

    Abandoned sessions are skipped.

    Raises
    ------
    InputError
        A file has neither format, the answers belong to different studies, simulated answers are
        among those of people, or there are no answers.
    """
    study, lists, sessions = None, {}, []
    kinds: dict[bool, Path] = {}
    if folder is not None:
        study, listed = read_study(folder)
        lists = {one["list"]: one for one in listed}
    for source in map(Path, sources):
        if source.suffix == ".csv":
            if study is None:
                raise InputError(f"{source}: an offline CSV requires its study; add --study FOLDER")
            offline = _offline(source, lists)
            sessions += offline
            rows = [row for one in offline for _, _, row in one.trials]
            kinds[any(row.get("source") == SIMULATED for row in rows)] = source
            continue
        store = Store(source)
        try:
            if study is not None and store.study["design_sha256"] != study["design_sha256"]:
                raise InputError(f"{source}: contains answers to another version of this study")
            study = study or store.study
            lists = lists or store.lists()
            sessions += [one for one in store.sessions() if not one.abandoned]
            kinds[store.simulated] = source
        finally:
            store.close()
    if len(kinds) == 2:
        raise InputError(
            f"{kinds[True]} has simulated answers and {kinds[False]} those of people; analyse and "
            "export them apart"
        )
    if study is None or not sessions:
        raise InputError("the files contain no answers")
    codes = [one.participant for one in sessions]
    twice = {code for code in codes if codes.count(code) > 1}
    if twice:
        raise InputError(f"participant {sorted(twice)[0]} has two sessions; remove one of them")
    return Answers(study, lists, sessions, True in kinds)


def _offline(path: Path, lists: dict[int, dict[str, Any]]) -> list[Session]:
    """Return the sessions of an offline page's CSV."""
    csv.field_size_limit(min(sys.maxsize, 2**31 - 1))  # a row holds a take
    found: dict[str, Session] = {}
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = csv.DictReader(file)
            missing = [name for name in OFFLINE if name not in (rows.fieldnames or ())]
            if missing:
                raise InputError(
                    f"{path}: missing column {', '.join(missing)}; use the CSV of the page"
                )
            for row in rows:
                at = f"{path}:{rows.line_num}"
                number = int(row["list"])
                if number not in lists or find_step(row["trial"], lists[number]) is None:
                    raise InputError(f"{at}: list {number} has no trial {row['trial']}")
                one = found.setdefault(
                    row["session"],
                    Session(row["session"], "", number, row["participant"], row["received_utc"],
                            None),
                )  # fmt: skip
                if row["trial"] not in {trial for trial, _, _ in one.trials}:
                    one.trials.append((row["trial"], row["received_utc"], json.loads(row["row"])))
    except (OSError, ValueError, TypeError, csv.Error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: cannot be read ({error})") from None
    return [_finished(one, lists[one.number]) for one in found.values()]


def _finished(session: Session, content: dict[str, Any]) -> Session:
    whole = not missing_steps(content, [trial for trial, _, _ in session.trials])
    return replace(session, finished_utc=session.trials[-1][1] if whole else None)
