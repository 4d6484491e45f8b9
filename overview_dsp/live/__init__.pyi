"""Public names of `ov.live`, each imported when it is first used."""

from overview_dsp.live.output.devices import (
    OutputDevice as OutputDevice,
    devices as devices,
    find_device as find_device,
)
from overview_dsp.live.output.stream import NullStream as NullStream
from overview_dsp.live.output.portaudio_stream import OutputStream as OutputStream
from overview_dsp.live.output.settings import (
    OutputSettings as OutputSettings,
    SignalSettings as SignalSettings,
)
from overview_dsp.live.output.stream import StreamMeters as StreamMeters
