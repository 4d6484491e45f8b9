"""Readers of all supported file formats, and the bundled timelines."""

from overview_dsp.data.readers.data_file import Format
from overview_dsp.data.readers.formats import FORMATS
from overview_dsp.data.readers.native import save_timeline
from overview_dsp.data.readers.registry import (
    BUNDLED,
    bundled_timeline,
    list_matches,
    load_timeline,
)

__all__ = [
    "BUNDLED",
    "FORMATS",
    "Format",
    "bundled_timeline",
    "list_matches",
    "load_timeline",
    "save_timeline",
]
