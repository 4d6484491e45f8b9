"""Audition of a render through the player of a haptic format, against the original."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overview_dsp.cli.common import LineReader, say
from overview_dsp.cli.options.output import sample_player, saved_output
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import TACTOR
from overview_dsp.live.session.blind import AbxTrials
from overview_dsp.offline.export.clip import LEVELS_PER_S
from overview_dsp.offline.export.writing import played_by

if TYPE_CHECKING:
    from overview_dsp.arrays import FloatArray, SampleArray
    from overview_dsp.live.output.settings import OutputSettings
    from overview_dsp.live.output.threshold import SamplePlayback
    from overview_dsp.offline.rendering.offline import RenderResult

PAUSE_S = 0.5
KEYS = "type a, b or x, then Enter, to feel; A or B answers; q ends"


def original_and_played(result: RenderResult[Any], to: str) -> tuple[FloatArray, FloatArray]:
    """Return the vibration of a render, and as the player of a format plays it, (frames,) each."""
    level = played_by(result, to)
    original = result.samples[:, TACTOR].astype(np.float64)
    time_s = np.arange(len(original)) / result.sample_rate
    amplitude = np.interp(time_s, np.arange(len(level)) / LEVELS_PER_S, level, right=0.0)
    hertz = result.engine.preset.number("tactor.frequency_hz")
    return original, amplitude * np.sin(2.0 * np.pi * hertz * time_s)


def in_turn(pair: tuple[FloatArray, FloatArray], sample_rate: float) -> SampleArray:
    """Return the original, a pause, and the other one, on both channels, float32 (frames, 2)."""
    original, played = pair
    both = np.concatenate([original, np.zeros(round(PAUSE_S * sample_rate)), played])
    return np.repeat(both[:, None], 2, axis=1).astype(np.float32)


def compare_blind(
    pair: tuple[FloatArray, FloatArray], rate: float, device: str | None, trials: int, path: Path
) -> AbxTrials:
    """Play the original (A), that of the format's player (B) or X on request; write the answers."""
    settings, name, _, index = saved_output(device)
    lines, answers = LineReader(), AbxTrials(path)
    playback: SamplePlayback | None = None
    say(f"original (A) and player's (B) on {name}: {KEYS}")
    try:
        while answers.trials < trials:
            line = lines.next()
            if line is None:
                continue
            if playback is not None:
                playback.close()
            if line in ("A", "B"):
                say(answers.answer("AB".index(line)))
            elif line in ("a", "b", "x"):
                which = pair[answers.x if line == "x" else "ab".index(line)]
                samples = _on_channels(which, settings)
                playback = sample_player(samples, rate, index)
                playback.start()
                answers.felt_x |= line == "x"
            elif line == "q":
                break
            else:
                say(KEYS)
    finally:
        if playback is not None:
            playback.close()
    return answers


def _on_channels(vibration: FloatArray, settings: OutputSettings) -> SampleArray:
    """Return a vibration on the channels of clicks and tactor, with gain and below the ceiling."""
    samples = np.zeros((len(vibration), settings.channels), dtype=np.float32)
    for signal in settings.signals:
        ceiling = gain_of_db(signal.ceiling_db)
        for channel in signal.channels:
            samples[:, channel - 1] = np.clip(signal.gain * vibration, -ceiling, ceiling)
    return samples
