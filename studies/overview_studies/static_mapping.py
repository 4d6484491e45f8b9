"""Control condition without a disk: the position of the input sets the vibration amplitude.

An event is a smooth bump of amplitude. It is as strong as the event in the friction condition while
the input touches, with a sweep of 2 s for free movement. Between events the amplitude follows the
intensity curve, at the event-free level of the friction condition. A click is that of a single
event of the kind. So both conditions have the same levels at the same positions, but the control
condition has no speed, inertia or recoil.

The page renders it live from the same numbers (docs/explanation/study-format.md). The result is
bit-identical: sums, products and divisions of float64 in the documented order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import gcd, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import Event, Gesture, Surface, Timeline, build_surface, measure, render, sweep
from overview_dsp.cli.extensions import CLICK, TACTOR, stroke_feel
from overview_studies.stimuli import Stimulus

COLUMNS = 1025
RAMP_S = 0.005
"""Ramp of position and gate after a control event."""

MIN_BUMP_WIDTH = 0.04
"""Minimum width of an event's bump, as a share of the timeline, for fast movements."""

WAVE_S, FADE_S = 0.08, 0.005
CEILING = 10.0 ** (-1.0 / 20.0)
MIN_LEVEL_DB = -80.0
CALIBRATION_PASSES = 2
"""Number of passes that measure and correct the bumps."""


