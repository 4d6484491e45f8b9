"""Offline: a timeline, a preset and a gesture, block by block to arrays or to disk."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.actuators.model import Actuator
from overview_dsp.actuators.stage import ActuatorStage, Protected, warn_of_carrier
from overview_dsp.engine.engine import Engine
from overview_dsp.engine.meters import Strikes
from overview_dsp.engine.replay import apply_change
from overview_dsp.errors import InputError
from overview_dsp.gestures import Gesture
from overview_dsp.kernels.layout import TRACE_COLUMNS
from overview_dsp.presets.model import Preset
from overview_dsp.result_page import Row, result_page
from overview_dsp.sound_file import save_sound
from overview_dsp.timeline import Timeline

BLOCK = 4096
LONGEST_TAIL_S = 30.0
MAX_TAIL_S = 24 * 3600.0
FED_AHEAD = 4000
"""Control events that may wait in the engine: its ring holds 4096."""

TACTOR = 1
"""The tactor's channel."""

REST_S = 0.05
"""At rest: for so long the disk is where its springs want it and both channels are zero."""

Tail = Literal["rest", "none"] | float
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Block:
    """One rendered block: samples float32 (frames, 2), trace float64 (frames, 9) or None."""

    samples: NDArray[np.float32]
    trace: NDArray[np.float64] | None
    strikes: Strikes


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

    def __getattr__(self, name: str) -> NDArray[np.float64]:
        # a column is made when it is first asked for
        if name not in self._names:
            raise AttributeError(name)
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


@dataclass(frozen=True, eq=False)
class Result:
    """A rendered gesture.

    Attributes
    ----------
    samples : float32 (frames, 2)
        Click, tactor.
    sample_rate : float
        Hz.
    trace : Trace or None
        What the disk did, one value a frame.
    strikes : Strikes
        The events passed.
    engine : Engine
        As it stands after the gesture: surface, meters, parameters.
    protected : Protected or None
        What an actuator's protection did; the tactor's samples are its drive then.
    """

    samples: NDArray[np.float32]
    sample_rate: float
    trace: Trace | None
    strikes: Strikes
    engine: Engine
    protected: Protected | None = None

    def save(self, path: str | os.PathLike[str], subtype: str | None = None) -> None:
        """Write the samples to a sound file; the suffix says the format (WAV, FLAC, ...)."""
        save_sound(path, self.samples, self.sample_rate, subtype)

    def _repr_html_(self) -> str:
        """What a notebook shows: a player and the gesture's curves."""
        rows: list[Row] = []
        if self.trace is not None:
            rows = [
                ("hand, rad", self.trace.theta2 * self.trace.touching, "#009E73"),
                ("cursor", self.trace.cursor, "#000000"),
                ("torque, mN·m", 1e3 * self.trace.torque, "#0072B2"),
                ("vibration", self.trace.envelope, "#D55E00"),
            ]
        title = f"{self.engine.timeline.title or 'timeline'}, preset {self.engine.preset.name}"
        return result_page(title, self.samples, self.sample_rate, rows)


def tail_of(text: str) -> Tail:
    """The tail a person typed: rest, none, or seconds."""
    if text == "rest":
        return "rest"
    if text == "none":
        return "none"
    try:
        return checked_tail(float(text))
    except ValueError:
        raise _no_tail(text) from None


def checked_tail(tail: Tail) -> Tail:
    """The tail, if it is one; InputError otherwise."""
    if tail == "rest" or tail == "none":
        return tail
    # written so that NaN fails
    if isinstance(tail, str | bool) or not 0.0 <= tail <= MAX_TAIL_S:
        raise _no_tail(tail)
    return float(tail)


def _no_tail(given: object) -> InputError:
    return InputError(
        f"tail {given!r} is not understood; it is rest, none or seconds, 0 to {MAX_TAIL_S:g}"
    )


