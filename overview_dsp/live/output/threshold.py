"""Detection threshold of vibration, measured by a rising tone (method of limits).

The participant presses a key as soon as the tone is felt. The tone passes the actuator's drive like
any tactor signal. A silence of random length precedes it, so that its start can't be predicted. A
key press during the silence makes the trial invalid.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.layout import TACTOR
from overview_dsp.live.output.devices import open_error
from overview_dsp.live.output.portaudio_library import import_sounddevice
from overview_dsp.live.output.settings import SignalSettings
from overview_dsp.live.output.stream import FADE_WITHIN_S
from overview_dsp.signal.actuators.calibration import HIGHEST_DB, LOWEST_DB
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.actuators.stage import ActuatorStage
from overview_dsp.signal.actuators.sweep import EDGE_S, edges

FADE_S = 0.02


class SamplePlayer:
    """Player of float32 samples (frames, channels) on an output device.

    Thread: main.
    """

    def __init__(
        self, samples: NDArray[np.float32], sample_rate: float, device: int | str | None = None
    ) -> None:
        """Open a device (None: the default); InputError if it can't play these samples."""
        self._sounddevice = import_sounddevice()
        self._samples = samples
        self._rate = sample_rate
        self._at = 0
        self._called = 0.0
        self._stopping = False
        fade = round(FADE_S * sample_rate)
        self._fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fade + 1) / fade)
        channels = samples.shape[1]
        try:
            self._stream: Any = self._sounddevice.OutputStream(
                samplerate=sample_rate, device=device, channels=channels, dtype="float32",
                latency="low", callback=self._callback,
            )  # fmt: skip
        except (self._sounddevice.PortAudioError, ValueError) as error:
            raise open_error(self._sounddevice, device, channels, sample_rate, error) from None

    def _callback(self, out: NDArray[np.float32], frames: int, when: Any, status: Any) -> None:
        part = self._samples[self._at : self._at + frames]
        out[: len(part)] = part
        out[len(part) :] = 0.0
        if self._stopping:
            gain, self._fade = self._fade[:frames], self._fade[frames:]
            out[: len(gain)] *= gain[:, None].astype(np.float32)
            out[len(gain) :] = 0.0
        self._at += frames
        self._called = time.monotonic()
        if not len(part) or not len(self._fade):
            raise self._sounddevice.CallbackStop

    def start(self) -> None:
        """Start to play."""
        self._stream.start()

    def close(self) -> None:
        """Fade out and close the device; repeated calls do nothing."""
        if self._stream is None:
            return
        self._stopping = True
        until = time.monotonic() + FADE_WITHIN_S
        while self._stream.active and time.monotonic() < until:
            time.sleep(0.002)
        self._stream.close()
        self._stream = None

    @property
    def played_s(self) -> float:
        """Time of the samples that has been audible, s: delivered minus the output's latency."""
        if self._stream is None or not self._called:
            return 0.0
        since = time.monotonic() - self._called
        return max(0.0, self._at / self._rate + since - float(self._stream.latency))

    @property
    def over(self) -> bool:
        """State of playback: True after all samples were audible."""
        return self.played_s * self._rate >= len(self._samples)


class NullSamplePlayer:
    """Stand-in for a `SamplePlayer` that takes the same time without sound.

    Thread: main.
    """

    def __init__(self, samples: NDArray[np.float32], sample_rate: float) -> None:
        """Prepare for `start`."""
        self._seconds = len(samples) / sample_rate
        self._started = 0.0

    def start(self) -> None:
        """Start the clock."""
        self._started = time.monotonic()

    def close(self) -> None:
        """Do nothing."""

    @property
    def played_s(self) -> float:
        """Time since the start, s."""
        return time.monotonic() - self._started

    @property
    def over(self) -> bool:
        """State of playback: True after the duration of the samples."""
        return self.played_s >= self._seconds


SamplePlayback = SamplePlayer | NullSamplePlayer
"""Either kind of player."""


SLOWEST, FASTEST = 0.5, 60.0
"""Limits of the ramp, dB per second."""

SILENCE_S = (1.0, 3.0)
"""Shortest and longest silence before a tone."""


@dataclass(frozen=True)
class RisingTone:
    """Tone of one frequency (Hz) whose level rises over the whole range after `silence_s`."""

    frequency_hz: float
    db_per_s: float
    silence_s: float

    def __post_init__(self) -> None:
        # written so that NaN fails
        if not SLOWEST <= self.db_per_s <= FASTEST:
            raise InputError(
                f"ramp of {self.db_per_s:g} dB/s must be {SLOWEST:g} to {FASTEST:g} dB/s"
            )

    def level_at(self, time_s: float) -> float:
        """Return the level at a time, dB of the nominal drive; minus infinity in the silence."""
        since = time_s - self.silence_s
        return LOWEST_DB + self.db_per_s * since if since >= 0.0 else -math.inf

    def drive(
        self, actuator: Actuator, out: SignalSettings, channels: int, sample_rate: float
    ) -> NDArray[np.float32]:
        """Return the actuator's drive for an output, float32 (frames, channels).

        It is on the output's channels and below its ceiling.

        InputError: the sample rate (Hz) is too low for the frequency or the actuator's resonance.
        """
        if not 1.0 <= self.frequency_hz <= 0.45 * sample_rate:
            raise InputError(
                f"tone frequency {self.frequency_hz:g} Hz must be 1 to {0.45 * sample_rate:g} Hz"
            )
        rise_s = (HIGHEST_DB - LOWEST_DB) / self.db_per_s
        frames = round(rise_s * sample_rate)
        time_s = np.arange(frames) / sample_rate
        gain = np.exp((LOWEST_DB + self.db_per_s * time_s) * (math.log(10.0) / 20.0))
        tone = gain * np.sin(2.0 * math.pi * self.frequency_hz * time_s)
        samples = np.zeros((round(self.silence_s * sample_rate) + frames, 2), dtype=np.float32)
        samples[-frames:, TACTOR] = tone * edges(frames, round(EDGE_S * sample_rate))
        ActuatorStage(actuator, sample_rate).process(samples, TACTOR)
        ceiling = np.float32(gain_of_db(out.ceiling_db))
        drive = np.zeros((len(samples), channels), dtype=np.float32)
        for channel in out.channels:
            drive[:, channel - 1] = np.clip(samples[:, TACTOR], -ceiling, ceiling)
        return drive


def find_threshold(
    rise: RisingTone, playback: SamplePlayback, pressed: Callable[[], bool]
) -> float:
    """Play a tone until `pressed`; return its level at that time, dB of the nominal drive.

    The level is minus infinity for a press during the silence, and infinity without a press.
    `pressed` waits for a short time.
    """
    try:
        playback.start()
        while not playback.over:
            if pressed():
                return rise.level_at(playback.played_s)
        return math.inf
    finally:
        playback.close()
