"""Design of a study: the validated TOML file and its loaded stimuli."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pydantic

from overview_dsp import Timeline, sweep
from overview_dsp.cli.extensions import (
    KEYS,
    JobsTable,
    RenderGrid,
    faults_at_their_line,
    parse_toml,
    read_grid,
    read_text,
)
from overview_dsp.errors import InputError, did_you_mean, quoted
from overview_studies import file_model
from overview_studies.columns import RESERVED_COLUMNS
from overview_studies.counterbalancing import MAX_FULL_CONDITIONS, rows_of
from overview_studies.file_model import Factor, Level, StudyFile, SyntheticTimelines
from overview_studies.synthetic_timelines import empty_timeline, make_timelines

FREE = "free"
"""Gesture of the participant; its output is measured with a sweep of 2 s."""

ANGLE_MAP = "surface.angle_map"
"""Parameter that all presets of a study share."""

NOTHING = "nothing"
NONE = "none"
"""Correct answer when no event is presented."""

PAIRED = ("compare", "adjust", "staircase", "quest")
ADAPTIVE = ("staircase", "quest")
MAX_CONDITIONS = 12
_REASONS = {
    "int_type": "must be a whole number, without quotes",
    "float_type": "must be a number, without quotes",
    "string_type": "must be text in quotes",
    "bool_type": "must be true or false",
    "list_type": "must be a list in brackets",
    "greater_than_equal": "must be at least {}",
    "less_than_equal": "must be at most {}",
    "too_short": "must have at least {} entries",
    "too_long": "must have at most {} entries",
    "string_too_short": "must not be empty",
}
"""What a value must be, by the type of an error of pydantic."""

_RENAMED = {
    "task.most": "; use max_trials",
    "task.words": "; use labels",
    "stimuli.made.places": "; use positions",
}
"""Remedies for the keys of earlier versions."""

_NO_KEYS = ("out", "sample_rate", "format", "subtype")
STIMULI_KEYS = ("made", *(key for key in KEYS if key not in _NO_KEYS))
_OUTPUT_LEVELS = {
    "mapping": file_model.MAPPINGS,
    "channel": file_model.CHANNELS,
    "input": file_model.INPUTS,
}
"""Factors of the output, with their allowed levels."""


@dataclass(frozen=True)
class Design:
    r"""A study file with its loaded inputs.

    Attributes
    ----------
    file : StudyFile
    name : str
        Name used in file names.
    path : Path
        The TOML file.
    sha256 : str
        SHA-256 of its text, with line ends as "\n".
    grid : RenderGrid
        The stimuli, in the form of `overview batch`.
    answers : mapping
        Correct answer of each timeline: its event kind, its curve's shape or its name.
    """

    file: StudyFile
    name: str
    path: Path
    sha256: str
    grid: RenderGrid
    answers: Mapping[str, str]

    def factors(self, kind: str) -> dict[str, Factor]:
        """Return the factors with a role: `between`, `blocked` or `mixed` (within blocks)."""
        return {name: f for name, f in self.file.factors.items() if _factor_role(f) == kind}

    @property
    def order(self) -> str:
        """Order of the condition blocks: williams or full."""
        blocked = list(self.factors("blocked").values())
        return blocked[0].order if blocked else "williams"

    def dimension(self, name: str) -> tuple[Level, ...]:
        """Return the levels of a stimulus dimension, in order; empty if it does not exist."""
        grid = self.grid
        real = [one for one in grid.timelines if one != NOTHING]
        of: dict[str, Any] = {
            "timeline": real,
            "answer": dict.fromkeys(self.answers[one] for one in real),
            "preset": grid.presets,
            "gesture": grid.gestures,
            "seed": grid.seeds,
            **grid.parameters,
        }
        return tuple(of.get(name, ()))

    @property
    def lists_per_round(self) -> int:
        """Number of lists that contain every order equally often in every group."""
        groups = math.prod(len(f.levels) for f in self.factors("between").values())
        conditions = math.prod(len(f.levels) for f in self.factors("blocked").values())
        return groups * len(rows_of(self.order, conditions))


def _factor_role(factor: Factor) -> str:
    if factor.between:
        return "between"
    return "mixed" if factor.order == "blocks" else "blocked"


def load_design(path: str | Path) -> Design:
    """Read a study file and load its inputs.

    Raises
    ------
    InputError
        The file is not valid; the message names file, line and key.
    """
    path = Path(path)
    text = read_text(path)
    data = parse_toml(text, str(path))
    with _faults_at_a_line(text, str(path)):
        file = _checked(data)
        synthetic = _synthetic_section(file)
        own = make_timelines(synthetic, file.seed) if synthetic is not None else {}
    table = JobsTable(
        str(path),
        text,
        {key: value for key, value in file.stimuli.items() if key != "made"},
        ("stimuli",),
        STIMULI_KEYS,
    )
    grid = _grid(file, table, {name: timeline for name, (timeline, _) in own.items()})
    if file.phases.catch or (file.task.name in ADAPTIVE and file.task.method == "yesno"):
        first = next(iter(grid.timelines.values()))
        silent = empty_timeline(synthetic, file.seed, first.duration_s)
        grid = replace(grid, timelines={**grid.timelines, NOTHING: silent})
    answers = {name: what for name, (_, what) in own.items()} | {NOTHING: NONE}
    answers |= {
        name: _kind_of(t) or name for name, t in grid.timelines.items() if name not in answers
    }
    name = file.name or "".join(c if c.isalnum() and c.isascii() else "-" for c in path.stem)
    digest = hashlib.sha256(text.replace("\r\n", "\n").encode()).hexdigest()
    design = Design(file, name, path, digest, grid, answers)
    with _faults_at_a_line(text, str(path)):
        _check_kinds(design, synthetic)
        _check_factors(design)
        _check_task(design)
        _check_forms(design)
    return design


def _checked(data: dict[str, Any]) -> StudyFile:
    try:
        return StudyFile.model_validate(data)
    except pydantic.ValidationError as error:
        faults = error.errors(include_url=False, include_context=False)
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        fault = faults[0]
        # the branches of a union are not keys
        path = [str(p) for p in fault["loc"] if p not in ("str", "float")]
        name = ".".join(path)
        if fault["type"] == "extra_forbidden":
            near = _RENAMED.get(name) or did_you_mean(path[-1], _keys_of(path[:-1]))
            raise InputError(f"{name}: unknown key{near}{more}") from None
        if fault["type"] == "missing":
            raise InputError(f"{name} is missing; {_addition(name)}{more}") from None
        raise InputError(f"{name} = {quoted(fault['input'])}: {_reason(fault)}{more}") from None


def _addition(name: str) -> str:
    """Return how to add a missing key."""
    table, _, key = name.rpartition(".")
    if table:
        return f"add {key} = ... to [{table}]"
    example = {"title": 'title = "..."', "participants": "participants = 12"}
    return f"add {example.get(name, f'a table [{name}]')}"


@contextmanager
def _faults_at_a_line(text: str, source: str) -> Iterator[None]:
    """Prefix an error with file and line: of its key, or 1 if the file has no such key or table."""
    try:
        with faults_at_their_line(text, source):
            yield
    except InputError as error:
        has_line = re.match(r":\d+: ", str(error).removeprefix(source))
        if has_line:
            raise
        raise InputError(f"{source}:1{str(error).removeprefix(source)}") from None


def _reason(fault: Any) -> str:
    """Return what a value must be."""
    reason = _REASONS.get(fault["type"])
    allowed = re.findall(r"-?\d+(?:\.\d+)?", fault["msg"])
    if reason is None:
        return str(fault["msg"]).replace("Input should be", "must be")
    return reason.format(allowed[0] if allowed else "")


def _keys_of(path: list[str]) -> list[str]:
    model: Any = StudyFile
    for part in path:
        fields = getattr(model, "model_fields", {})
        model = fields[part].annotation if part in fields else Factor
        inner = [one for one in getattr(model, "__args__", ()) if hasattr(one, "model_fields")]
        model = inner[0] if inner else model
    return list(getattr(model, "model_fields", {}))


def _synthetic_section(file: StudyFile) -> SyntheticTimelines | None:
    if "made" not in file.stimuli:
        return None
    try:
        return SyntheticTimelines.model_validate(file.stimuli["made"])
    except pydantic.ValidationError as error:
        fault = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(["stimuli", "made", *map(str, fault["loc"])])
        why = f"unknown key{_RENAMED[place]}" if place in _RENAMED else fault["msg"]
        raise InputError(f"{place}: {why}") from None


def _grid(file: StudyFile, table: JobsTable, own: dict[str, Timeline]) -> RenderGrid:
    given = table.data.get("gestures", [FREE])
    free = {}
    if isinstance(given, list) and FREE in given:
        free = {FREE: sweep(2.0)}
        table.data["gestures"] = [one for one in given if one != FREE]
        if not table.data["gestures"]:
            del table.data["gestures"]
    grid = read_grid(table, "", own, free)
    # all presets use the angle map of the first, so that positions are equal
    share = next(iter(grid.presets.values())).number(ANGLE_MAP)
    presets = {name: preset.with_value(ANGLE_MAP, share) for name, preset in grid.presets.items()}
    return replace(grid, presets=presets)


def _kind_of(timeline: Timeline) -> str | None:
    """Return the only event kind of a timeline, ignoring starts and ends of halves."""
    kinds = set(timeline.kinds()) - {"period"}
    return kinds.pop() if len(kinds) == 1 else None


def _check_kinds(design: Design, synthetic: SyntheticTimelines | None) -> None:
    kinds = [] if synthetic is None else synthetic.kinds
    target = [] if design.file.task.target is None else [design.file.task.target]
    for name, preset in design.grid.presets.items():
        known = [*preset.kinds, *(a for members in preset.kinds.values() for a in members.aliases)]
        for key, wanted in (("stimuli.made", kinds), ("task.target", target)):
            for kind in wanted:
                if kind not in known:
                    near = did_you_mean(kind, known)
                    raise InputError(f"{key}: preset {name} has no kind {kind!r}{near}")


def _check_factors(design: Design) -> None:
    file = design.file
    orders = {f.order for f in design.factors("blocked").values()}
    for name, factor in file.factors.items():
        key = f"factors.{name}"
        if (factor.within is None) == (factor.between is None):
            raise InputError(f"{key}: must have either within = [...] or between = [...]")
        if name in RESERVED_COLUMNS and not design.dimension(name):
            raise InputError(
                f"{key}: the tables of answers have a column {name}; rename the factor"
            )
        if len(set(factor.levels)) < len(factor.levels):
            raise InputError(f"{key}: contains a level twice; remove one")
        known = _OUTPUT_LEVELS.get(name) or design.dimension(name)
        for level in factor.levels:
            if known and level not in known:
                near = did_you_mean(str(level), map(str, known))
                raise InputError(f"{key}: {quoted(level)} is not a level of {name}{near}")
        if not known and _factor_role(factor) == "mixed":
            raise InputError(
                f"{key}: cannot change between trials; allowed: mapping, channel, input or a "
                'dimension of the stimuli; for other factors set order = "williams"'
            )
        if name == "input" and FREE not in design.grid.gestures:
            raise InputError(
                f"{key}: has no effect, since the gestures are played; set stimuli.gestures = "
                f'["{FREE}"], or remove the factor'
            )
        for level in [] if known else factor.levels:
            if f"{name}.{level}" not in file.text.conditions:
                raise InputError(
                    f"{key}: nothing tells participants of {name} {level}; add "
                    f'"{name}.{level}" = "..." to text.conditions'
                )
        if len(orders) > 1 and factor.order in orders:
            raise InputError(f"{key}.order: blocked factors must share one order; found {orders}")
    conditions = math.prod(len(f.levels) for f in design.factors("blocked").values())
    most = MAX_FULL_CONDITIONS if design.order == "full" else MAX_CONDITIONS
    if conditions > most:
        raise InputError(
            f"factors: {conditions} condition blocks; {design.order} allows at most {most}; make a "
            'factor between participants, or set order = "blocks"'
        )


def _check_task(design: Design) -> None:
    task, phases = design.file.task, design.file.phases
    if phases.catch and task.name in ("draw", "adjust", *ADAPTIVE) and task.method != "yesno":
        raise InputError(f"phases.catch: a {task.name} task has no catch trials")
    if phases.attention and task.name != "identify":
        raise InputError("phases.attention: only an identify task allows attention trials")
    if task.name == "search" and list(design.grid.gestures) != [FREE]:
        raise InputError(f'stimuli.gestures: a search task requires ["{FREE}"]')
    if task.of != "answer" and not design.dimension(task.of):
        raise InputError(f"task.of = {task.of!r}: the stimuli do not have this dimension")
    if task.name == "identify" and len(design.dimension(task.of)) + bool(phases.catch) < 2:
        raise InputError("task.of: the task has only one answer; add stimuli or phases.catch")
    if task.name not in PAIRED:
        return
    if task.vary is None:
        raise InputError(
            f"task.vary is missing; set it to the stimulus dimension of the {task.name} task"
        )
    levels = design.dimension(task.vary)
    if task.scale == "log" and not all(isinstance(o, int | float) and o > 0 for o in levels):
        raise InputError('task.scale = "log": each level must be a number above 0')
    if len(levels) < 2:
        raise InputError(
            f"task.vary = {task.vary!r}: the stimuli have {len(levels)} levels; at least 2 required"
        )
    needs = not (task.name in ADAPTIVE and task.method == "yesno")
    if needs and task.standard not in levels:
        near = did_you_mean(str(task.standard), map(str, levels))
        raise InputError(
            f"task.standard = {quoted(task.standard)} is not a level of {task.vary}{near}"
        )


def _check_forms(design: Design) -> None:
    forms = design.file.questionnaires
    named = {"start": forms.start, "each": forms.each, "end": forms.end}
    for key, name in [(key, name) for key, names in named.items() for name in names]:
        if name == "consent" and forms.consent is None:
            raise InputError(
                'questionnaires.consent is missing; add consent = {version = "1", text = "..."}'
            )
        if name in ("tlx", "comments", "consent"):
            continue
        if not name.endswith(".html") or not (design.path.parent / name).is_file():
            raise InputError(
                f"questionnaires.{key}: {name!r} is unknown; allowed: tlx, comments, consent, or "
                "an HTML file in the folder of the study file"
            )
