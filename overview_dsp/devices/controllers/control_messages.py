"""What a controller says, in the words all of them share."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.design.presets.parameter import Value
from overview_dsp.units import HALF_TURN


@dataclass(frozen=True)
class AngleChanged:
    """`control`, which feels no touch, is at theta2 (rad)."""

    control: str
    theta2: float


@dataclass(frozen=True)
class TouchStarted:
    """`finger` holds on at theta2 (rad): a step if it didn't, else it moves there."""

    finger: str
    theta2: float


@dataclass(frozen=True)
class TouchEnded:
    """`finger` lets go; None: every one does."""

    finger: str | None = None


@dataclass(frozen=True)
class SetParameter:
    """The parameter `id` is to be `value`."""

    id: str
    value: Value


@dataclass(frozen=True)
class ScaleParameter:
    """What sets the parameter `id` is at `part` (0 to 1) of its way from `low` to `high` (None: the
    parameter's own ends); it acts once it has passed where the parameter is."""

    id: str
    part: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class StepParameter:
    """What sets the parameter `id` goes on by `step` (1 is all) of its way from `low` to `high`."""

    id: str
    step: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Command:
    """The session is asked for something that is no movement: a name and its words."""

    words: tuple[str, ...]


Move = (
    AngleChanged
    | TouchStarted
    | TouchEnded
    | SetParameter
    | ScaleParameter
    | StepParameter
    | Command
)


@dataclass
class Counters:
    """What came and what was wrong with it; nothing of this stops a session.

    Attributes
    ----------
    messages
        Understood.
    refused
        None at all, or with values that can't be.
    unknown
        Understood, and assigned to nothing.
    clamped
        Angles beyond an end of the timeline, taken as that end.
    overrun
        Given up because more came than could be read.
    """

    messages: int = 0
    refused: int = 0
    unknown: int = 0
    clamped: int = 0
    overrun: int = 0


def theta2_at(part: float, low: float | None, high: float | None) -> float:
    """The angle (rad) at a part of a control's way between two parts of the timeline."""
    first, last = 0.0 if low is None else low, 1.0 if high is None else high
    return HALF_TURN * (first + (last - first) * part)


class PositionControl:
    """A position on the timeline that something moves, and a touch that something else may say.

    Until a touch has been said it is `AngleChanged`; from then on the touch decides alone.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._theta2 = 0.0
        self._touch: bool | None = None

    def turn(self, theta2: float) -> list[Move]:
        """It is at theta2 (rad)."""
        self._theta2 = theta2
        if self._touch is None:
            return [AngleChanged(self._name, theta2)]
        return [TouchStarted(self._name, theta2)] if self._touch else []

    def touch(self, touching: bool) -> list[Move]:
        """The hand holds on, or lets go."""
        before, self._touch = self._touch, touching
        if touching:
            return [] if before else [TouchStarted(self._name, self._theta2)]
        return [] if before is False else [TouchEnded(self._name)]

    def both(self, theta2: float, touching: bool) -> list[Move]:
        """It is at theta2 (rad), and the hand holds on there, or lets go."""
        self._theta2 = theta2
        return self.touch(touching) or self.turn(theta2)
