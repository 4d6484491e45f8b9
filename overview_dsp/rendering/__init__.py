"""Offline rendering: one gesture, many side by side, what they leave behind."""

from overview_dsp.rendering.many import Voice, VoiceResult, render_many, voices
from overview_dsp.rendering.offline import Rendered, Result, render, render_to_file
from overview_dsp.rendering.trace import Trace

__all__ = [
    "Rendered",
    "Result",
    "Trace",
    "Voice",
    "VoiceResult",
    "render",
    "render_many",
    "render_to_file",
    "voices",
]
