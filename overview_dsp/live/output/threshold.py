"""Where a person begins to feel: a tone that rises, and a key when it is felt (method of limits).

The tone goes through the actuator's drive as presets do. Before each there is a silence of any
length, so that nobody presses by the clock; who presses within it is asked again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import TACTOR
from overview_dsp.live.output.sample_player import SamplePlayback
from overview_dsp.live.output.settings import SignalSettings
from overview_dsp.signal.actuators.calibration import HIGHEST_DB, LOWEST_DB
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import ActuatorStage
from overview_dsp.signal.actuators.sweep import EDGE_S, edges

SLOWEST, FASTEST = 0.5, 60.0
"""Rise of the tone, dB a second."""

SILENCE_S = (1.0, 3.0)
"""Before a tone; of any length between these."""


@dataclass(frozen=True)
class Rise:
    """A tone of one frequency (Hz) from the lowest level to the highest, after `silence_s`."""

    frequency_hz: float
    db_per_s: float
    silence_s: float

    def __post_init__(self) -> None:
        # written so that NaN fails
        if not SLOWEST <= self.db_per_s <= FASTEST:
            raise InputError(f"a rise of {self.db_per_s:g} dB/s; it is {SLOWEST:g} to {FASTEST:g}")

    def level_at(self, time_s: float) -> float:
        """Level at a time, dB of the nominal drive; minus infinity in the silence."""
        since = time_s - self.silence_s
        return LOWEST_DB + self.db_per_s * since if since >= 0.0 else -math.inf

    def drive(
        self, actuator: Actuator, out: SignalSettings, channels: int, sample_rate: float
    ) -> NDArray[np.float32]:
        """The drive, float32 (frames, channels), on the output's channels and below its ceiling.

        Raises
        ------
        InputError
            A frequency or an actuator's resonance that the sample rate (Hz) is too low for.
        """
        if not 1.0 <= self.frequency_hz <= 0.45 * sample_rate:
            raise InputError(
                f"a tone of {self.frequency_hz:g} Hz; it is 1 to {0.45 * sample_rate:g} Hz"
            )
        rise_s = (HIGHEST_DB - LOWEST_DB) / self.db_per_s
        frames = round(rise_s * sample_rate)
        time = np.arange(frames) / sample_rate
        gain = np.exp((LOWEST_DB + self.db_per_s * time) * (math.log(10.0) / 20.0))
        tone = gain * np.sin(2.0 * math.pi * self.frequency_hz * time)
        samples = np.zeros((round(self.silence_s * sample_rate) + frames, 2), dtype=np.float32)
        samples[-frames:, TACTOR] = tone * edges(frames, round(EDGE_S * sample_rate))
        ActuatorStage(actuator, sample_rate).process(samples, TACTOR)
        ceiling = np.float32(gain_of_db(out.ceiling_db))
        placed = np.zeros((len(samples), channels), dtype=np.float32)
        for channel in out.channels:
            placed[:, channel - 1] = np.clip(samples[:, TACTOR], -ceiling, ceiling)
        return placed


def felt_at(rise: Rise, playback: SamplePlayback, pressed: Callable[[], bool]) -> float:
    """Play a tone until `pressed`; the level at which it was felt, dB of the nominal drive.

    Minus infinity: pressed before there was a tone. Infinity: never. `pressed` waits a little.
    """
    try:
        playback.start()
        while not playback.over:
            if pressed():
                return rise.level_at(playback.heard_s)
        return math.inf
    finally:
        playback.close()
