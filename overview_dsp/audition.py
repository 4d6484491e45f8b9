"""A preset heard and felt at a glance: every kind of event, one after the other, out and back."""

from __future__ import annotations

from overview_dsp.gestures import sweep
from overview_dsp.presets.model import Preset
from overview_dsp.rendering import Result, render
from overview_dsp.timeline import Event, Timeline

REPEATS = 2
MANY = 10
"""From so many kinds on, each is there once: a fast sweep should still part them."""

SECONDS_EACH = 0.3
"""The hand's way from one event to the next: far enough apart to tell them."""


def gallery(preset: Preset) -> Timeline:
    """A made-up timeline with each kind of the preset, twice in a row, and nothing else."""
    repeats = REPEATS if len(preset.kinds) < MANY else 1
    names = [name for name in preset.kinds for _ in range(repeats)]
    length = SECONDS_EACH * (len(names) + 1)
    events = tuple(Event(SECONDS_EACH * (i + 1), name, name) for i, name in enumerate(names))
    return Timeline(title=f"{preset.title}: every kind", duration_s=length, events=events)


def audition(preset: Preset, seed: int = 0) -> Result:
    """Render a steady sweep over the gallery and its recoil."""
    timeline = gallery(preset)
    return render(timeline, preset, sweep(timeline.duration_s), seed=seed)
