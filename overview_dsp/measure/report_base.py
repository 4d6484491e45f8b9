"""Base class of reports, which become data for JSON, a table of text, or warnings."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

from overview_dsp.errors import InputError, did_you_mean, quoted

T = TypeVar("T")


class Report(ABC):
    """Measurements of a preset."""

    def to_json(self) -> dict[str, Any]:
        """Return the report as data for JSON; a quantity of events that were not felt is None.

        Returns
        -------
        dict
            Texts, numbers and lists, for JSON.

        Examples
        --------
        >>> report = ov.measure.feel_report(plain, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> sorted(report.to_json())
        ['preset', 'strokes', 'timelines']
        """
        return self._plain()

    def table(self) -> str:
        """Return the report as text, one block per stroke.

        Returns
        -------
        str
            Lines of a table.

        Examples
        --------
        >>> report = ov.measure.feel_report(plain, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> report.table().splitlines()[0]
        'plain on France 4-2 Croatia, World Cup final, Moscow, 15 July 2018'
        """
        return "\n".join(self._lines())

    def warnings(self) -> list[str]:
        """List the events that a user would miss or confuse.

        Returns
        -------
        list of str
            One line per problem, with a remedy if one is known.

        Examples
        --------
        >>> report = ov.measure.feel_report(plain, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> all(isinstance(line, str) for line in report.warnings())
        True
        """
        return list(self._warning_lines())

    def _plain(self) -> dict[str, Any]:
        return dict(plain_data(self))

    @abstractmethod
    def _lines(self) -> Iterable[str]:
        """Yield the lines of the table."""

    @abstractmethod
    def _warning_lines(self) -> Iterable[str]:
        """Yield the warnings."""


def entry_named(name: str, by_name: Mapping[str, T], what: str) -> T:
    """Return the entry of that name; InputError with the nearest name if there is none."""
    if not isinstance(name, str) or name not in by_name:
        hint = did_you_mean(str(name), by_name)
        raise InputError(f"no {what} of the report is named {quoted(name)}{hint}")
    return by_name[name]


def cell(value: float, width: int, digits: int = 1) -> str:
    """Return a number as a table cell; a dash if it is not finite."""
    if not math.isfinite(value):
        return f"{'-':>{width}}"
    text = f"{value:.{digits}f}" if abs(value) < 1e4 else f"{value:.3g}"
    return f"{text:>{width}}"


def plain_data(value: Any, digits: int = 4) -> Any:
    """Return texts, rounded numbers and lists, and a dataclass as a dict; NaN is None.

    A field with `digits` in its metadata is rounded to that many decimal places.
    """
    if is_dataclass(value):
        return {
            field.name: plain_data(getattr(value, field.name), field.metadata.get("digits", digits))
            for field in fields(value)
        }
    if isinstance(value, tuple | list):
        return [plain_data(one, digits) for one in value]
    if isinstance(value, float):
        return round(value, digits) if math.isfinite(value) else None
    return value
