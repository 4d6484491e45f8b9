"""Files in, one Timeline out: a registry of formats, one reader each, the bundled timelines."""

from __future__ import annotations

from overview_dsp.data.readers.formats import FORMATS
from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.readers.registry import (
    BUNDLED,
    bundled_timeline,
    list_matches,
    load_timeline,
)
from overview_dsp.data.readers.source import Format

__all__ = [
    "BUNDLED",
    "FORMATS",
    "Format",
    "bundled_timeline",
    "list_matches",
    "load_timeline",
    "save_timeline",
]
