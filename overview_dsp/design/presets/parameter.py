"""Parameter: id, unit, range, default and description, and tables of parameters."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from overview_dsp.errors import InputError, quoted

Value = float | bool | str


@dataclass(frozen=True)
class Parameter:
    """Parameter of a preset: id, unit, range, default and description.

    Parameters
    ----------
    id : str
        Id, `section.key`.
    default : float, bool, str or None
        Default; None if a value is required.
    low, high : float
        Range of a number, in the unit.
    unit : str
        Unit; empty without one.
    doc : str
        Description in one sentence.
    choices : tuple
        Allowed values; empty for numbers, False and True for a flag.
    scale : {"linear", "log"}
        Scale of a slider.
    surface : bool
        Whether a change makes a new friction table.

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
        """Last part of the id: the key in its section of a preset file."""
        return self.id.rpartition(".")[2]

    @property
    def allowed(self) -> str:
        """Text of the allowed values, with the unit."""
        if self.choices:
            return " or ".join(
                value_text(choice) if isinstance(choice, bool) else f'"{choice}"'
                for choice in self.choices
            )
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.low:g} to {self.high:g}{unit}"

    def check(self, value: object) -> Value:
        """Return a valid value; nothing is clamped.

        Parameters
        ----------
        value : object
            Value to check.

        Returns
        -------
        float, bool or str
            Value in the parameter's own type.

        Raises
        ------
        InputError
            Wrong type, not a number, or outside the range.

        Examples
        --------
        >>> ov.presets.PARAMETERS["tactor.gain_db"].check(99.0)
        Traceback (most recent call last):
        overview_dsp.errors.InputError: tactor.gain_db = 99 is out of range; allowed: -60 to 12 dB
        """
        if self.choices:
            if not isinstance(value, bool | str) or (
                isinstance(self.choices[0], bool) != isinstance(value, bool)
                or value not in self.choices
            ):
                raise InputError(
                    f"{self.id} = {quoted(value)} is not allowed; allowed: {self.allowed}"
                )
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(
                f"{self.id} = {quoted(value)} is not a number; allowed: {self.allowed}"
            )
        try:
            number = float(value)
        except OverflowError:
            number = math.inf if value > 0 else -math.inf
        # NaN fails too
        if not self.low <= number <= self.high:
            raise InputError(f"{self.id} = {number:g} is out of range; allowed: {self.allowed}")
        return number

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id}: {self.allowed}, default {self.default}>"


def read_parameters(file: Path) -> dict[str, Parameter]:
    """Return the parameters of a TOML table by id (`section.key`)."""
    sections = tomllib.loads(file.read_text(encoding="utf-8"))
    return {
        (id := f"{section}.{key}"): _parameter(id, **settings)
        for section, members in sections.items()
        for key, settings in members.items()
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
    """Return a value as text: `true`, `0.5`, `gaussian`."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else value


def is_default(parameter: Parameter, value: Value) -> bool:
    """Return whether a value is the parameter's default, except for rounding."""
    if isinstance(parameter.default, float) and isinstance(value, float):
        return math.isclose(parameter.default, value, rel_tol=1e-12, abs_tol=0.0)
    return parameter.default == value
