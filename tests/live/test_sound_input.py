"""A sound input whose reader is late: what was lost is a gap at its own place."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from overview_dsp.live.inputs import feeds
from overview_dsp.live.output import devices, portaudio_library


class Input:
    """A sound input that records when a test calls `put`."""

    def __init__(self, rate, device, channels, dtype, callback):
        self.callback, self.active = callback, True

    def put(self, value, frames=4):
        self.callback(np.full((frames, 1), value, np.float32), frames, None, None)

    def start(self):
        pass

    def close(self):
        self.active = False


@pytest.fixture
def opened(monkeypatch):
    inputs = []

    def open_input(*given, **named):
        inputs.append(Input(*given, **named))
        return inputs[-1]

    info = {
        "index": 0, "name": "Microphone", "hostapi": 0, "max_input_channels": 1,
        "default_samplerate": 8000.0, "default_low_input_latency": 0.01,
    }  # fmt: skip
    library = SimpleNamespace(
        query_devices=lambda *given: info if given else [info],
        query_hostapis=lambda: [{"name": "ALSA"}],
        default=SimpleNamespace(device=(0, -1)),
        InputStream=open_input,
        PortAudioError=OSError,
    )
    for module in (devices, portaudio_library):
        monkeypatch.setattr(module, "import_sounddevice", lambda: library)
    monkeypatch.setattr(feeds, "QUEUE_BLOCKS", 3)
    return inputs


def test_lost_blocks_are_a_gap_before_what_was_recorded_after_them(opened):
    rate, channels, blocks = feeds.SoundInput("audio:").open_blocks()
    assert (rate, channels) == (8000, 1)
    assert next(blocks) is None  # opened; nothing yet
    for value in range(5):  # the last two find no room
        opened[0].put(value)
    heard = [next(blocks)]
    opened[0].put(5.0)
    heard += [next(blocks) for _ in range(4)]
    blocks.close()
    assert not opened[0].active
    values = np.concatenate(heard)[:, 0]
    expected = np.repeat([0.0, 1.0, 2.0, np.nan, np.nan, 5.0], 4)
    np.testing.assert_array_equal(values, expected)
