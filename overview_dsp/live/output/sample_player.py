"""Players of precomputed samples such as test tones, which report the time played so far."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.live.output.devices import open_error
from overview_dsp.live.output.portaudio_library import import_sounddevice
from overview_dsp.live.output.stream import FADE_WITHIN_S

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
                samplerate=sample_rate,
                device=device,
                channels=channels,
                dtype="float32",
                latency="low",
                callback=self._callback,
            )
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
