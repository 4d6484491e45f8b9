"""Files in, one Timeline out: the model, one reader a format, the bundled match."""

from __future__ import annotations

from overview_dsp.timeline.excitement import FOOTBALL_KINDS, crowd_curve
from overview_dsp.timeline.loading import (
    BUNDLED,
    FORMATS,
    Format,
    bundled_timeline,
    list_matches,
    load_timeline,
)
from overview_dsp.timeline.model import Event, Intensity, Timeline
from overview_dsp.timeline.native import save_timeline

__all__ = [
    "BUNDLED",
    "FOOTBALL_KINDS",
    "FORMATS",
    "Event",
    "Format",
    "Intensity",
    "Timeline",
    "bundled_timeline",
    "crowd_curve",
    "list_matches",
    "load_timeline",
    "save_timeline",
]
