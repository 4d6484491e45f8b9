"""Bake a gesture to the haptic formats of phones and controllers."""

from overview_dsp.export.formats import FORMATS, NAMES, Exported, export

__all__ = ["FORMATS", "NAMES", "Exported", "export"]
