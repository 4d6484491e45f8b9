"""The pictures: timelines, sweeps and taps, presets."""

from typing import TYPE_CHECKING

from overview_dsp.public.moved import moved_name

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        return moved_name(__name__, name)
