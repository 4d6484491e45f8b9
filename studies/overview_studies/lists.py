"""Lists: the steps of one participant, chosen by seed.

The page makes no random choices. The steps are described in docs/explanation/study-format.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from overview_dsp.errors import InputError
from overview_studies.adaptive import quest_table
from overview_studies.counterbalancing import RandomStream, rows_of, shuffled_blocks
from overview_studies.design import ADAPTIVE, FREE, Design
from overview_studies.file_model import Factor, Level
from overview_studies.lesson import QUESTIONS
from overview_studies.scales import Scale, scale_kind
from overview_studies.stimuli import Stimulus
from overview_studies.training import training_of

Levels = dict[str, Level]

INPUT_TEXTS = {
    "touch": "Use a finger on the field, or the mouse.",
    "twist": "Turn on Twist, hold the phone in your hand and roll it from face up to face down.",
    "keys": "Use the arrow keys.",
}
"""Text for participants about an input, unless the study has a text of its own."""

CHANNEL_TEXTS = {
    "click": "You feel and hear only the clicks.",
    "tactor": "You feel and hear only the vibration.",
    "both": "You feel and hear it.",
    "visual": "You see it, and do not feel or hear it.",
    "all": "You see, feel and hear it.",
}
"""Text about a channel that changes between blocks, unless the study has a text of its own."""


@dataclass(frozen=True)
class _Cell:
    """Factor levels and stimuli of one trial, which occurs once per block."""

    levels: tuple[tuple[str, Level], ...]
    items: tuple[Stimulus, ...]


def _combined(factors: Mapping[str, Factor]) -> list[Levels]:
    return [
        dict(zip(factors, levels, strict=True))
        for levels in product(*(factor.levels for factor in factors.values()))
    ]


class ListMaker:
    """Generator of the lists of a design.

    Parameters
    ----------
    items
        Its stimuli (`stimuli_of`).
    """

    def __init__(self, design: Design, items: Sequence[Stimulus]) -> None:
        self._design, self._items = design, [one for one in items if not one.is_training]
        self._lesson = training_of(design)
        self._training_keys = [one.key for one in items if one.is_training]
        self._groups = _combined(design.factors("between"))
        self._conditions = _combined(design.factors("blocked"))
        self._mixed = _combined(design.factors("mixed"))
        self._rows = rows_of(design.order, len(self._conditions))

    def make(self, number: int) -> dict[str, Any]:
        """Return list `number`, counted from 1; repeated calls give the same list.

        Raises
        ------
        InputError
            A condition has no stimuli, or lacks those that its task compares.
        """
        turn, group = divmod(number - 1, len(self._groups))
        between = self._groups[group]
        row = self._rows[turn % len(self._rows)]
        steps = [*self._forms(self._questionnaires.start, 0, {})]
        steps += self._training(number)
        before: list[str] = []
        for position, index in enumerate(row, 1):
            levels = {**between, **self._conditions[index]}
            now = self._condition_texts(levels)
            if position > 1:
                new = [text for text in now if text not in before]
                announced = " ".join(["New in the next part:", *new]) if new else ""
                steps.append({"id": f"b{position}-break", "type": "break", "block": position,
                              "text": announced})  # fmt: skip
            steps += self._block(number, position, levels)
            before = now
        steps += self._forms(self._questionnaires.end, len(row) + 1, {})
        return {"list": number, "factors": between, "steps": steps}

    def _training(self, number: int) -> Iterator[dict[str, Any]]:
        """Yield the examples and questions of the lesson; each list orders its questions."""
        lesson, training = self._lesson, self._design.file.training
        if lesson is None or training is None:
            return
        keys = {id(one): key for one, key in zip(lesson.examples, self._training_keys, strict=True)}
        output = {**self.output({}), "mapping": "friction"}
        for i, step in enumerate(lesson.steps, 1):
            yield {
                "id": f"b0-e{i:03d}",
                "type": "example",
                "block": 0,
                "text": step.text,
                "captions": [one.caption for one in step.examples],
                "output": output,
                "stimuli": [keys[id(one)] for one in step.examples],
            }
        stream = RandomStream(self._design.file.seed, "training", number)
        criterion = None if training.criterion is None else training.criterion / QUESTIONS
        for i, step in enumerate(stream.shuffled(lesson.questions), 1):
            yield {
                "id": f"b0-p{i:03d}",
                "type": "trial",
                "task": self._design.file.task.name,
                "phase": "practice",
                "block": 0,
                "repeat": 1,
                "factors": {},
                "output": output,
                "stimuli": [keys[id(step.examples[0])]],
                "correct": step.kind,
                "feedback": True,
                "criterion": criterion,
                "rounds": training.most_rounds,
                "attention": None,
            }

    @property
    def _questionnaires(self) -> Any:
        return self._design.file.questionnaires

    def _forms(self, names: Sequence[str], block: int, factors: Levels) -> Iterator[dict[str, Any]]:
        for i, name in enumerate(names, 1):
            form = form_name(name)
            yield {
                "id": f"b{block}-form-{i}-{form}",
                "type": "form",
                "form": form,
                "block": block,
                "factors": factors,
            }

    def _condition_texts(self, levels: Levels) -> list[str]:
        """Return the texts of a condition, and of its input if participants move."""
        own = self._design.file.text.conditions
        known = {f"channel.{level}": text for level, text in CHANNEL_TEXTS.items()} | own
        found = [known[key] for name, level in levels.items()
                 if (key := f"{name}.{level}") in known]  # fmt: skip
        used = str(levels.get("input", self._design.file.output.input))
        is_told = f"input.{used}" in own or FREE not in self._design.grid.gestures
        return [*found, *([] if is_told or used not in INPUT_TEXTS else [INPUT_TEXTS[used]])]

    def _block(self, number: int, block: int, levels: Levels) -> list[dict[str, Any]]:
        """Return the steps of a condition block: instructions, practice, trials, forms."""
        phases = self._design.file.phases
        head = {
            "id": f"b{block}-instructions",
            "type": "instructions",
            "block": block,
            "factors": levels,
            "text": " ".join(self._condition_texts(levels)),
            "practice": phases.practice is not None,
        }
        stream = RandomStream(self._design.file.seed, "list", number, block)
        trials = (
            self._adaptive(block, levels, stream)
            if self._design.file.task.name in ADAPTIVE
            else self._trials(number, block, levels, stream)
        )
        return [head, *trials, *self._forms(self._questionnaires.each, block, levels)]

    def _trials(
        self, number: int, block: int, levels: Levels, stream: RandomStream
    ) -> Iterator[dict[str, Any]]:
        phases = self._design.file.phases
        cells = self._cells(levels)
        if phases.practice is not None:
            practice_cells = shuffled_blocks(cells, phases.practice.repeats, stream)
            for i, cell in enumerate((one for part in practice_cells for one in part), 1):
                more = {
                    "feedback": phases.practice.feedback,
                    "criterion": phases.practice.criterion,
                }
                yield self._trial(f"b{block}-p{i:03d}", "practice", block, 1, cell, i, more)
        blocks = shuffled_blocks(cells, phases.main.repeats, stream)
        rows: list[tuple[str, int, _Cell, int]] = []
        for repeat, part in enumerate(blocks, 1):
            own = [("main", repeat, c, number + repeat + cells.index(c)) for c in part]
            for _ in range(_share(self._catch_count(len(cells)), repeat, len(blocks))):
                nothing = self._catch_cell(levels, stream)
                own.insert(stream.below(len(own) + 1), ("catch", repeat, nothing, stream.below(2)))
            for _ in range(_share(phases.attention, repeat, len(blocks))):
                cell = cells[stream.below(len(cells))]
                own.insert(stream.below(len(own) + 1), ("attention", repeat, cell, 0))
            rows += own
        for i, (phase, repeat, cell, side) in enumerate(rows, 1):
            more = {"feedback": phases.main.feedback, "criterion": None}
            yield self._trial(f"b{block}-{i:03d}", phase, block, repeat, cell, side, more)

    def _catch_count(self, cells: int) -> int:
        part = self._design.file.phases.catch
        main = cells * self._design.file.phases.main.repeats
        return round(main * part / (1.0 - part))

    def _cells(self, levels: Levels) -> list[_Cell]:
        task = self._design.file.task
        cells = []
        for mixed in self._mixed:
            both = {**levels, **mixed}
            items = [one for one in self._items if not one.is_catch and one.matches(both)]
            if not items:
                raise InputError(
                    f"factors: no stimulus has {_levels_text(both)}; add it to [stimuli]"
                )
            groups: list[tuple[Stimulus, ...]] = [(one,) for one in items]
            if task.vary:
                groups = _pairs(items, task.vary, task.standard)
            if task.name == "adjust":
                groups = [group for group in groups if group[0] is group[1]]
            elif task.name == "compare":
                groups = [group for group in groups if group[0] is not group[1]]
            cells += [_Cell(tuple(both.items()), group) for group in groups]
        return cells

    def _catch_cell(self, levels: Levels, stream: RandomStream) -> _Cell:
        """Return the cell of a catch trial: a stimulus without events, or the standard twice."""
        both = {**levels, **self._mixed[stream.below(len(self._mixed))]}
        if self._design.file.task.name == "compare":
            cells = [cell for cell in self._cells(levels) if dict(cell.levels) == both]
            standard = cells[stream.below(len(cells))].items[0]
            return _Cell(tuple(both.items()), (standard, standard))
        # a catch trial differs from the others only in its timeline
        shared = {n: v for n, v in both.items() if n not in ("timeline", "answer")}
        items = [one for one in self._items if one.is_catch and one.matches(shared)]
        return _Cell(tuple(both.items()), (items[stream.below(len(items))],))

    def _trial(
        self,
        id: str,
        phase: str,
        block: int,
        repeat: int,
        cell: _Cell,
        side: int,
        more: Mapping[str, Any],
    ) -> dict[str, Any]:
        task = self._design.file.task
        levels = dict(cell.levels)
        items = list(cell.items)
        correct: Any = None
        if task.name == "identify":
            # the correct answer of a catch trial never depends on task.of
            correct = str(items[0].names["answer" if phase == "catch" else task.of])
        elif task.name in ("locate", "search"):
            correct = items[0].positions(task.target)
        elif task.name == "count":
            correct = len(items[0].positions(task.target))
        elif task.name == "adjust":
            correct = items[0].names[str(task.vary)]
            levels_of = self._adjustable(items[0])
            items[1] = levels_of[-1 if side % 2 else 0]
            more = {
                **more,
                "levels": [one.names[str(task.vary)] for one in levels_of],
                "adjustable": [one.key for one in levels_of],
            }
        elif task.name == "compare":
            order = self._design.dimension(str(task.vary))
            if side % 2:
                items.reverse()
            if phase != "catch":
                at = [order.index(one.names[str(task.vary)]) for one in items]
                correct = int(at[1] > at[0])
        if phase == "catch":
            # a catch trial has no level of timeline or answer
            levels = {n: v for n, v in levels.items() if n not in ("timeline", "answer")}
        return {
            "id": id,
            "type": "trial",
            "task": task.name,
            "phase": phase,
            "block": block,
            "repeat": repeat,
            "factors": levels,
            "output": self.output(dict(cell.levels)),
            "stimuli": [one.key for one in items],
            "correct": correct,
            **more,
            "attention": correct if phase == "attention" else None,
        }

    def _adjustable(self, standard: Stimulus) -> list[Stimulus]:
        """Return the stimuli that differ from the standard only in `vary`, in order."""
        vary = str(self._design.file.task.vary)
        return [
            next(one for one in self._items if one.matches({**standard.names, vary: level}))
            for level in self._design.dimension(vary)
        ]

    def output(self, levels: Mapping[str, Level]) -> dict[str, Any]:
        """Return the output settings of a trial with these levels."""
        output = self._design.file.output
        channel = levels.get("channel", output.channel)
        return {
            "mapping": levels.get("mapping", output.mapping),
            "input": levels.get("input", output.input),
            "click_db": output.click_db if channel in ("click", "both", "all") else None,
            "tactor_db": output.tactor_db if channel in ("tactor", "both", "all") else None,
            "visual": channel in ("visual", "all"),
            "mask": output.mask is not None,
        }

    # --- adaptive ---------------------------------------------------------------------------------

    def _adaptive(
        self, block: int, levels: Levels, stream: RandomStream
    ) -> Iterator[dict[str, Any]]:
        task, phases = self._design.file.task, self._design.file.phases
        vary = str(task.vary)
        for i, mixed in enumerate(self._mixed, 1):
            both = {**levels, **mixed}
            order = self._design.dimension(vary)
            candidates = [one for one in self._items if one.matches(both)]
            by = {level: [o for o in candidates if not o.is_catch and o.names[vary] == level]
                  for level in order}  # fmt: skip
            if any(len(found) != 1 for found in by.values()):
                raise InputError(
                    f"task.vary: a {task.name} task requires one stimulus per level of {vary}; "
                    f"with {_levels_text(both)} there are {[len(found) for found in by.values()]}"
                )
            yesno = task.method == "yesno"
            if yesno:
                shared = {n: v for n, v in both.items() if n not in ("timeline", "answer")}
                standard = next(o for o in self._items if o.is_catch and o.matches(shared))
            else:
                standard = by[task.standard][0]  # type: ignore[index]
            compared = [level for level in order if yesno or level != task.standard]
            scale = Scale(scale_kind(task.vary, order, task.scale), order)
            catch = [
                yesno and stream.uniform(0.0, 1.0) < phases.catch for _ in range(task.max_trials)
            ]
            last = len(compared) - 1
            tracks = [
                {"start": start, "down": task.down, "steps": task.steps,
                 "reversals": task.reversals}
                for start in (last, last // 2)
            ]  # fmt: skip
            yield {
                "id": f"b{block}-a{i}",
                "type": "adaptive",
                "task": task.name,
                "phase": "main",
                "block": block,
                "factors": both,
                "output": self.output(both),
                "method": task.method,
                "levels": compared,
                "stimuli": [by[level][0].key for level in compared],
                "standard": standard.key,
                "most": task.max_trials,
                "sides": [stream.below(2) for _ in range(task.max_trials)],
                "catch": catch,
                "tracks": tracks if task.name == "staircase" else None,
                "quest": quest_table(scale.steps(compared), 0.0 if yesno else 0.5)
                if task.name == "quest"
                else None,
            }


def _pairs(
    items: Sequence[Stimulus], vary: str, standard: Level | None
) -> list[tuple[Stimulus, ...]]:
    """Return the pairs of a standard and a stimulus that differ only in `vary`."""
    pairs: list[tuple[Stimulus, ...]] = []
    # dimensions tied to `vary` differ within a pair
    bound = {vary} | ({"timeline", "answer"} if vary in ("timeline", "answer") else set())
    for one in items:
        shared = {name: level for name, level in one.names.items() if name not in bound}
        fitting = [i for i in items if i.names[vary] == standard and i.matches(shared)]
        pairs += [(fitting[0], one)] if fitting else []
    return pairs


def _share(total: int, repeat: int, repeats: int) -> int:
    """Return how many of `total` belong to one repeat, spread as evenly as possible."""
    return total * repeat // repeats - total * (repeat - 1) // repeats


def _levels_text(levels: Mapping[str, Level]) -> str:
    return ", ".join(f"{name} = {level!r}" for name, level in levels.items()) or "no factors"


def form_name(entry: str) -> str:
    """Return the name of a form, without folders and suffix."""
    return entry.rpartition("/")[2].removesuffix(".html")
