"""Active timeline window and preset of a session.

A change of either is requested first. It reaches the engine when a surface slot is free.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping
from typing import Any

from overview_dsp.data.feeds.timeline_diff import timeline_diff
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.time_expressions import Zoom
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.live.session.presets import PresetPair
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.replay import apply_change, join_surfaces, part_of
from overview_dsp.signal.surface.angle_map import SHARE, AngleMap
from overview_dsp.signal.surface.build import build_surface

_NUMBER = re.compile(r"\d[\d.:e+-]*")

MAX_ZOOM_TRIALS = 20
"""Maximum number of windows that `zoom` tries to keep a time at its position."""

SAME_POSITION = 1e-6
"""Distance within which two positions are the same, as a fraction of the window."""


class ActiveWindow:
    """Window and preset of an engine, and the requested ones that the engine doesn't have yet.

    Thread: control.

    `timeline`: whole timeline.
    `window`: visible part of the timeline.
    `window_timeline`: timeline of the window, whose times start at 0.
    `presets`: presets to choose from.
    """

    def __init__(self, session: Session, timeline: Timeline, presets: PresetPair) -> None:
        """Start with the whole timeline, which the engine already has."""
        self._engine, self._say = session.engine, session.say
        self.timeline = self.window_timeline = timeline
        self.window = (0.0, timeline.duration_s)
        self.presets = presets
        self._requested_window: tuple[float, float] | None = None
        self._requested_preset: Preset | None = None
        self._requested_timeline: Timeline | None = None
        self._deferred_preset: Preset | None = None  # its angle map waits for a release
        self._is_live = self._only_untouched = False
        self._reported: set[str] = set()

    def update_timeline(self, timeline: Timeline, only_untouched: bool = False) -> bool:
        """Use a newer version of the timeline and keep the window as far as the timeline reaches.

        Return False if no surface slot is free, or if a touch prevents it. The request is dropped
        in that case.
        """
        self._is_live = True
        self._only_untouched = only_untouched
        self._requested_timeline = timeline
        self._apply_requests()
        done, self._requested_timeline = self._requested_timeline is None, None
        return done

    def update_future(self, timeline: Timeline, position: float) -> bool:
        """Use a newer version of the timeline beyond a position (0 to 1), even during a touch.

        Return False if that isn't possible. Reasons are a request that waits, a window smaller
        than the timeline, a changed duration, or changes before the position.
        """
        waits = (self._requested_window, self._requested_preset) != (None, None)
        same = (
            self.window_timeline is self.timeline
            and timeline.duration_s == self.timeline.duration_s
        )
        if waits or not same:
            return False
        engine = self._engine
        try:
            # `update_timeline` reports them later
            with warnings.catch_warnings(action="ignore", category=OverviewWarning):
                new = build_surface(timeline, engine.preset, engine.surface.angle_map)
                surface = join_surfaces(engine.surface, new, position)
            if surface is None:
                return False
            change = self._timeline_change(timeline, {"window": None, "ahead": position})
            engine.set_timeline(timeline, change=change, surface=surface)
        except OverviewError:  # two surfaces are being crossfaded
            return False
        self.timeline = timeline
        self.set_current(timeline, (0.0, timeline.duration_s))
        return True

    def zoom(self, factor: float, about: float) -> float:
        """Show `factor` times as much detail about the time at position `about` (0 to 1).

        Return the new position of that time. It is `about` itself except near the timeline's ends
        and near steps of the angle map. An event that enters or leaves the window makes such a
        step, since it moves all other events.
        """
        zoom = Zoom(self.timeline, *(self._requested_window or self.window))
        shown = self.angle_map if self._requested_window is None else self._map_of(zoom)
        time_s = zoom.start_s + float(shown.time_at(about))
        best, position = zoom, math.inf
        # a window that starts later has the time at a smaller position
        trial, low, high = about, 0.0, 1.0
        for _ in range(MAX_ZOOM_TRIALS):
            tried = zoom.scaled(factor, time_s, trial)
            found = self._position_in(tried, time_s)
            if abs(found - about) < abs(position - about):
                best, position = tried, found
            if abs(position - about) < SAME_POSITION:
                break
            low, high = (trial, high) if found < about else (low, trial)
            trial = (low + high) / 2.0
        self.show(*best.window)
        return position

    @property
    def angle_map(self) -> AngleMap:
        """Angle map of the window."""
        current = self._engine.surface.angle_map
        # while a new event is announced, the engine has the surface of the announcing pattern
        same = self._engine.timeline is self.window_timeline
        return current if same else AngleMap.of(self.window_timeline, self._engine.preset)

    def time_at(self, position: float) -> float:
        """Return the time in the whole timeline, s, at a position of the window (0 to 1)."""
        return self.window[0] + float(self.angle_map.time_at(position))

    def _position_in(self, zoom: Zoom, time_s: float) -> float:
        """Return the position of a time in another window, which has its own angle map."""
        return float(self._map_of(zoom).position_of(time_s - zoom.start_s))

    def _map_of(self, zoom: Zoom) -> AngleMap:
        return AngleMap.of(part_of(self.timeline, zoom.window), self._engine.preset)

    def show(self, start_s: float, end_s: float) -> None:
        """Request a window; InputError if it isn't part of the timeline."""
        if (start_s, end_s) != self.window:
            self.timeline.window(start_s, end_s)
            self._requested_window = (start_s, end_s)
            self._apply_requests()

    def neighbour_event_position(self, direction: int, position: float) -> float | None:
        """Return the position of the event after (1) or before (-1) a position; None without one.

        The window moves if that event is outside it.
        """
        zoom = Zoom(self.timeline, *self.window)
        positions = [float(one) for one in self._engine.surface.position]
        if direction > 0:
            found = min((one for one in positions if one > position + SAME_POSITION), default=None)
            outside_s = zoom.next_event_s(zoom.end_s)
        else:
            found = max((one for one in positions if one < position - SAME_POSITION), default=None)
            outside_s = zoom.previous_event_s(zoom.start_s)
        if found is None and outside_s is not None:
            moved = zoom.showing(outside_s)
            self.show(*moved.window)
            found = self._position_in(moved, outside_s)
        return found

    def use(self, preset: Preset) -> None:
        """Request a preset."""
        self._requested_preset = self.presets.with_session_map(preset)
        self._apply_requests()

    def poll(self) -> None:
        """Check the preset files for changes, and apply requests that wait."""
        for line in self.presets.check_files():
            self._say(line)
        self._requested_preset = self.presets.pop_changed() or self._requested_preset
        if self._deferred_preset is not None and not self._engine.touched:
            self._requested_preset = self._requested_preset or self._deferred_preset
        self._apply_requests()

    def pop_requested_preset(self) -> Preset:
        """Return the requested preset, or the present one; remove the request."""
        preset = self._requested_preset or self._deferred_preset or self._engine.preset
        self._requested_preset = self._deferred_preset = None
        return preset

    def set_current(self, timeline: Timeline, window: tuple[float, float]) -> None:
        """Record the window that the engine has now; remove a requested one."""
        self.window, self.window_timeline, self._requested_window = window, timeline, None

    def apply_take_change(self, change: Mapping[str, Any], sample: int) -> None:
        """Apply a take's change of timeline or window at a sample; errors as `apply_change`."""
        self.timeline = apply_change(self._engine, self.timeline, change, sample)
        if "pattern" not in change:  # an announcement covers the timeline only for a moment
            window = change["window"] if "window" in change else change["timeline"]["window"]
            self.set_current(
                self._engine.timeline, tuple(window or (0.0, self.timeline.duration_s))
            )

    def _apply_requests(self) -> None:
        """Apply all requests; without a free surface slot they wait for the next poll."""
        requests = (self._requested_timeline, self._requested_window, self._requested_preset)
        if requests == (None, None, None):
            return
        with warnings.catch_warnings(record=True, action="always") as caught:
            try:
                self._apply()
            except InputError as error:
                self._requested_preset = self._requested_timeline = None
                self._say(f"{self.presets.name}: {error}; the previous version stays active")
            except OverviewError:
                return  # two surfaces are being crossfaded
        for one in caught:
            if issubclass(one.category, OverviewWarning):
                line = str(one.message)
                key = _NUMBER.sub("", line)
                if key not in self._reported:
                    self._say(line)
                if self._is_live:  # only once, whatever numbers it contains
                    self._reported.add(key)

    def _apply(self) -> None:
        if self._requested_timeline is not None:
            self._apply_timeline(self._requested_timeline)
            self._requested_timeline = None
        if self._requested_window is not None:
            timeline = part_of(self.timeline, self._requested_window)
            self._engine.set_timeline(timeline, window=self._requested_window)
            self.set_current(timeline, self._requested_window)
        if self._requested_preset is not None:
            requested, used = self._requested_preset, self._requested_preset
            if self._engine.touched:  # events keep their positions during a touch
                used = requested.with_value(SHARE, self._engine.preset.number(SHARE))
            self._engine.set_preset(used)
            self._deferred_preset = None if used == requested else requested
            self._requested_preset = None

    def _apply_timeline(self, whole: Timeline) -> None:
        """Give the engine a newer version of the timeline and its window."""
        window = self._requested_window or self.window
        if self._requested_window is None and window == (0.0, self.timeline.duration_s):
            window = (0.0, whole.duration_s)
        start, end = window[0], min(window[1], whole.duration_s)
        if start >= end:  # the timeline now ends before the window starts
            start, end = 0.0, whole.duration_s
        is_whole = (start, end) == (0.0, whole.duration_s) and (
            self.window_timeline is self.timeline
        )
        timeline = whole if is_whole else whole.window(start, end)
        change = self._timeline_change(whole, {"window": None if is_whole else [start, end]})
        kept_map = self._engine.surface.angle_map
        held = self._engine.touched and kept_map.duration_s == timeline.duration_s
        if change is not None and held:
            change["timeline"]["keeps_map"] = True
        surface = build_surface(timeline, self._engine.preset, kept_map) if held else None
        self._engine.set_timeline(
            timeline, change=change, surface=surface, only_untouched=self._only_untouched
        )
        self.timeline = whole
        self.set_current(timeline, (start, end))

    def _timeline_change(self, whole: Timeline, more: dict[str, Any]) -> dict[str, Any] | None:
        """Return the change of the timeline as a take stores it; None if it is too long."""
        try:
            return {"timeline": {**timeline_diff(self.timeline, whole), **more}}
        except InputError:
            return None
