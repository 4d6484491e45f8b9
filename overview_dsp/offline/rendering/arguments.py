"""What a render may be given: objects, or what a person would type for them."""

from __future__ import annotations

import os

from overview_dsp import validation
from overview_dsp.data.readers.memory_data import TimelineData
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.design.gestures.model import Gesture
from overview_dsp.design.gestures.spec import DEFAULT, parse_gesture
from overview_dsp.design.gestures.take import load_gesture
from overview_dsp.design.presets.library import fitting_preset, load_preset
from overview_dsp.design.presets.model import Preset

AnyTimeline = Timeline | TimelineData
"""A Timeline, or whatever `load_timeline` takes."""

AnyPreset = Preset | str | os.PathLike[str] | None
"""A Preset, a name, a path; None is the one that fits the data."""

AnyGesture = Gesture | str | os.PathLike[str] | None
"""A Gesture, a SPEC, a take's path; None is `gestures.spec.DEFAULT`."""


def given_timeline(timeline: AnyTimeline) -> Timeline:
    """Return what is felt; errors as `load_timeline`."""
    return load_timeline(timeline)


def given_preset(preset: AnyPreset, timeline: Timeline) -> Preset:
    """Return how it is felt, as asked or as fits the data; errors as `load_preset`."""
    if isinstance(preset, Preset):
        return preset
    return load_preset(
        fitting_preset(timeline) if preset is None else validation.path(preset, "preset")
    )


def given_gesture(gesture: AnyGesture) -> Gesture:
    """Return what the hand does; errors as `parse_gesture` and `load_gesture`."""
    if isinstance(gesture, Gesture):
        return gesture
    if gesture is None or isinstance(gesture, str):
        return parse_gesture(DEFAULT if gesture is None else gesture)
    return load_gesture(validation.path(gesture, "gesture"))
