"""Live: an engine through an audio output, in time. The only package that opens devices.

`ov.live` is for programs that play: an output stream whose callback never waits for Python, what it
is given and what it reports. Importing it needs no PortAudio and no sound card; opening an output
does. Each name is imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> engine = ov.Engine(preset, match)
>>> engine.prepare(sample_rate=8000, max_block_size=256)
>>> with ov.live.SilentStream(engine) as stream:  # OutputStream(engine) is heard
...     engine.control(theta2=1.2, touching=True)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp.live.output.devices import OutputDevice, devices, find_device
    from overview_dsp.live.output.portaudio_stream import OutputStream
    from overview_dsp.live.output.settings import OutputSettings, SignalSettings
    from overview_dsp.live.output.silent_stream import SilentStream
    from overview_dsp.live.output.stream import StreamMeters

__all__ = [
    "OutputDevice",
    "OutputSettings",
    "OutputStream",
    "SignalSettings",
    "SilentStream",
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
            "SilentStream": "output.silent_stream",
            "StreamMeters": "output.stream",
            "devices": "output.devices",
            "find_device": "output.devices",
        },
    )