@dataclass(frozen=True, eq=False)
class StaticMapping:
    """Control condition of one stimulus at one sample rate.

    Attributes
    ----------
    amplitude : float64 (COLUMNS,)
        Carrier amplitude at evenly spaced positions from 0 to 1.
    carrier : float64 (n,)
        A whole number of carrier periods.
    clicks : list of (position, wave)
    waves : list of float64 (samples,)
    """

    rate: int
    ramp: int
    amplitude: NDArray[np.float64]
    carrier: NDArray[np.float64]
    clicks: list[tuple[float, int]]
    waves: list[NDArray[np.float64]]

    def as_json(self) -> dict[str, Any]:
        """Return the data for the page."""
        return {
            "rate": self.rate,
            "ramp": self.ramp,
            "amplitude": self.amplitude.tolist(),
            "carrier": self.carrier.tolist(),
            "clicks": [{"place": position, "wave": wave} for position, wave in self.clicks],
            "waves": [wave.tolist() for wave in self.waves],
            "ceiling": CEILING,
        }

    def render(self, gesture: Gesture, tail_s: float = WAVE_S) -> NDArray[np.float32]:
        """Render a gesture: float32 (frames, 2), click and tactor."""
        samples, _ = self._render_with_cursor(gesture, tail_s)
        return samples

    def _render_with_cursor(
        self, gesture: Gesture, tail_s: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return the samples, and the cursor after each."""
        frames = round(gesture.duration_s * self.rate) + round(tail_s * self.rate)
        cursor, gate, before, held = self._cursor_and_gate(gesture, frames)
        x = cursor * (COLUMNS - 1)
        i = np.minimum(np.floor(x).astype(np.int64), COLUMNS - 2)
        a = self.amplitude[i] + (self.amplitude[i + 1] - self.amplitude[i]) * (x - i)
        tactor = gate * a * self.carrier[np.arange(frames) % len(self.carrier)]
        click = np.zeros(frames)
        for at, wave in self._click_onsets(before, cursor, held):
            part = self.waves[wave][: frames - at]
            click[at : at + len(part)] += part
        samples = np.empty((frames, 2), np.float32)
        samples[:, CLICK] = np.clip(click, -CEILING, CEILING)
        samples[:, TACTOR] = tactor
        return samples, cursor

    def _cursor_and_gate(
        self, gesture: Gesture, frames: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return cursor, gate, previous cursor and touch state of each sample."""
        cursor, gate = np.zeros(frames), np.zeros(frames)
        before, held = np.zeros(frames), np.zeros(frames, dtype=bool)
        c = g = to = gto = 0.0
        stamps = gesture.stamps(self.rate)
        order = np.flatnonzero(stamps < frames)
        # the last event of a sample starts the ramp
        for number, event in enumerate(order):
            start = int(stamps[event])
            target = float(gesture.theta2[event]) / pi
            if gto == 0.0:
                c = target
            to, gfrom, gto = target, g, 1.0 if gesture.touching[event] else 0.0
            stop = int(stamps[order[number + 1]]) if number + 1 < len(order) else frames
            k = np.minimum(np.arange(1, stop - start + 1), self.ramp) / self.ramp
            part = slice(start, stop)
            cursor[part] = c + (to - c) * k
            gate[part] = gfrom + (gto - gfrom) * k
            held[part] = gto == 1.0
            if stop > start:
                before[start], before[start + 1 : stop] = c, cursor[start : stop - 1]
                c, g = float(cursor[stop - 1]), float(gate[stop - 1])
        return cursor, gate, before, held

    def _click_onsets(
        self, before: NDArray[np.float64], after: NDArray[np.float64], held: NDArray[np.bool_]
    ) -> list[tuple[int, int]]:
        """Return the sample and wave of each click, in order of onset."""
        found = []
        for number, (position, wave) in enumerate(self.clicks):
            up = (before < position) & (position <= after)
            down = (after <= position) & (position < before)
            found += [(int(at), number, wave) for at in np.flatnonzero(held & (up | down))]
        return [(at, wave) for at, _, wave in sorted(found)]


def static_mapping(item: Stimulus, rate: int) -> StaticMapping:
    """Return the control condition of a stimulus, with matched levels."""
    gesture = sweep(2.0) if item.free else item.gesture
    rendered = render(item.timeline, item.preset, gesture, rate, item.seed)
    surface, trace = rendered.engine.surface, rendered.trace
    wanted, free_db = held_levels(surface, trace, rendered.samples[:, TACTOR], rate)
    wanted = np.where(np.isfinite(wanted), np.maximum(wanted, MIN_LEVEL_DB), MIN_LEVEL_DB)
    level = item.curve(COLUMNS)
    rest = level / max(float(np.mean(level)), 1e-9) * _peak(free_db) if level.any() else level
    kinds = [item.timeline.events[e].kind for e in surface.event]
    names = sorted(set(kinds))
    mapping = StaticMapping(
        rate,
        round(RAMP_S * rate),
        np.zeros(COLUMNS),
        _carrier(item.preset.number("tactor.frequency_hz"), rate),
        [(float(p), names.index(k)) for p, k in zip(surface.position, kinds, strict=True)],
        [_wave(item, kind, rate) for kind in names],
    )
    height = _peak(wanted)
    for _ in range(CALIBRATION_PASSES):
        mapping = StaticMapping(
            rate, mapping.ramp, _amplitude(surface.position, surface.span, height, rest),
            mapping.carrier, mapping.clicks, mapping.waves,
        )  # fmt: skip
        got = _levels(mapping, gesture, surface)
        height = height * np.where(np.isfinite(got), _peak(wanted) / _peak(got), 1.0)
    return StaticMapping(
        rate, mapping.ramp, _amplitude(surface.position, surface.span, height, rest),
        mapping.carrier, mapping.clicks, mapping.waves,
    )  # fmt: skip


def held_levels(
    surface: Surface,
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    rate: float,
) -> tuple[NDArray[np.float64], float]:
    """Return each event's level during touch, and the level between events, in dB."""
    found, free = np.full(len(surface.position), np.nan), MIN_LEVEL_DB
    for stroke in measure.strokes(columns["engaged"], columns["cursor"]):
        if stroke.name == "out":
            levels = stroke_feel(stroke, surface, columns, tactor, rate)
            found = np.fmax(found, levels.event_db)
            free = float(np.fmax(free, levels.event_free_db))
    return found, free


def static_levels(item: Stimulus, rate: int) -> NDArray[np.float64]:
    """Return each event's level in the control condition, in dB of full scale."""
    surface = build_surface(item.timeline, item.preset)
    gesture = sweep(2.0) if item.free else item.gesture
    return _levels(static_mapping(item, rate), gesture, surface)


def _peak(level_db: Any) -> Any:
    """Return the amplitude of a sine with a given level (RMS, dB of full scale)."""
    return np.sqrt(2.0) * 10.0 ** (np.asarray(level_db) / 20.0)


def _amplitude(
    position: NDArray[np.float64],
    span: NDArray[np.float64],
    height: NDArray[np.float64],
    rest: NDArray[np.float64],
) -> NDArray[np.float64]:
    x = np.arange(COLUMNS) / (COLUMNS - 1)
    found = rest.astype(np.float64).copy()
    for centre, (low, high), top in zip(position, span, height, strict=True):
        width = max(high - low, MIN_BUMP_WIDTH)
        part = np.clip(1.0 - np.square(2.0 * (x - centre) / width), 0.0, 1.0)
        found = np.maximum(found, top * part)
    return np.minimum(found, CEILING)


def _levels(mapping: StaticMapping, gesture: Gesture, surface: Surface) -> NDArray[np.float64]:
    """Return each event's level in the control condition."""
    samples, cursor = mapping._render_with_cursor(gesture, WAVE_S)
    engaged = np.zeros(len(cursor))
    stamps = gesture.stamps(mapping.rate)
    for start, stop, holds in zip(
        stamps, [*stamps[1:], len(cursor)], gesture.touching, strict=True
    ):
        engaged[start:stop] = float(holds)
    columns = {"engaged": engaged, "cursor": cursor, "torque": np.zeros(len(cursor))}
    return held_levels(surface, columns, samples[:, TACTOR], mapping.rate)[0]


def _carrier(frequency_hz: float, rate: int) -> NDArray[np.float64]:
    """Return a whole number of carrier periods, with the frequency rounded to 1 Hz."""
    hz = max(1, round(frequency_hz))
    samples = rate // gcd(rate, hz)
    turns = np.arange(samples) * hz % rate / rate
    # rounding removes differences between sine implementations
    return np.asarray(np.round(np.sin(2.0 * pi * turns), 9), dtype=np.float64)


def _wave(item: Stimulus, kind: str, rate: int) -> NDArray[np.float64]:
    """Return the click of a single event of a kind, from its onset."""
    alone = Timeline(
        "one", item.timeline.duration_s, (Event(item.timeline.duration_s / 2.0, kind),)
    )
    mapping = render(alone, item.preset, sweep(2.0), rate, item.seed, tail="none", trace=False)
    times = mapping.strikes.time_s[mapping.strikes.event >= 0]
    start = int(times[0] * rate) if len(times) else 0
    wave = mapping.samples[start : start + round(WAVE_S * rate), CLICK].astype(np.float64)
    if not len(times):
        wave = np.zeros(1)
    fade = min(len(wave), round(FADE_S * rate))
    wave[len(wave) - fade :] *= np.arange(fade, 0, -1) / (fade + 1)
    return wave.astype(np.float32).astype(np.float64)
