"""The terminal application of `overview play`."""

from overview_dsp.live.screen.app import PlayApp, run

__all__ = ["PlayApp", "run"]
