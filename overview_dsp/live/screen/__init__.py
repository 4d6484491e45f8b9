"""The terminal application of `overview play`."""

from __future__ import annotations

from overview_dsp.live.screen.app import PlayApp, run

__all__ = ["PlayApp", "run"]
