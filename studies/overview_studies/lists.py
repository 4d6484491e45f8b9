"""A list: what one participant does, step by step. Decided here, by seed; the page decides nothing.

The steps are described in docs/explanation/study-format.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from overview_dsp.errors import InputError
from overview_studies.adaptive import quest_table
from overview_studies.design import ADAPTIVE, Design
from overview_studies.file_model import Factor, Level
from overview_studies.items import Item
from overview_studies.orders import Seeded, rows_of, shuffled_blocks

Levels = dict[str, Level]


@dataclass(frozen=True)
class _Cell:
    """What a block of trials has once."""

    levels: tuple[tuple[str, Level], ...]
    items: tuple[Item, ...]


def _combined(factors: Mapping[str, Factor]) -> list[Levels]:
    return [
        dict(zip(factors, levels, strict=True))
        for levels in product(*(factor.levels for factor in factors.values()))
    ]


class ListMaker:
    """Makes the lists of a design.

    Parameters
    ----------
    items
        Its stimuli (`items_of`).
    """

    def __init__(self, design: Design, items: Sequence[Item]) -> None:
        self._design, self._items = design, items
        self._groups = _combined(design.factors("between"))
        self._conditions = _combined(design.factors("blocked"))
        self._mixed = _combined(design.factors("mixed"))
        self._rows = rows_of(design.order, len(self._conditions))

    def make(self, number: int) -> dict[str, Any]:
        """List `number`, from 1; the same one every time.

        Raises
        ------
        InputError
            A condition without stimuli, or without those that its task compares.
        """
        turn, group = divmod(number - 1, len(self._groups))
        between = self._groups[group]
        row = self._rows[turn % len(self._rows)]
        steps = [*self._forms(self._asked.start, 0, {})]
        for place, index in enumerate(row, 1):
            if place > 1:
                steps.append({"id": f"b{place}-break", "type": "break", "block": place})
            steps += self._block(number, place, {**between, **self._conditions[index]})
        steps += self._forms(self._asked.end, len(row) + 1, {})
        return {"list": number, "factors": between, "steps": steps}

    @property
    def _asked(self) -> Any:
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

    def _block(self, number: int, block: int, levels: Levels) -> list[dict[str, Any]]:
        """A condition block: instructions, practice, trials, forms."""
        phases, text = self._design.file.phases, self._design.file.text
        said = [
            text.conditions[key]
            for name, level in levels.items()
            if (key := f"{name}.{level}") in text.conditions
        ]
        head = {
            "id": f"b{block}-instructions",
            "type": "instructions",
            "block": block,
            "factors": levels,
            "text": " ".join(said),
            "practice": phases.practice is not None,
        }
        chance = Seeded(self._design.file.seed, "list", number, block)
        trials = (
            self._adaptive(block, levels, chance)
            if self._design.file.task.name in ADAPTIVE
            else self._trials(number, block, levels, chance)
        )
        return [head, *trials, *self._forms(self._asked.each, block, levels)]

    def _trials(
        self, number: int, block: int, levels: Levels, chance: Seeded
    ) -> Iterator[dict[str, Any]]:
        phases = self._design.file.phases
        cells = self._cells(levels)
        if phases.practice is not None:
            practised = shuffled_blocks(cells, phases.practice.repeats, chance)
            for i, cell in enumerate((one for part in practised for one in part), 1):
                more = {
                    "feedback": phases.practice.feedback,
                    "criterion": phases.practice.criterion,
                }
                yield self._trial(f"b{block}-p{i:03d}", "practice", block, 1, cell, i, more)
        blocks = shuffled_blocks(cells, phases.main.repeats, chance)
        rows: list[tuple[str, int, _Cell, int]] = []
        for repeat, part in enumerate(blocks, 1):
            own = [("main", repeat, c, number + repeat + cells.index(c)) for c in part]
            for _ in range(_share(self._catches(len(cells)), repeat, len(blocks))):
                nothing = self._silent(levels, chance)
                own.insert(chance.below(len(own) + 1), ("catch", repeat, nothing, chance.below(2)))
            for _ in range(_share(phases.attention, repeat, len(blocks))):
                cell = cells[chance.below(len(cells))]
                own.insert(chance.below(len(own) + 1), ("attention", repeat, cell, 0))
            rows += own
        for i, (phase, repeat, cell, side) in enumerate(rows, 1):
            more = {"feedback": phases.main.feedback, "criterion": None}
            yield self._trial(f"b{block}-{i:03d}", phase, block, repeat, cell, side, more)

    def _catches(self, cells: int) -> int:
        part = self._design.file.phases.catch
        main = cells * self._design.file.phases.main.repeats
        return round(main * part / (1.0 - part))

    def _cells(self, levels: Levels) -> list[_Cell]:
        task = self._design.file.task
        cells = []
        for mixed in self._mixed:
            both = {**levels, **mixed}
            items = [one for one in self._items if not one.nothing and one.fits(both)]
            if not items:
                raise InputError(f"factors: no stimulus is {_shown(both)}")
            groups: list[tuple[Item, ...]] = [(one,) for one in items]
            if task.vary:
                groups = _pairs(items, task.vary, task.standard)
            if task.name == "adjust":
                groups = [group for group in groups if group[0] is group[1]]
            elif task.name == "compare":
                groups = [group for group in groups if group[0] is not group[1]]
            cells += [_Cell(tuple(both.items()), group) for group in groups]
        return cells

    def _silent(self, levels: Levels, chance: Seeded) -> _Cell:
        """A catch trial's cell: nothing, or twice the standard."""
        both = {**levels, **self._mixed[chance.below(len(self._mixed))]}
        if self._design.file.task.name == "compare":
            cells = [cell for cell in self._cells(levels) if dict(cell.levels) == both]
            standard = cells[chance.below(len(cells))].items[0]
            return _Cell(tuple(both.items()), (standard, standard))
        # what a catch trial lacks is the timeline's; all else is as in the others
        shared = {n: v for n, v in both.items() if n not in ("timeline", "answer")}
        items = [one for one in self._items if one.nothing and one.fits(shared)]
        return _Cell(tuple(both.items()), (items[chance.below(len(items))],))

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
            # a catch trial's stimulus is nothing, whatever is asked for
            correct = str(items[0].names["answer" if phase == "catch" else task.of])
        elif task.name == "locate":
            correct = items[0].places(task.target)
        elif task.name == "count":
            correct = len(items[0].places(task.target))
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
            # which level of what the answer is it lacks
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

    def _adjustable(self, standard: Item) -> list[Item]:
        """The stimuli that are like the standard in all but what is adjusted, in order."""
        vary = str(self._design.file.task.vary)
        return [
            next(one for one in self._items if one.fits({**standard.names, vary: level}))
            for level in self._design.dimension(vary)
        ]

    def output(self, levels: Mapping[str, Level]) -> dict[str, Any]:
        """How a trial of these levels is given."""
        said = self._design.file.output
        channel = levels.get("channel", said.channel)
        return {
            "mapping": levels.get("mapping", said.mapping),
            "input": levels.get("input", said.input),
            "click_db": said.click_db if channel in ("click", "both") else None,
            "tactor_db": said.tactor_db if channel in ("tactor", "both") else None,
            "visual": channel == "visual",
            "mask": said.mask is not None,
        }

    # --- adaptive ---------------------------------------------------------------------------------

    def _adaptive(self, block: int, levels: Levels, chance: Seeded) -> Iterator[dict[str, Any]]:
        task, phases = self._design.file.task, self._design.file.phases
        vary = str(task.vary)
        for i, mixed in enumerate(self._mixed, 1):
            both = {**levels, **mixed}
            order = self._design.dimension(vary)
            fitting = [one for one in self._items if one.fits(both)]
            by = {level: [o for o in fitting if not o.nothing and o.names[vary] == level]
                  for level in order}  # fmt: skip
            if any(len(found) != 1 for found in by.values()):
                raise InputError(
                    f"task.vary: a {task.name} has one stimulus a level of {vary}; in "
                    f"{_shown(both)} there are {[len(found) for found in by.values()]}"
                )
            yesno = task.method == "yesno"
            if yesno:
                shared = {n: v for n, v in both.items() if n not in ("timeline", "answer")}
                standard = next(o for o in self._items if o.nothing and o.fits(shared))
            else:
                standard = by[task.standard][0]  # type: ignore[index]
            shown = [level for level in order if yesno or level != task.standard]
            catch = [yesno and chance.uniform(0.0, 1.0) < phases.catch for _ in range(task.most)]
            last = len(shown) - 1
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
                "levels": shown,
                "stimuli": [by[level][0].key for level in shown],
                "standard": standard.key,
                "most": task.most,
                "sides": [chance.below(2) for _ in range(task.most)],
                "catch": catch,
                "tracks": tracks if task.name == "staircase" else None,
                "quest": quest_table(len(shown), 0.0 if yesno else 0.5)
                if task.name == "quest"
                else None,
            }


def _pairs(items: Sequence[Item], vary: str, standard: Level | None) -> list[tuple[Item, ...]]:
    """Each stimulus behind the standard that is like it in all else."""
    pairs: list[tuple[Item, ...]] = []
    # what goes with the dimension itself isn't what a pair shares
    bound = {vary} | ({"timeline", "answer"} if vary in ("timeline", "answer") else set())
    for one in items:
        shared = {name: level for name, level in one.names.items() if name not in bound}
        fitting = [i for i in items if i.names[vary] == standard and i.fits(shared)]
        pairs += [(fitting[0], one)] if fitting else []
    return pairs


def _share(total: int, repeat: int, repeats: int) -> int:
    """How many of `total` belong to one of the repeats: as even as can be."""
    return total * repeat // repeats - total * (repeat - 1) // repeats


def _shown(levels: Mapping[str, Level]) -> str:
    return ", ".join(f"{name} = {level!r}" for name, level in levels.items()) or "there"


def form_name(asked: str) -> str:
    """The name of a form: tlx, or a file's without its folders and suffix."""
    return asked.rpartition("/")[2].removesuffix(".html")
