"""Live: the only place that opens devices."""

from overview_dsp.live.portaudio import OutputStream
from overview_dsp.live.silent import SilentStream

__all__ = ["OutputStream", "SilentStream"]
