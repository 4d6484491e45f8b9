"""One thing a person sets: its id, unit, range, default and a sentence. What tables are made of."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from overview_dsp.errors import InputError, shown

Value = float | bool | str


@dataclass(frozen=True)
class Parameter:
    """One thing a person sets: its unit, range, default and a sentence.

    Parameters
    ----------
    id : str
        `section.key`.
    default : float, bool, str or None
        None where it must be given.
    low, high : float
        The range of a number, in the unit.
    unit : str
        As written after a value; empty without one.
    doc : str
        A sentence for a person.
    choices : tuple
        What it may be; empty for numbers, False and True for a flag.
    scale : {"linear", "log"}
        How a slider moves it.
    surface : bool
        Whether it is part of the friction table: changing it makes a new surface.

    Examples
    --------
    >>> known = ov.presets.PARAMETERS["tactor.gain_db"]
    >>> known.allowed
    '-60 to 12 dB'
    >>> known.check(-6)
    -6.0
    """

    id: str
    default: Value | None
    low: float = 0.0
    high: float = 0.0
    unit: str = ""
    doc: str = ""
    choices: tuple[Value, ...] = ()
    scale: Literal["linear", "log"] = "linear"
    surface: bool = False

    @property
    def key(self) -> str:
        """The last part of the id: the key in a preset file's section."""
        return self.id.rpartition(".")[2]

    @property
    def allowed(self) -> str:
        """What a value may be, in words with the unit."""
        if self.choices:
            return " or ".join(
                value_text(choice) if isinstance(choice, bool) else f'"{choice}"'
                for choice in self.choices
            )
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.low:g} to {self.high:g}{unit}"

    def check(self, value: object) -> Value:
        """Check a value; nothing is clamped.

        Parameters
        ----------
        value : object
            What was given.

        Returns
        -------
        float, bool or str
            It, in the parameter's own type.

        Raises
        ------
        InputError
            Wrong type, not a number, or outside the range.

        Examples
        --------
        >>> ov.presets.PARAMETERS["tactor.gain_db"].check(99.0)
        Traceback (most recent call last):
        overview_dsp.errors.InputError: tactor.gain_db = 99 is out of range; it is -60 to 12 dB
        """
        if self.choices:
            if not isinstance(value, bool | str) or (
                isinstance(self.choices[0], bool) != isinstance(value, bool)
                or value not in self.choices
            ):
                raise InputError(f"{self.id} = {shown(value)} is not allowed; it is {self.allowed}")
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{self.id} = {shown(value)} is not a number; it is {self.allowed}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf if value > 0 else -math.inf
        # written so that NaN fails
        if not self.low <= number <= self.high:
            raise InputError(f"{self.id} = {number:g} is out of range; it is {self.allowed}")
        return number

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id}: {self.allowed}, default {self.default}>"


def read_parameters(file: Path) -> dict[str, Parameter]:
    """The parameters of a program's own TOML table, by id: the section and the key of each."""
    sections = tomllib.loads(file.read_text(encoding="utf-8"))
    return {
        (id := f"{section}.{key}"): _parameter(id, **given)
        for section, members in sections.items()
        for key, given in members.items()
    }


def _parameter(
    id: str,
    doc: str,
    default: Value | None = None,
    range: tuple[float, float] = (0.0, 0.0),
    choices: Iterable[str] = (),
    unit: str = "",
    scale: Literal["linear", "log"] = "linear",
) -> Parameter:
    if isinstance(default, bool):
        return Parameter(id, default, 0.0, 1.0, unit, doc, (False, True))
    return Parameter(id, default, *range, unit, doc, tuple(choices), scale)


def value_text(value: Value) -> str:
    """A value as it is written: `true`, `0.5`, `gaussian`."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else value


def is_default(parameter: Parameter, value: Value) -> bool:
    """Whether a value is the parameter's default, to rounding."""
    if isinstance(parameter.default, float) and isinstance(value, float):
        return math.isclose(parameter.default, value, rel_tol=1e-12, abs_tol=0.0)
    return parameter.default == value
