"""Surface: friction table and event table of a timeline and a preset."""

from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

__all__ = ["Surface", "build_surface"]