class Play:
    """A gesture through a prepared engine in steps: what to feed, how far to go, when it is over.

    A step is `feed`, a block of as many frames or fewer processed by the engine, `count`.
    """

    def __init__(self, engine: Engine, gesture: Gesture, tail: Tail, block: int) -> None:
        """From the engine's present sample on; steps have up to `block` frames."""
        tail = checked_tail(tail)
        rate = engine.sample_rate
        self._engine, self._gesture, self._block = engine, gesture, block
        self._stamps = stamps = gesture.stamps(rate)
        length = max(round(gesture.duration_s * rate), int(stamps[-1]) + 1 if len(stamps) else 0)
        self._to_rest = tail == "rest"
        if tail == "none":
            self._end = self._most = length
        elif tail == "rest":
            self._end, self._most = length, length + round(LONGEST_TAIL_S * rate)
        else:
            self._end = self._most = length + round(tail * rate)
        self._quiet = round(REST_S * rate)
        self._start = engine.sample_time
        self._whole = engine.timeline
        self._changes = [(round(change.time_s * rate), change.what) for change in gesture.changes]
        self._done = self._fed = self._changed = 0
        self._rested = False

    @property
    def over(self) -> bool:
        """Whether there is nothing left to process."""
        return self._rested or self._done >= self._most

    @property
    def least(self) -> int:
        """The frames that there will be, without the tail until rest."""
        return self._end

    @property
    def part(self) -> float:
        """The part done, 0 to 1; the tail until rest doesn't count."""
        return min(1.0, self._done / max(1, self._end))

    def feed(self) -> int:
        """Give the engine the gesture's next events; the frames they last for."""
        stamps, done = self._stamps, self._done
        frames = min(self._block, self._most - done)
        ahead = int(np.searchsorted(stamps, done + frames))
        waiting = max(0, self._fed - int(np.searchsorted(stamps, done)))
        # a denser take is fed in shorter blocks
        if ahead - self._fed > FED_AHEAD - waiting:
            ahead = self._fed + FED_AHEAD - waiting
            frames = max(1, int(stamps[ahead]) - done)
        changes = self._changes
        while self._changed < len(changes) and changes[self._changed][0] <= done:
            what = changes[self._changed][1]
            apply_change(self._engine, self._whole, what, self._start + done)
            self._changed += 1
        if self._changed < len(changes):
            # a change is made when it is due: only two surfaces can wait
            frames = min(frames, changes[self._changed][0] - done)
            ahead = min(ahead, int(np.searchsorted(stamps, done + frames)))
        if ahead > self._fed:
            now = slice(self._fed, ahead)
            self._engine.control_all(
                self._gesture.theta2[now],
                self._gesture.touching[now],
                self._start + stamps[now],
                self._gesture.source[now],
            )
            self._fed = ahead
        return frames

    def count(self, frames: int, silent_samples: int | None = None) -> int:
        """Count frames as processed; how many of them belong to the gesture and its tail.

        `silent_samples` is what a stage after the engine says of its own silence.
        """
        self._done += frames
        meters = self._engine.meters
        at_rest = min(meters.silent_samples, meters.still_samples, self._done - self._end)
        if silent_samples is not None:
            at_rest = min(at_rest, silent_samples)
        self._rested = self._to_rest and at_rest >= self._quiet
        # cut where rest was reached: the end doesn't depend on the blocks
        return frames - (at_rest - self._quiet) if self._rested else frames


def blocks(
    engine: Engine,
    gesture: Gesture,
    tail: Tail = "rest",
    trace: bool = True,
    progress: Progress | None = None,
    stage: ActuatorStage | None = None,
    block: int | None = None,
) -> Iterator[Block]:
    """Play a gesture through a prepared engine, block by block, in constant memory.

    `progress` is told the part done, 0 to 1. The blocks' arrays are their reader's to keep.
    With an actuator's `stage`, the tactor's samples are its drive. A block has up to `block` frames
    (None: `BLOCK`).
    """
    play = Play(engine, gesture, tail, block or BLOCK)
    while not play.over:
        frames = play.feed()
        samples = np.empty((frames, 2), dtype=np.float32)
        table = np.empty((frames, len(TRACE_COLUMNS))) if trace else None
        engine.process(samples, table)
        if stage is not None:
            stage.process(samples, TACTOR)
        kept = play.count(frames, stage.silent_samples if stage is not None else None)
        yield Block(
            samples[:kept], table[:kept] if table is not None else None, engine.take_strikes()
        )
        if progress:
            progress(play.part)


