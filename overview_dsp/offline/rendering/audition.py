"""Audition of a preset: a sweep over all its event kinds, and the recoil."""

from __future__ import annotations

from collections.abc import Sequence

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.offline.rendering.offline import RenderResult, render

REPEATS = 2
MANY = 10
"""Number of kinds from which on each occurs once, so that a fast sweep still separates them."""

PAGE_KINDS = 6
SECONDS_EACH = 0.3  # time of the sweep between two events, long enough to distinguish them


def gallery(preset: Preset) -> Timeline:
    """Return a timeline with each kind of the preset, twice in a row if there are few."""
    repeats = REPEATS if len(preset.kinds) < MANY else 1
    return _gallery(f"{preset.title}: every kind", list(preset.kinds), repeats)


def pages(preset: Preset) -> tuple[Timeline, ...]:
    """Return the gallery in pages of up to `PAGE_KINDS` kinds, each kind twice."""
    names = list(preset.kinds)
    count = -(-len(names) // PAGE_KINDS)
    # distributed in turn, so that all pages are similarly long
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
