"""The data model: events, an intensity curve, gaps; windows and what shows up as one zooms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public.moved import moved_name
from overview_dsp.timeline.model import Event, Intensity, Timeline

__all__ = ["Event", "Intensity", "Timeline"]

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        return moved_name(__name__, name)
