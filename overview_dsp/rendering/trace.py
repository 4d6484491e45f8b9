"""What the disk did, column by column."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels.layout import TRACE_COLUMNS


class Trace(Mapping[str, NDArray[np.float64]]):
    """The trace's columns, float64, one value a frame: `trace.torque` or `trace["torque"]`.

    time (s, frame end), theta2 (rad, the smoothed value used), touching (0 or 1), theta1 (rad) and
    omega1 (rad/s) at the frame's end, cursor, friction (N m s/rad, the B used), torque (N m,
    friction times the step's mean omega1, and what bristles and detents add), envelope (the
    tactor's amplitude).
    """

    time: NDArray[np.float64]
    theta2: NDArray[np.float64]
    touching: NDArray[np.float64]
    theta1: NDArray[np.float64]
    omega1: NDArray[np.float64]
    cursor: NDArray[np.float64]
    friction: NDArray[np.float64]
    torque: NDArray[np.float64]
    envelope: NDArray[np.float64]

    def __init__(self, table: NDArray[np.float64], names: tuple[str, ...] = TRACE_COLUMNS) -> None:
        """`table` is float64 (frames, columns), the columns those of `names`."""
        self._table = table
        self._names = names

    if not TYPE_CHECKING:  # a type checker knows the columns above, and no others

        def __getattr__(self, name: str) -> NDArray[np.float64]:
            # a column is made when it is first asked for
            if name.startswith("_") or name not in self._names:
                raise AttributeError(f"the trace has no column {name!r}")
            column = np.ascontiguousarray(self._table[:, self._names.index(name)])
            setattr(self, name, column)
            return column

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """A column by its name."""
        if name not in self._names:
            raise KeyError(name)
        column: NDArray[np.float64] = getattr(self, name)
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<Trace: {len(self._table)} frames of {', '.join(self._names)}>"


if TYPE_CHECKING:
    from typing_extensions import TypeVar as DefaultTypeVar

    Traced = DefaultTypeVar("Traced", bound=Trace | None, covariant=True, default=Trace)
else:
    Traced = TypeVar("Traced")
"""What a render keeps of its trace: `Trace`, or `None` without one."""
