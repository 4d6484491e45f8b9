"""Gestures: control events from scripts and takes, without devices."""

from overview_dsp.design.gestures.model import SOURCES, Gesture
from overview_dsp.design.gestures.scripts import arm, flick, pause, scrub, sweep, tap
from overview_dsp.design.gestures.spec import parse_gesture
from overview_dsp.design.gestures.take import load_gesture

__all__ = [
    "SOURCES",
    "Gesture",
    "arm",
    "flick",
    "load_gesture",
    "parse_gesture",
    "pause",
    "scrub",
    "sweep",
    "tap",
]
