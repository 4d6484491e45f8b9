"""Active timeline window and preset.

Both are wished for, and handed to the engine as soon as it has a surface free.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping
from typing import Any

from overview_dsp.data.feeds.difference import difference
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.time_expressions import Zoom
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.live.session.presets import PresetPair
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.replay import apply_change
from overview_dsp.signal.surface.angle_map import SHARE, AngleMap
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.live_update import join_surfaces

_NUMBER = re.compile(r"\d[\d.:e+-]*")

TRIED = 20
"""Windows tried at most for one in which a zoom's moment lies where it did."""

NEAR = 1e-6
"""Of the window: an event so near is the one that the hand is on."""


class ActiveWindow:
    """The window and the preset of an engine, and those that are wished for.

    Thread: control.

    Attributes
    ----------
    timeline : Timeline
        The whole.
    window : (start_s, end_s)
        The part of it under the hand.
    shown : Timeline
        That part, from 0.
    presets : PresetPair
        Those to choose from.
    """

    def __init__(self, session: Session, timeline: Timeline, presets: PresetPair) -> None:
        """Begin with the whole timeline, which the engine has."""
        self._engine, self._say = session.engine, session.say
        self.timeline = self.shown = timeline
        self.window = (0.0, timeline.duration_s)
        self.presets = presets
        self._wanted_window: tuple[float, float] | None = None
        self._wanted_preset: Preset | None = None
        self._wanted_whole: Timeline | None = None
        self._map_waits: Preset | None = None
        self._grows = False
        self._said_of_growth: set[str] = set()

    def grow(self, timeline: Timeline) -> bool:
        """Take over the timeline as it is now; a part that is shown stays, as far as it reaches.

        False if no surface is free for it yet: nothing waits then.
        """
        self._grows = True
        self._wanted_whole = timeline
        self._make_changes()
        done, self._wanted_whole = self._wanted_whole is None, None
        return done

    def grow_ahead(self, timeline: Timeline, place: float) -> bool:
        """Take over what is new beyond a place of the whole (0 to 1), whoever touches it.

        False where that can't be: a part is shown, places move, what lies behind has changed.
        """
        waits = (self._wanted_window, self._wanted_preset) != (None, None)
        same = self.shown is self.timeline and timeline.duration_s == self.timeline.duration_s
        if waits or not same:
            return False
        engine = self._engine
        try:
            with warnings.catch_warnings():  # they are said when the whole comes
                warnings.simplefilter("ignore", OverviewWarning)
                kept = engine.surface.angle_map
                new = build_surface(timeline, engine.preset, kept)
                surface = join_surfaces(engine.surface, new, place)
            if surface is None:
                return False
            note = self._note(timeline, {"window": None, "ahead": place})
            engine.set_timeline(timeline, change=note, surface=surface)
        except OverviewError:  # two surfaces fade already
            return False
        self.timeline = timeline
        self.put(timeline, (0.0, timeline.duration_s))
        return True

    def zoom(self, factor: float, about: float) -> float:
        """Show `factor` times as much detail; return the position of the moment under `about` then.

        That is `about` (0 to 1) itself, unless an end of the timeline is in the way, or a step of
        the angle map: an event that comes into the window or leaves it moves all others at once.
        """
        zoom = Zoom(self.timeline, *(self._wanted_window or self.window))
        shown = self.angle_map if self._wanted_window is None else self._map_of(zoom)
        moment_s = zoom.start_s + float(shown.time_at(about))
        best, place = zoom, math.inf
        # the later a window starts, the further left the moment lies in it
        at, low, high = about, 0.0, 1.0
        for _ in range(TRIED):
            tried = zoom.scaled(factor, moment_s, at)
            there = self._position_in(tried, moment_s)
            if abs(there - about) < abs(place - about):
                best, place = tried, there
            if abs(place - about) < NEAR:
                break
            low, high = (at, high) if there < about else (low, at)
            at = (low + high) / 2.0
        self.show(*best.window)
        return place

    @property
    def angle_map(self) -> AngleMap:
        """The map of the part under the hand."""
        made = self._engine.surface.angle_map
        # while a pattern tells of something new, the surface is that's
        same = self._engine.timeline is self.shown
        return made if same else AngleMap.of(self.shown, self._engine.preset)

    def moment_s(self, position: float) -> float:
        """The moment of the whole, s, at a position of the window, 0 to 1."""
        return self.window[0] + float(self.angle_map.time_at(position))

    def _position_in(self, zoom: Zoom, moment_s: float) -> float:
        """The position of a moment in another window, which has a map of its own."""
        return float(self._map_of(zoom).position_of(moment_s - zoom.start_s))

    def _map_of(self, zoom: Zoom) -> AngleMap:
        return AngleMap.of(self.timeline.window(*zoom.window), self._engine.preset)

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand; InputError if it isn't one."""
        if (start_s, end_s) != self.window:
            self.timeline.window(start_s, end_s)
            self._wanted_window = (start_s, end_s)
            self._make_changes()

    def event_beside(self, direction: int, position: float) -> float | None:
        """The place (0 to 1) of the event after (1) or before (-1) a position, if there is one.

        Beyond its end the window moves along.
        """
        zoom = Zoom(self.timeline, *self.window)
        positions = [float(one) for one in self._engine.surface.position]
        if direction > 0:
            wanted = min((one for one in positions if one > position + NEAR), default=None)
            beyond = zoom.next_event_s(zoom.end_s)
        else:
            wanted = max((one for one in positions if one < position - NEAR), default=None)
            beyond = zoom.previous_event_s(zoom.start_s)
        if wanted is None and beyond is not None:
            moved = zoom.showing(beyond)
            self.show(*moved.window)
            wanted = self._position_in(moved, beyond)
        return wanted

    def use(self, preset: Preset) -> None:
        """Change to a preset."""
        self._wanted_preset = self.presets.fitted(preset)
        self._make_changes()

    def poll(self) -> None:
        """See whether a preset's file was saved; hand over what waits."""
        for line in self.presets.look():
            self._say(line)
        self._wanted_preset = self.presets.take_changed() or self._wanted_preset
        if self._map_waits is not None and self._engine.active_input is None:
            self._wanted_preset = self._wanted_preset or self._map_waits
        self._make_changes()

    def take_wish(self) -> Preset:
        """The preset that is wanted, or the present one; nothing waits then."""
        preset = self._wanted_preset or self._map_waits or self._engine.preset
        self._wanted_preset = self._map_waits = None
        return preset

    def put(self, shown: Timeline, window: tuple[float, float]) -> None:
        """The engine has this part now."""
        self.window, self.shown, self._wanted_window = window, shown, None

    def put_at(self, window: tuple[float, float], sample: int) -> None:
        """Give the engine a part of the timeline at a sample; errors as `Engine.set_timeline`."""
        shown = self.timeline.window(*window)
        self._engine.set_timeline(shown, sample, window)
        self.put(shown, window)

    def change_at(self, what: Mapping[str, Any], sample: int) -> None:
        """Make a take's change of what lies under the hand; errors as `apply_change`."""
        self.timeline = apply_change(self._engine, self.timeline, what, sample)
        if "pattern" not in what:  # what it tells lies over the timeline for a moment
            window = what["window"] if "window" in what else what["timeline"]["window"]
            self.put(self._engine.timeline, tuple(window or (0.0, self.timeline.duration_s)))

    def _make_changes(self) -> None:
        """Hand over what is wanted; what finds no free surface slot waits for the next poll."""
        if (self._wanted_whole, self._wanted_window, self._wanted_preset) == (None, None, None):
            return
        with warnings.catch_warnings(record=True) as noted:
            warnings.simplefilter("always")
            try:
                self._change()
            except InputError as error:
                self._wanted_preset = self._wanted_whole = None
                self._say(f"{self.presets.name}: {error}; the last good one plays on")
            except OverviewError:
                return  # two surfaces fade already
        for one in noted:
            if issubclass(one.category, OverviewWarning):
                self._say_unless_grown(str(one.message))

    def _say_unless_grown(self, line: str) -> None:
        """Say a warning; of a timeline that grows only once, with whatever numbers."""
        words = _NUMBER.sub("", line)
        if words not in self._said_of_growth:
            self._say(line)
        if self._grows:
            self._said_of_growth.add(words)

    def _change(self) -> None:
        if self._wanted_whole is not None:
            self._grow(self._wanted_whole)
            self._wanted_whole = None
        if self._wanted_window is not None:
            window = self._wanted_window
            shown = self.timeline.window(*window)
            self._engine.set_timeline(shown, window=window)
            self.put(shown, window)
        if self._wanted_preset is not None:
            wanted, kept = self._wanted_preset, self._wanted_preset
            if self._engine.active_input is not None:  # no place moves under a hand
                kept = wanted.with_value(SHARE, self._engine.preset.number(SHARE))
            self._engine.set_preset(kept)
            self._map_waits = None if kept == wanted else wanted
            self._wanted_preset = None

    def _grow(self, whole: Timeline) -> None:
        """Hand over a timeline that has grown, and which part of it is under the hand."""
        window = self._wanted_window or self.window
        if self._wanted_window is None and window == (0.0, self.timeline.duration_s):
            window = (0.0, whole.duration_s)
        start, end = window[0], min(window[1], whole.duration_s)
        if start >= end:  # a shorter map: what was shown isn't in it
            start, end = 0.0, whole.duration_s
        all_of_it = (start, end) == (0.0, whole.duration_s) and self.shown is self.timeline
        shown = whole if all_of_it else whole.window(start, end)
        note = self._note(whole, {"window": None if all_of_it else [start, end]})
        kept = self._engine.surface.angle_map
        held = self._engine.active_input is not None and kept.duration_s == shown.duration_s
        if note is not None and held:
            note["timeline"]["keeps_map"] = True
        surface = build_surface(shown, self._engine.preset, kept) if held else None
        self._engine.set_timeline(shown, change=note, surface=surface)
        self.timeline = whole
        self.put(shown, (start, end))

    def _note(self, whole: Timeline, more: dict[str, Any]) -> dict[str, Any] | None:
        """What a take holds of the timeline's growth; None where that is too long for one."""
        try:
            return {"timeline": {**difference(self.timeline, whole), **more}}
        except InputError:
            return None
