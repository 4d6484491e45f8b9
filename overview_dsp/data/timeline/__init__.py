"""The data model: events, an intensity curve, gaps; windows and what shows up as one zooms."""

from overview_dsp.data.timeline.model import Event, Intensity, Timeline

__all__ = ["Event", "Intensity", "Timeline"]
