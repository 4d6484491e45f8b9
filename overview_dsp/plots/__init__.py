"""The pictures: timelines, sweeps and taps, presets."""

from overview_dsp.public.moved import moved_name


def __getattr__(name: str) -> object:
    return moved_name(__name__, name)
