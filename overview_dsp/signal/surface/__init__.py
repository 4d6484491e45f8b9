"""Timeline + preset -> friction table and event table."""

from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

__all__ = ["Surface", "build_surface"]
