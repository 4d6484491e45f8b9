"""The control condition: no disk; the place under the hand says how strong the vibration is.

An event is a smooth bump of amplitude, as strong as the event is felt in the friction condition
while the hand holds on (a sweep of 2 s where the hand is free); between events the amplitude
follows the intensity curve, as strong as the event-free rest is. A click is that of the event's
kind alone. So both conditions have the same levels in the same places, and only one of them has a
disk: no speed, no weight, no recoil.

The page renders it live from the same numbers (docs/explanation/study-format.md), with the same
bits: sums, products and divisions of float64 in the order given there.
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
from overview_studies.items import Item

COLUMNS = 1025
RAMP_S = 0.005
"""From one control event's place to the next, and from silence when the finger lands."""

BUMP = 0.04
"""An event's bump is at least so wide, as a part of the timeline: a fast hand feels all of it."""

WAVE_S, FADE_S = 0.08, 0.005
CEILING = 10.0 ** (-1.0 / 20.0)
LEAST_DB = -80.0
MATCHES = 2
"""How often a bump is measured and set again."""


@dataclass(frozen=True, eq=False)
class StaticMapping:
    """The control condition of one stimulus at one sample rate.

    Attributes
    ----------
    amplitude : float64 (COLUMNS,)
        Of the carrier, at even places from 0 to 1.
    carrier : float64 (n,)
        Whole periods of it.
    clicks : list of (place, wave)
    waves : list of float64 (samples,)
    """

    rate: int
    ramp: int
    amplitude: NDArray[np.float64]
    carrier: NDArray[np.float64]
    clicks: list[tuple[float, int]]
    waves: list[NDArray[np.float64]]

    def as_json(self) -> dict[str, Any]:
        """What the page gets."""
        return {
            "rate": self.rate,
            "ramp": self.ramp,
            "amplitude": self.amplitude.tolist(),
            "carrier": self.carrier.tolist(),
            "clicks": [{"place": place, "wave": wave} for place, wave in self.clicks],
            "waves": [wave.tolist() for wave in self.waves],
            "ceiling": CEILING,
        }

    def render(self, gesture: Gesture, tail_s: float = WAVE_S) -> NDArray[np.float32]:
        """Render a gesture: float32 (frames, 2), click and tactor."""
        samples, _ = self._rendered(gesture, tail_s)
        return samples

    def _rendered(
        self, gesture: Gesture, tail_s: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The samples, and the cursor after each."""
        frames = round(gesture.duration_s * self.rate) + round(tail_s * self.rate)
        cursor, gate, before, held = self._hand(gesture, frames)
        x = cursor * (COLUMNS - 1)
        i = np.minimum(np.floor(x).astype(np.int64), COLUMNS - 2)
        a = self.amplitude[i] + (self.amplitude[i + 1] - self.amplitude[i]) * (x - i)
        tactor = gate * a * self.carrier[np.arange(frames) % len(self.carrier)]
        click = np.zeros(frames)
        for at, wave in self._struck(before, cursor, held):
            part = self.waves[wave][: frames - at]
            click[at : at + len(part)] += part
        samples = np.empty((frames, 2), np.float32)
        samples[:, CLICK] = np.clip(click, -CEILING, CEILING)
        samples[:, TACTOR] = tactor
        return samples, cursor

    def _hand(
        self, gesture: Gesture, frames: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Cursor, gate, the cursor before each sample, and whether the hand holds on."""
        cursor, gate = np.zeros(frames), np.zeros(frames)
        before, held = np.zeros(frames), np.zeros(frames, dtype=bool)
        c = g = to = gto = 0.0
        stamps = gesture.stamps(self.rate)
        order = np.flatnonzero(stamps < frames)
        # events of one sample apply in order; the last of them begins the ramp
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

    def _struck(
        self, before: NDArray[np.float64], after: NDArray[np.float64], held: NDArray[np.bool_]
    ) -> list[tuple[int, int]]:
        """The sample and wave of each click, in the order they start."""
        found = []
        for number, (place, wave) in enumerate(self.clicks):
            up = (before < place) & (place <= after)
            down = (after <= place) & (place < before)
            found += [(int(at), number, wave) for at in np.flatnonzero(held & (up | down))]
        return [(at, wave) for at, _, wave in sorted(found)]


def static_mapping(item: Item, rate: int) -> StaticMapping:
    """The control condition of a stimulus, as strong as the stimulus itself."""
    hand = sweep(2.0) if item.free else item.gesture
    felt = render(item.timeline, item.preset, hand, rate, item.seed)
    surface, trace = felt.engine.surface, felt.trace
    wanted, free_db = held_levels(surface, trace, felt.samples[:, TACTOR], rate)
    wanted = np.where(np.isfinite(wanted), np.maximum(wanted, LEAST_DB), LEAST_DB)
    level = item.curve(COLUMNS)
    rest = level / max(float(np.mean(level)), 1e-9) * _peak(free_db) if level.any() else level
    kinds = [item.timeline.events[e].kind for e in surface.event]
    names = sorted(set(kinds))
    made = StaticMapping(
        rate,
        round(RAMP_S * rate),
        np.zeros(COLUMNS),
        _carrier(item.preset.number("tactor.frequency_hz"), rate),
        [(float(p), names.index(k)) for p, k in zip(surface.position, kinds, strict=True)],
        [_wave(item, kind, rate) for kind in names],
    )
    height = _peak(wanted)
    for _ in range(MATCHES):
        made = StaticMapping(
            rate, made.ramp, _amplitude(surface.position, surface.span, height, rest),
            made.carrier, made.clicks, made.waves,
        )  # fmt: skip
        got = _levels(made, hand, surface)
        height = height * np.where(np.isfinite(got), _peak(wanted) / _peak(got), 1.0)
    return StaticMapping(
        rate, made.ramp, _amplitude(surface.position, surface.span, height, rest),
        made.carrier, made.clicks, made.waves,
    )  # fmt: skip


def held_levels(
    surface: Surface,
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    rate: float,
) -> tuple[NDArray[np.float64], float]:
    """How strong each event is felt while the hand holds on, and the rest between them, dB."""
    found, free = np.full(len(surface.position), np.nan), LEAST_DB
    for stroke in measure.strokes(columns["engaged"], columns["cursor"]):
        if stroke.name == "out":
            felt = stroke_feel(stroke, surface, columns, tactor, rate)
            found = np.fmax(found, felt.event_db)
            free = float(np.fmax(free, felt.event_free_db))
    return found, free


def static_levels(item: Item, rate: int) -> NDArray[np.float64]:
    """How strong each event is felt in the control condition, dB of full scale."""
    surface = build_surface(item.timeline, item.preset)
    hand = sweep(2.0) if item.free else item.gesture
    return _levels(static_mapping(item, rate), hand, surface)


def _peak(level_db: Any) -> Any:
    """The amplitude of a sine of a level (RMS, dB of full scale)."""
    return np.sqrt(2.0) * 10.0 ** (np.asarray(level_db) / 20.0)


def _amplitude(
    position: NDArray[np.float64],
    span: NDArray[np.float64],
    height: NDArray[np.float64],
    rest: NDArray[np.float64],
) -> NDArray[np.float64]:
    x = np.arange(COLUMNS) / (COLUMNS - 1)
    found = rest.astype(np.float64).copy()
    for place, (low, high), top in zip(position, span, height, strict=True):
        width = max(high - low, BUMP)
        part = np.clip(1.0 - np.square(2.0 * (x - place) / width), 0.0, 1.0)
        found = np.maximum(found, top * part)
    return np.minimum(found, CEILING)


def _levels(made: StaticMapping, hand: Gesture, surface: Surface) -> NDArray[np.float64]:
    """How strong each event is felt in the control condition."""
    samples, cursor = made._rendered(hand, WAVE_S)
    engaged = np.zeros(len(cursor))
    stamps = hand.stamps(made.rate)
    for start, stop, holds in zip(stamps, [*stamps[1:], len(cursor)], hand.touching, strict=True):
        engaged[start:stop] = float(holds)
    columns = {"engaged": engaged, "cursor": cursor, "torque": np.zeros(len(cursor))}
    return held_levels(surface, columns, samples[:, TACTOR], made.rate)[0]


def _carrier(frequency_hz: float, rate: int) -> NDArray[np.float64]:
    """Whole periods of the carrier, its frequency to the nearest Hz."""
    hz = max(1, round(frequency_hz))
    samples = rate // gcd(rate, hz)
    turns = np.arange(samples) * hz % rate / rate
    # rounded, so that machines whose sines differ in the last bit have the same numbers
    return np.asarray(np.round(np.sin(2.0 * pi * turns), 9), dtype=np.float64)


def _wave(item: Item, kind: str, rate: int) -> NDArray[np.float64]:
    """What one event of a kind sounds like alone, from its strike on."""
    alone = Timeline(
        "one", item.timeline.duration_s, (Event(item.timeline.duration_s / 2.0, kind),)
    )
    made = render(alone, item.preset, sweep(2.0), rate, item.seed, tail="none", trace=False)
    times = made.strikes.time_s[made.strikes.event >= 0]
    start = int(times[0] * rate) if len(times) else 0
    wave = made.samples[start : start + round(WAVE_S * rate), CLICK].astype(np.float64)
    if not len(times):
        wave = np.zeros(1)
    fade = min(len(wave), round(FADE_S * rate))
    wave[len(wave) - fade :] *= np.arange(fade, 0, -1) / (fade + 1)
    return wave.astype(np.float32).astype(np.float64)
