"""Android: a waveform of amplitudes (JSON and the platform's XML) and envelope effects.

- `createWaveform(timings, amplitudes, -1)`: 10 ms a step, 1..255 inside the clip (0 would switch
  the motor off and click), equal steps joined, the last one cut at the clip's end.
- Envelope effects (API 36, `WaveformEnvelopeBuilder`): every device takes 16 control points, 20 ms
  to 1 s apart, and starts from amplitude 0. A clip becomes a row of them to be played one after the
  other, each from a moment of little vibration to the next, with its points where they are felt.

Few control points for an envelope effect, where they are felt most: by dynamic programming.

Of all ways to lay a limited number of straight pieces over a part of a clip, the one with the
fewest windows of 10 ms that are more than a step off; strikes count more than what is between them.

What is wrong with an Android document: JSON, and the platform's XML.

Android's vibrator: a waveform's steps, and envelope effects' straight lines.

A waveform holds each amplitude (of 255) for its time. An envelope effect starts from nothing and
ramps to each control point in turn; an application plays the effects one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.breakpoints import (
    felt_db,
    many,
    number,
    one_of,
    record,
    text,
    whole,
)
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip
from overview_dsp.offline.export.felt_error import NOTICEABLE_DB

GRID_MS = 10
"""Points lie on this grid: a window of the felt level."""

STRIKE_WEIGHT = 4.0
"""A window in which something strikes counts as so many."""

_LARGEST_DB = 10.0
_PER_DB = 0.02
"""Besides windows that are off, so much is an error of 1 dB: of two ways, the nearer one."""


def control_points(
    level: NDArray[np.float64],
    struck: Sequence[int],
    most: int,
    apart_ms: tuple[int, int],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Points to join by straight lines, from silence to silence.

    Parameters
    ----------
    level : float64 (n,)
        Amplitude at each millisecond, the shortest distance or longer.
    struck
        Places of strikes, ms.
    most
        How many points after the first, 2 or more.
    apart_ms
        The shortest and the longest distance between neighbours, ms.

    Returns
    -------
    places : int64 (m,)
        The first and the last place are the part's ends.
    amplitudes : float64 (m,)
    """
    count = (len(level) - 1) // GRID_MS
    places = np.arange(count + 1) * GRID_MS
    node = level[places].copy()
    places[-1] = len(level) - 1
    node[0] = node[-1] = 0.0
    windows = level[: count * GRID_MS].reshape(count, GRID_MS)
    target = felt_db(np.sqrt(np.mean(windows**2, axis=1)))
    weight = np.ones(count)
    for place in struck:
        weight[place // GRID_MS : place // GRID_MS + 2] = STRIKE_WEIGHT
    cost = _costs(places, node, target, weight, apart_ms)
    best = np.full(count + 1, np.inf)
    best[0] = 0.0
    totals, origins = [best], [np.zeros(count + 1, np.int64)]
    for _ in range(most):
        total = totals[-1][:, None] + cost
        origins.append(np.argmin(total, axis=0))
        totals.append(total.min(axis=0))
    pieces = int(np.argmin([total[-1] for total in totals]))
    chosen = [count]
    for origin in origins[pieces:0:-1]:
        chosen.append(int(origin[chosen[-1]]))
    order = np.array(chosen[::-1])
    return places[order], node[order]


def _costs(
    places: NDArray[np.int64],
    node: NDArray[np.float64],
    target: NDArray[np.float64],
    weight: NDArray[np.float64],
    apart_ms: tuple[int, int],
) -> NDArray[np.float64]:
    """What a straight piece from one node to another costs, (nodes, nodes); infinite if barred."""
    count = len(target)
    cost = np.full((count + 1, count + 1), np.inf)
    middle = np.arange(count) + 0.5
    for first in range(count):
        for end in range(
            int(np.searchsorted(places, places[first] + apart_ms[0])),
            int(np.searchsorted(places, places[first] + apart_ms[1], side="right")),
        ):
            part = (middle[first:end] - first) / (end - first)
            line = node[first] + (node[end] - node[first]) * part
            error = np.abs(felt_db(line) - target[first:end])
            off = (error > NOTICEABLE_DB) + _PER_DB * np.minimum(error, _LARGEST_DB)
            cost[first, end] = float(weight[first:end] @ off)
    return cost


STEP_MS = 10
MAX_POINTS = 16
POINT_MS = (20, 1000)
PART_MS = 1000
"""Length of an envelope effect, about: 16 points spread over it are 60 ms apart."""


def waveform(clip: Clip) -> tuple[list[int], list[int]]:
    """Return timings (ms) and amplitudes (1..255)."""
    level = clip.level[:-1]  # the last is the silence after it
    padded = np.pad(level, (0, -len(level) % STEP_MS), mode="edge").reshape(-1, STEP_MS)
    steps = np.clip(np.rint(255.0 * np.sqrt(np.mean(padded**2, axis=1))), 1, 255).astype(int)
    starts = np.flatnonzero(np.diff(steps, prepend=-1))
    bounds = np.append(starts * STEP_MS, len(level))
    return np.diff(bounds).tolist(), steps[starts].tolist()


def envelopes(clip: Clip) -> list[dict[str, Any]]:
    """Return the envelope effects, in order, each within every device's limits."""
    effects = []
    hz = round(clip.frequency_hz, 3)
    struck = [round(strike.time_s * LEVELS_PER_S) for strike in clip.transients]
    for first, end in _parts(clip.level):
        level = np.pad(clip.felt[first : end + 1], (0, max(0, POINT_MS[0] - (end - first))))
        places, amplitudes = control_points(
            level, [at - first for at in struck if first <= at < end], MAX_POINTS, POINT_MS
        )
        points = [
            {"amplitude": round(float(amplitude), 4), "frequencyHz": hz, "durationMs": int(length)}
            for amplitude, length in zip(amplitudes[1:], np.diff(places), strict=True)
        ]
        effects.append({"startMs": first, "initialFrequencyHz": hz, "controlPoints": points})
    return effects


def document(clip: Clip) -> dict[str, Any]:
    """Return both as what an application reads with a JSON parser."""
    timings, amplitudes = waveform(clip)
    return {
        "description": f"overView DSP: {clip.title}",
        "waveform": {"timings": timings, "amplitudes": amplitudes, "repeat": -1},
        "envelopeEffects": envelopes(clip),
    }


def waveform_xml(clip: Clip) -> bytes:
    """Return the waveform in the platform's XML (`VibrationXmlParser`)."""
    root = ElementTree.Element("vibration-effect")
    effect = ElementTree.SubElement(root, "waveform-effect")
    for duration, amplitude in zip(*waveform(clip), strict=True):
        ElementTree.SubElement(
            effect, "waveform-entry", durationMs=str(duration), amplitude=str(amplitude)
        )
    return _bytes(root)


def _bytes(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _parts(level: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Cut a clip about every `PART_MS`, where it vibrates least."""
    last = len(level) - 1
    cuts = [0]
    while last - cuts[-1] > 1.5 * PART_MS:
        low, high = cuts[-1] + PART_MS // 2, cuts[-1] + 3 * PART_MS // 2
        cuts.append(low + int(np.argmin(level[low:high])))
    if last - cuts[-1] < POINT_MS[0] and len(cuts) > 1:
        cuts.pop()
    return list(zip(cuts, [*cuts[1:], last], strict=True))


_HZ = number(0.0, above=0.0)
_POINT = record({"amplitude": number(0.0, 1.0), "frequencyHz": _HZ, "durationMs": whole(*POINT_MS)})
_EFFECT = record(
    {
        "startMs": whole(0),
        "initialFrequencyHz": _HZ,
        "controlPoints": many(_POINT, 1, MAX_POINTS),
    }
)
_DOCUMENT = record(
    {
        "description": text(),
        "waveform": record(
            {
                "timings": many(whole(1), 1),
                # 0 would switch the motor off inside the clip
                "amplitudes": many(whole(1, 255), 1),
                "repeat": one_of(-1),
            }
        ),
        "envelopeEffects": many(_EFFECT),
    }
)


def faults_of(document: Any) -> list[str]:
    """Every fault of a document of an Android export, a line each."""
    faults: list[str] = []
    _DOCUMENT(document, "", faults)
    if faults:
        return faults
    wave = document["waveform"]
    if len(wave["timings"]) != len(wave["amplitudes"]):
        faults.append(
            f"waveform: {len(wave['timings'])} timings and {len(wave['amplitudes'])} amplitudes"
        )
    end = 0
    for k, effect in enumerate(document["envelopeEffects"]):
        if effect["startMs"] < end:
            faults.append(f"envelopeEffects[{k}].startMs is before the last effect's end ({end})")
        points = effect["controlPoints"]
        end = effect["startMs"] + sum(point["durationMs"] for point in points)
        if points[-1]["amplitude"] != 0.0:
            faults.append(f"envelopeEffects[{k}] doesn't end in silence: the next one would click")
    return faults


def xml_faults_of(root: ElementTree.Element) -> list[str]:
    """Every fault of the XML of a waveform, a line each."""
    if root.tag != "vibration-effect" or [child.tag for child in root] != ["waveform-effect"]:
        return ["it isn't a vibration-effect with a waveform-effect"]
    entries = list(root[0])
    faults = [] if entries else ["waveform-effect is empty"]
    for k, entry in enumerate(entries):
        place = f"waveform-effect[{k}]"
        if entry.tag != "waveform-entry" or set(entry.keys()) != {"durationMs", "amplitude"}:
            faults.append(f"{place} isn't a waveform-entry with durationMs and amplitude")
            continue
        for key, low, high in (("durationMs", 1, float("inf")), ("amplitude", 1, 255)):
            value = entry.get(key, "")
            if not (value.isascii() and value.isdigit() and low <= int(value[:12]) <= high):
                faults.append(f"{place}.{key} = {value[:20]!r}; it is {low} to {high:g}")
    return faults


def waveform_played(android: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude that a document's waveform gives."""
    wave = android["waveform"]
    level = np.repeat(np.array(wave["amplitudes"]) / 255.0, wave["timings"])
    return np.append(level, 0.0)


def envelopes_played(android: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude that a document's envelope effects give, each begun at its `startMs`."""
    times, values = [0.0], [0.0]
    for effect in android["envelopeEffects"]:
        at = float(effect["startMs"])
        times.append(at)
        values.append(0.0)
        for point in effect["controlPoints"]:
            at += point["durationMs"]
            times.append(at)
            values.append(point["amplitude"])
    return np.interp(np.arange(round(times[-1]) + 1), times, values)
