"""A preset heard and felt at a glance: every kind of event, one after the other, out and back."""

from __future__ import annotations

from collections.abc import Sequence

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.offline.rendering.offline import RenderResult, render

REPEATS = 2
MANY = 10
"""From so many kinds on, each is there once: a fast sweep should still part them."""

PAGE_KINDS = 6
SECONDS_EACH = 0.3
"""The hand's way from one event to the next: far enough apart to distinguish them."""


def gallery(preset: Preset) -> Timeline:
    """A made-up timeline with each kind of the preset, twice in a row, and nothing else."""
    repeats = REPEATS if len(preset.kinds) < MANY else 1
    return _gallery(f"{preset.title}: every kind", list(preset.kinds), repeats)


def pages(preset: Preset) -> tuple[Timeline, ...]:
    """The gallery in parts of so few kinds that a sweep in a second parts them, each kind twice."""
    names = list(preset.kinds)
    count = -(-len(names) // PAGE_KINDS)
    # one after the other in turn, so that a preset's last page isn't a short one
    return tuple(
        _gallery(f"{preset.title}: every kind", names[i::count], REPEATS) for i in range(count)
    )


def _gallery(title: str, kinds: Sequence[str], repeats: int) -> Timeline:
    names = [name for name in kinds for _ in range(repeats)]
    length = SECONDS_EACH * (len(names) + 1)
    events = tuple(Event(SECONDS_EACH * (i + 1), name, name) for i, name in enumerate(names))
    return Timeline(title=title, duration_s=length, events=events)


def audition(preset: Preset, seed: int = 0) -> RenderResult:
    """Render a steady sweep over the gallery and its recoil."""
    timeline = gallery(preset)
    return render(timeline, preset, sweep(timeline.duration_s), seed=seed)
