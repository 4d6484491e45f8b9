"""The data model: events, an intensity curve, gaps; windows, and the events that zooming adds."""

from overview_dsp.data.timeline.model import Event, Intensity, Timeline

__all__ = ["Event", "Intensity", "Timeline"]
