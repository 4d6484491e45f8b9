"""Offline rendering of a timeline, a preset and a gesture to arrays or files.

Arguments are objects, or the names and paths that a user would type for them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Literal, overload

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.readers.tables.memory import TimelineData
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.gestures.spec import DEFAULT, parse_gesture
from overview_dsp.design.gestures.take import load_gesture
from overview_dsp.design.presets.library import fitting_preset_for, load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.files.sound import SavableSound
from overview_dsp.kernels.device.router import FRAMES
from overview_dsp.kernels.layout import CLICK, TACTOR, TRACE_COLUMNS
from overview_dsp.offline.rendering.event_log import transcript
from overview_dsp.offline.rendering.notebook import Row, result_page
from overview_dsp.offline.rendering.schedule import GesturePlayer, Tail, unreached
from overview_dsp.offline.rendering.trace import Trace, Traced, TraceWriter
from overview_dsp.public import counted, plot_with, short
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import ActuatorStage, ProtectionReport, warn_of_carrier
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import Strikes
from overview_dsp.units import gain_to_db

if TYPE_CHECKING:
    from matplotlib.figure import Figure


AnyTimeline = Timeline | TimelineData  # a Timeline, or an argument of `load_timeline`

AnyPreset = Preset | str | os.PathLike[str] | None
"""A Preset, name or path; None selects one that fits the data."""

AnyGesture = Gesture | str | os.PathLike[str] | None
"""A Gesture, SPEC or path of a take; None is `gestures.spec.DEFAULT`."""


BLOCK = 4096
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Block:
    """Rendered block: samples float32 (frames, 1 + tactors), trace (frames, columns) or None."""

    samples: SampleArray
    trace: FloatArray | None
    strikes: Strikes


@dataclass(frozen=True, eq=False)
class RenderResult(SavableSound, Generic[Traced]):
    """Rendered gesture, which notebooks display as a player with curves.

    Attributes
    ----------
    samples : float32 (frames, 1 + tactors)
        Click, tactor (or all tactors); linear, full scale is 1.
    sample_rate : float
        Hz.
    trace : Trace or None
        Trace of the disk; None if rendered with `trace=False`.
    strikes : Strikes
        The events passed.
    engine : Engine
        Engine after the gesture, with surface, meters and parameters.
    protected : ProtectionReport or None
        Report of an actuator's protection; the tactor's samples are its drive then.
    unreached : tuple of int
        Indices of the timeline's events that the input passed but the disk never reached.

    See Also
    --------
    render : Render a gesture.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> clicks, vibration = result.samples.T
    >>> len(result.trace.cursor) == len(clicks)
    True
    >>> result.engine.preset.name
    'football'
    """

    samples: SampleArray
    sample_rate: float
    trace: Traced
    strikes: Strikes
    engine: Engine
    protected: ProtectionReport | None = None
    unreached: tuple[int, ...] = ()

    def plot(self) -> Figure:
        """Plot torque, friction, disk and input over time.

        Returns
        -------
        matplotlib.figure.Figure
            Figure like the paper's figures 5 and 6.

        Raises
        ------
        InputError
            The result has no trace.

        Examples
        --------
        >>> result = ov.render("world-cup-final-2018", "football", "sweep:0.5", sample_rate=8000)
        >>> result.plot().savefig("sweep.png")
        """
        if self.trace is None:
            raise InputError("the result has no trace to plot; render with trace=True")
        title = f"{self.engine.timeline.title}, preset {self.engine.preset.name}"
        return plot_with(
            "offline.plots.paper", "plot_strokes", [("", self)], self.engine.timeline, title
        )

    def _repr_html_(self) -> str:
        """Return HTML for notebooks: player, curves and transcript."""
        rows: list[Row] = []
        if self.trace is not None:
            rows = [
                ("disk 2, rad", self.trace.theta2 * self.trace.engaged, "#009E73"),
                ("cursor", self.trace.cursor, "#000000"),
                ("torque, mN·m", 1e3 * self.trace.torque, "#0072B2"),
                ("vibration", self.trace.envelope, "#D55E00"),
            ]
        timeline = self.engine.timeline
        title = f"{timeline.title or 'timeline'}, preset {self.engine.preset.name}"
        engaged = self.trace.engaged if self.trace is not None else None
        spoken = transcript(self.strikes, timeline, engaged, self.sample_rate)
        passed = len(self.strikes.of_events())
        felt = self.samples[:, 1:]
        # of several tactors, the one that vibrates most
        loudest = np.take_along_axis(felt, np.abs(felt).argmax(axis=1)[:, None], axis=1)
        heard = np.hstack([self.samples[:, :1], loudest])
        return result_page(title, heard, self.sample_rate, rows, spoken, passed)

    def __repr__(self) -> str:
        return (
            f"<RenderResult: {len(self.samples) / self.sample_rate:.3f} s at {self.sample_rate:g} "
            f"Hz, {counted(len(self.strikes), 'strike')}, {short(self.engine.preset.name)} on "
            f"{short(self.engine.timeline.title)}>"
        )


def channels_of(engine: Engine) -> int:
    """Return the number of rendered channels: one for the clicks, and one for each tactor."""
    return 2 if engine.router is None else 1 + engine.router.count


def blocks(
    engine: Engine,
    gesture: Gesture,
    tail: Tail = "rest",
    trace: bool = True,
    progress: Progress | None = None,
    stage: ActuatorStage | None = None,
) -> Iterator[Block]:
    """Render a gesture with a prepared engine, block by block, in constant memory.

    `progress` receives the progress, 0 to 1. The blocks' arrays are not reused. With an actuator's
    `stage`, the tactor's samples are its drive. Blocks have up to `BLOCK` frames.
    """
    router = engine.router
    play = GesturePlayer(engine, gesture, tail, BLOCK if router is None else FRAMES)
    while not play.over:
        frames = play.feed()
        samples = np.empty((frames, channels_of(engine)), dtype=np.float32)
        table = np.empty((frames, len(TRACE_COLUMNS))) if trace or router else None
        engine.process(samples, table)
        if stage is not None:
            stage.process(samples, TACTOR)
        if router is not None and table is not None:
            router.process(engine.memory, samples, table)
        kept = play.count(frames, stage.silent_samples if stage is not None else None)
        yield Block(
            samples[:kept],
            table[:kept] if trace and table is not None else None,
            engine.pop_strikes(),
        )
        if progress:
            progress(play.part)


# fmt: off
@overload
def render(
    timeline: AnyTimeline, preset: AnyPreset = ..., gesture: AnyGesture = ...,
    sample_rate: float = ..., seed: int = ..., *, tail: Tail = ..., trace: Literal[True] = ...,
    actuator: Actuator | None = ..., tactors: int = ...,
) -> RenderResult[Trace]: ...
@overload
def render(
    timeline: AnyTimeline, preset: AnyPreset = ..., gesture: AnyGesture = ...,
    sample_rate: float = ..., seed: int = ..., *, tail: Tail = ..., trace: Literal[False],
    actuator: Actuator | None = ..., tactors: int = ...,
) -> RenderResult[None]: ...
@overload
def render(
    timeline: AnyTimeline, preset: AnyPreset = ..., gesture: AnyGesture = ...,
    sample_rate: float = ..., seed: int = ..., *, tail: Tail = ..., trace: bool,
    actuator: Actuator | None = ..., tactors: int = ...,
) -> RenderResult[Trace | None]: ...
# fmt: on
def render(
    timeline: AnyTimeline,
    preset: AnyPreset = None,
    gesture: AnyGesture = None,
    sample_rate: float = 48_000,
    seed: int = 0,
    *,
    tail: Tail = "rest",
    trace: bool = True,
    actuator: Actuator | None = None,
    tactors: int = 1,
) -> RenderResult[Trace | None]:
    """Render a gesture to arrays.

    The same arguments give the same bits on every machine.

    Parameters
    ----------
    timeline : Timeline, or what `load_timeline` takes
        Data to render.
    preset : Preset, str, path or None
        Parameters of feel and sound; None selects the bundled preset that fits the data.
    gesture : Gesture, str, path or None
        Movement, also as a SPEC (`"sweep:2"`) or the path of a take; None is `"sweep:4"`.
    sample_rate : float
        Hz, 1 000 to 768 000; the preset's carrier must stay below 0.45 of it.
    seed : int
        Seed of the texture noise.
    tail : {"rest", "none"} or float
        Duration after the gesture: until the disk is at rest (at most 30 s), none, or seconds.
    trace : bool
        Whether to return the trace of the disk.
    actuator : Actuator or None
        Actuator whose protected drive replaces the tactor's channel.
    tactors : int
        Number of tactors, 1 to 8, among which the preset's `tactor.routing` splits the signal.

    Returns
    -------
    RenderResult
        Samples, trace, strikes, and the engine after the gesture.

    Raises
    ------
    InputError
        The sample rate or tail is out of range, parameters don't fit the rate, or a timeline,
        preset or gesture can't be read.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000, tail="none")
    >>> result.samples.shape
    (4001, 2)
    >>> result.trace.torque.max() > 0.0
    np.True_
    >>> days = {"2024-01-01": 7.5, "2024-01-02": 9.0, "2024-01-03": 8.0, "2024-01-04": 8.2}
    >>> ov.render(days, "series", "sweep:1", sample_rate=8000).engine.preset.name
    'series'
    """
    engine, moved, stage = _prepared(
        timeline, preset, gesture, sample_rate, seed, actuator, tactors
    )
    nothing = Block(
        np.empty((0, channels_of(engine)), dtype=np.float32),
        np.empty((0, len(TRACE_COLUMNS))),
        engine.pop_strikes(),
    )
    rendered = [nothing, *blocks(engine, moved, tail, trace, stage=stage)]
    samples = np.concatenate([block.samples for block in rendered])
    table = np.concatenate([b.trace for b in rendered if b.trace is not None])
    strikes = join_strikes([block.strikes for block in rendered])
    return RenderResult(
        samples,
        engine.sample_rate,
        Trace(table) if trace else None,
        strikes,
        engine,
        stage.protected if stage is not None else None,
        unreached(engine.surface, moved, strikes.event),
    )


def _prepared(
    timeline: AnyTimeline,
    preset: AnyPreset,
    gesture: AnyGesture,
    sample_rate: float,
    seed: int,
    actuator: Actuator | None,
    tactors: int,
) -> tuple[Engine, Gesture, ActuatorStage | None]:
    """Return a prepared engine, gesture and actuator stage from the arguments of `render`."""
    timeline = load_timeline(timeline)
    if not isinstance(preset, Preset):
        chosen = fitting_preset_for(timeline).preset if preset is None else preset
        preset = load_preset(validation.path(chosen, "preset"))
    engine = Engine(preset, timeline, seed=seed)
    if gesture is None or isinstance(gesture, str):
        gesture = parse_gesture(DEFAULT if gesture is None else gesture)
    elif not isinstance(gesture, Gesture):
        gesture = load_gesture(validation.path(gesture, "gesture"))
    engine.prepare(sample_rate, BLOCK)
    engine.set_tactors(tactors)
    return engine, gesture, _stage(actuator, engine)


def _stage(actuator: Actuator | None, engine: Engine) -> ActuatorStage | None:
    if actuator is None:
        return None
    warn_of_carrier(actuator, engine.preset.number("tactor.frequency_hz"))
    return ActuatorStage(actuator, engine.sample_rate)


def join_strikes(parts: list[Strikes]) -> Strikes:
    """Return strikes of consecutive blocks as one."""
    columns = (vars(part).values() for part in parts)
    return Strikes(*map(np.concatenate, zip(*columns, strict=True)))


@dataclass(frozen=True)
class RenderFileResult:
    """Result of `render_to_file`.

    Attributes
    ----------
    duration_s : float
        Length, s.
    peaks : tuple of float
        Peaks of click and tactor, linear.
    strikes : int
        Number of passed events and slips of bristles.
    note : str
        Message about the conversion of samples to the format; may be empty.
    engine : Engine
        Engine after the gesture.
    protected : ProtectionReport or None
        Report of an actuator's protection, if any.
    unreached : tuple of int
        As in `RenderResult`.
    passed : Strikes or None
        Strikes of events.
    lufs : float or None
        Loudness of the written click channel (ITU-R BS.1770), if requested; None for silence.
    gain_db : float
        Gain of the click by `normalize`, dB.
    limited_db : float
        Highest reduction of a peak by the limiter of `normalize`, dB.

    Examples
    --------
    >>> ov.render_to_file(match, football, ov.sweep(0.5), "a.wav", 8000, tail="none").duration_s
    0.500125
    """

    duration_s: float
    peaks: tuple[float, ...]
    strikes: int
    note: str
    engine: Engine
    protected: ProtectionReport | None = None
    unreached: tuple[int, ...] = ()
    passed: Strikes | None = None
    lufs: float | None = None
    gain_db: float = 0.0
    limited_db: float = 0.0

    def __repr__(self) -> str:
        return (
            f"<RenderFileResult: {self.duration_s:.3f} s, {counted(self.strikes, 'strike')}, "
            f"peaks {self.peaks[0]:.3g} and {self.peaks[1]:.3g}>"
        )


def render_to_file(
    timeline: AnyTimeline,
    preset: AnyPreset,
    gesture: AnyGesture,
    path: str | os.PathLike[str],
    sample_rate: float = 48_000,
    seed: int = 0,
    *,
    tail: Tail = "rest",
    subtype: str | None = None,
    trace_path: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    actuator: Actuator | None = None,
    stems: bool = False,
    loudness: bool = False,
    normalize: float | None = None,
    tactors: int = 1,
) -> RenderFileResult:
    """Render a gesture to a sound file, and its trace to a .npz or .csv, in constant memory.

    Both files are whole or absent.

    Parameters
    ----------
    timeline : Timeline, or what `load_timeline` takes
        Data to render.
    preset : Preset, str, path or None
        Parameters of feel and sound; None selects the bundled preset that fits the data.
    gesture : Gesture, str, path or None
        Movement, also as a SPEC (`"sweep:2"`) or the path of a take; None is `"sweep:4"`.
    path : str or path
        Sound file. Its suffix selects a format of libsndfile, such as WAV or FLAC.
    sample_rate : float
        Whole number, Hz.
    seed : int
        Seed of the texture noise.
    tail : {"rest", "none"} or float
        As in `render`.
    subtype : str or None
        Subtype of libsndfile (`"PCM_16"`, `"FLOAT"`); None is the format's default.
    trace_path : str or path or None
        File for the trace, if any.
    progress : callable or None
        Called with the progress, 0 to 1.
    actuator : Actuator or None
        As in `render`.
    stems : bool
        Whether to also write the single channels, `OUT.click.wav` and `OUT.tactor.wav`, and
        `OUT.trace.wav`: cursor, touching, torque and envelope as four channels of a float file.
    loudness : bool
        Whether to measure the click's loudness.
    normalize : float or None
        Target loudness of the click channel, LUFS. A look-ahead limiter keeps its true peaks
        below -1 dBFS. The tactor isn't changed. This renders twice, or up to eight times where the
        limiter acts.
    tactors : int
        As in `render`.

    Returns
    -------
    RenderFileResult
        Properties of the written files.

    Raises
    ------
    InputError
        As in `render`; the format is unknown or the path can't be written.
    OutputError
        The disk is full.

    Examples
    --------
    >>> written = ov.render_to_file(match, football, ov.tap(0.8), "tap.flac", sample_rate=8000)
    >>> written.strikes > 0
    True
    """
    from overview_dsp.files.sound import SoundWriter
    from overview_dsp.offline.rendering.stems import (
        ClickMeter,
        StemWriter,
        limited_to,
        loudness_of,
        require_loudness,
    )

    target = validation.path(path, "path")
    if normalize is not None:
        require_loudness(normalize)
    engine, moved, stage = _prepared(
        timeline, preset, gesture, sample_rate, seed, actuator, tactors
    )
    limiter, gain = None, 1.0
    if normalize is not None:

        def again() -> Iterator[Block]:
            yield from blocks(engine, moved, tail, False, None, _stage(actuator, engine))
            engine.reset()

        limiter, gain = limited_to(normalize, sample_rate, again)
    heard = ClickMeter(sample_rate) if loudness or normalize is not None else None
    peaks = np.zeros(channels_of(engine))
    strikes: list[Strikes] = [engine.pop_strikes()]
    full_torque = 1e-3 * engine.preset.number("tactor.reference_torque_mnm")
    stem = (target, engine.sample_rate, subtype, full_torque, stems, channels_of(engine) - 1)
    trace_file = None if trace_path is None else validation.path(trace_path, "trace_path")
    with (
        SoundWriter(target, engine.sample_rate, subtype, len(peaks)) as sound,
        TraceWriter(trace_file) as traced,
        StemWriter(*stem) as stemmed,
    ):
        for block in blocks(engine, moved, tail, trace_path is not None or stems, progress, stage):
            if limiter is not None:
                limiter.apply(block.samples[:, CLICK])
            sound.write(block.samples)
            stemmed.write(block.samples, block.trace)
            if block.trace is not None and trace_path is not None:
                traced.write(block.trace)
            if heard is not None:
                heard.feed(block.samples)
            peaks = np.maximum(peaks, np.abs(block.samples).max(axis=0, initial=0.0))
            strikes.append(block.strikes)
        # all files before any appears, so that a full disk leaves none
        sound.finish()
        traced.finish()
        stemmed.finish()
        frames, note = sound.frames, sound.note
    all_strikes = join_strikes(strikes)
    return RenderFileResult(
        frames / engine.sample_rate,
        (float(peaks[0]), float(peaks[1:].max())),
        len(all_strikes),
        note,
        engine,
        stage.protected if stage is not None else None,
        unreached(engine.surface, moved, all_strikes.event),
        all_strikes.of_events(),
        loudness_of(heard.steps()) if heard is not None else None,
        gain_to_db(gain),
        0.0 if limiter is None else gain_to_db(1.0 / limiter.lowest),
    )
