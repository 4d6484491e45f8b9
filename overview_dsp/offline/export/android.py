"""Android: a waveform of amplitudes (JSON and the platform's XML) and envelope effects.

- `createWaveform(timings, amplitudes, -1)`: 10 ms a step, 1..255 inside the clip (0 would switch
  the motor off and click), equal steps joined, the last one cut at the clip's end.
- Envelope effects (API 36, `WaveformEnvelopeBuilder`): every device takes 16 control points, 20 ms
  to 1 s apart, and starts from amplitude 0. A clip becomes a row of them to be played one after the
  other, each from a moment of little vibration to the next, with its points where they are felt.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip
from overview_dsp.offline.export.control_points import control_points

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
