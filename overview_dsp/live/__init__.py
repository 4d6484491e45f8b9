"""Live playback of an engine through an audio output; the only package that opens devices.

`ov.live` is for programs that play: output streams whose callback never waits for Python, their
settings and their meters. Importing it needs no PortAudio and no sound card; opening an output
does. Each name is imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> engine = ov.Engine(preset, match)
>>> engine.prepare(sample_rate=8000, max_block_size=256)
>>> with ov.live.NullStream(engine) as stream:  # OutputStream(engine) plays sound
...     engine.control(theta2=1.2, touching=True)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp.live.output.devices import OutputDevice, devices, find_device
    from overview_dsp.live.output.null_stream import NullStream
    from overview_dsp.live.output.portaudio_stream import OutputStream
    from overview_dsp.live.output.settings import OutputSettings, SignalSettings
    from overview_dsp.live.output.stream import StreamMeters

__all__ = [
    "NullStream",
    "OutputDevice",
    "OutputSettings",
    "OutputStream",
    "SignalSettings",
    "StreamMeters",
    "devices",
    "find_device",
]

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "OutputDevice": "output.devices",
            "OutputSettings": "output.settings",
            "OutputStream": "output.portaudio_stream",
            "SignalSettings": "output.settings",
            "NullStream": "output.null_stream",
            "StreamMeters": "output.stream",
            "devices": "output.devices",
            "find_device": "output.devices",
        },
    )