def render(
    timeline: Timeline,
    preset: Preset,
    gesture: Gesture,
    sample_rate: float = 48_000,
    seed: int = 0,
    *,
    tail: Tail = "rest",
    trace: bool = True,
    actuator: Actuator | None = None,
) -> Result:
    """Render a gesture to arrays.

    `tail` is "rest" (on until the disk has come to rest, at most 30 s), "none" or seconds.
    With an `actuator` the tactor's channel is its drive, within what it may be given.
    The same arguments give the same bits on every machine.

    Raises
    ------
    InputError
        A sample rate out of range, or parameters that don't fit it.
    """
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(sample_rate, BLOCK)
    nothing = Block(
        np.empty((0, 2), dtype=np.float32), np.empty((0, len(TRACE_COLUMNS))), engine.take_strikes()
    )
    stage = _stage(actuator, engine)
    rendered = [nothing, *blocks(engine, gesture, tail, trace, stage=stage)]
    samples = np.concatenate([block.samples for block in rendered])
    table = np.concatenate([b.trace for b in rendered if b.trace is not None])
    strikes = join_strikes([block.strikes for block in rendered])
    kept = Trace(table) if trace else None
    protected = stage.protected if stage is not None else None
    return Result(samples, engine.sample_rate, kept, strikes, engine, protected)


def _stage(actuator: Actuator | None, engine: Engine) -> ActuatorStage | None:
    if actuator is None:
        return None
    warn_of_carrier(actuator, engine.preset.number("tactor.frequency_hz"))
    return ActuatorStage(actuator, engine.sample_rate)


def join_strikes(parts: list[Strikes]) -> Strikes:
    """Strikes of consecutive blocks as one."""
    return Strikes(
        np.concatenate([part.time_s for part in parts]),
        np.concatenate([part.event for part in parts]),
        np.concatenate([part.torque for part in parts]),
        np.concatenate([part.level for part in parts]),
    )


def render_to_file(
    timeline: Timeline,
    preset: Preset,
    gesture: Gesture,
    path: str | os.PathLike[str],
    sample_rate: float = 48_000,
    seed: int = 0,
    *,
    tail: Tail = "rest",
    subtype: str | None = None,
    trace_path: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    actuator: Actuator | None = None,
) -> Rendered:
    """Render a gesture to a sound file, and its trace to a .npz or .csv, in constant memory.

    Both files are whole or absent.

    Raises
    ------
    InputError, OutputError
        As `render`; an unknown format, an unwritable place, a full disk.
    """
    from overview_dsp.sound_file import SoundWriter
    from overview_dsp.trace_file import TraceWriter

    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(sample_rate, BLOCK)
    stage = _stage(actuator, engine)
    peaks = np.zeros(2)
    strikes = 0
    with (
        SoundWriter(Path(path), engine.sample_rate, subtype) as sound,
        TraceWriter(Path(trace_path) if trace_path is not None else None) as traced,
    ):
        for block in blocks(engine, gesture, tail, trace_path is not None, progress, stage):
            sound.write(block.samples)
            if block.trace is not None:
                traced.write(block.trace)
            peaks = np.maximum(peaks, np.abs(block.samples).max(axis=0, initial=0.0))
            strikes += len(block.strikes)
        # both, before either appears: a full disk leaves none of the two
        sound.finish()
        traced.finish()
        frames, note = sound.frames, sound.note
    protected = stage.protected if stage is not None else None
    seconds = frames / engine.sample_rate
    return Rendered(seconds, tuple(peaks.tolist()), strikes, note, engine, protected)


@dataclass(frozen=True)
class Rendered:
    """What was written: duration (s), peak of click and tactor (linear), strikes, format note.

    `protected` is what an actuator's protection did, if there was one.
    """

    duration_s: float
    peaks: tuple[float, ...]
    strikes: int
    note: str
    engine: Engine
    protected: Protected | None = None
