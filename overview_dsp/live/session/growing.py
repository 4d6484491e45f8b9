"""A timeline that grows under a live hand: when what came arrives, and how it is told.

A hand that holds the disk keeps the positions that it touched. What comes meanwhile waits until it
lets go, or for a chosen time; where the map is the whole, what lies ahead of disk and hand comes at
once, since no place moves. What is new and strong enough is told by a pattern of its own
(`following.pattern`) while nobody holds the disk.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from overview_dsp.data.feeds.difference import HOLDS_S, LASTS_S, TAP, pattern_change
from overview_dsp.data.feeds.follower import Follower
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.presets.model import DEFAULT_KIND, Preset
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.inputs.feeds import map_named
from overview_dsp.live.session.active_window import ActiveWindow
from overview_dsp.live.session.session import Session
from overview_dsp.signal.engine.replay import set_pattern
from overview_dsp.units import HALF_TURN, clock_text

EVERY_S = 0.05
"""A new map is made at most so often: it is felt within a tenth of a second of its coming."""

AHEAD = 0.05
"""What lies at least so far ahead (of 1) of the disk and of the hand that holds it may change."""

FRESH_S = 180.0
"""An event longer ago than this, on the feed's clock, is no news: it is felt, but not told."""

MAP = "follow.map"

DISCREET = "in company"
"""A preset for this use tells nothing by itself."""


@dataclass(frozen=True)
class Growth:
    """How a session follows a timeline.

    Parameters
    ----------
    live
        What grows.
    follower
        Who keeps it up, None where the program does.
    after_s
        A hand that holds on gets what is new after so long, s; None is when it lets go.
    tell
        The kind of event from whose strength on a new one is told; "none" is never, None is by the
        preset: own goals and more, nothing of a discreet one.
    map_is_given
        Whether a person chose the map; else a preset that says one does.
    preset
        What fits it, where that is known before anything has come.
    """

    live: LiveTimeline
    follower: Follower | None = None
    after_s: float | None = None
    tell: str | None = None
    map_is_given: bool = False
    preset: str | None = None

    def lay_out(self, preset: Preset) -> None:
        """Lay the timeline under the hand as the preset says."""
        said = str(preset.values[MAP])
        if said != "auto" and not self.map_is_given:
            self.live.map = map_named(said)


class Growing:
    """Brings what came to what is under the hand.

    Thread: control.

    Attributes
    ----------
    told : list of Event
        What was told by a pattern, the latest last (up to 100).
    """

    def __init__(self, session: Session, growth: Growth, window: ActiveWindow) -> None:
        self._engine, self._say, self._window = session.engine, session.say, window
        self._growth = growth
        self._seen = growth.live.revision
        self._held_since: float | None = None
        self._next = 0.0
        self._news: Event | None = None
        self._pattern: tuple[float, bool] | None = None  # since when, and whether it still holds
        self._put_back = False
        self._refused: tuple[Timeline, float] | None = None
        self._map = self._engine.preset.values[MAP]
        self.told: list[Event] = []

    @property
    def live(self) -> LiveTimeline:
        """What grows."""
        return self._growth.live

    @property
    def words(self) -> str:
        """How far it has come, for a person."""
        follower = self._growth.follower
        if follower is not None:
            return follower.words
        return f"data until {clock_text(self.live.now_s)}"

    def poll(self, finger: bool) -> None:
        """Hand over what is due; `finger`: whether that of mouse and keys is down."""
        now = time.monotonic()
        if self._growth.follower is not None:
            for line in self._growth.follower.take_messages():
                self._say(line)
        if self._engine.preset.values[MAP] != self._map:  # another preset
            self._map = self._engine.preset.values[MAP]
            self._growth.lay_out(self._engine.preset)
        self._look_at_news()
        hands = finger or self._held_by_a_hand()
        self._held_since = None if not hands else self._held_since or now
        if self._pattern is not None:
            self._go_on_telling(now, finger, hands)
            return
        after_s = math.inf if self._growth.after_s is None else self._growth.after_s
        keeps = self._held_since is not None and now - self._held_since < after_s
        if now < self._next:
            return
        snapshot = self.live.felt()
        if keeps:
            self._bring_ahead(snapshot, now)
            return
        if snapshot is not self._window.timeline or self._put_back:
            if not self._window.grow(snapshot):
                return  # two surfaces fade already
            self._put_back = hands  # whom the map under them is kept for
            self._next = now + EVERY_S
            self._held_since = now if hands else None
        if self._news is not None and not hands:
            self._tell(self._news, now)

    def _bring_ahead(self, snapshot: Timeline, now: float) -> None:
        """Hand over what lies ahead of the disk and of who holds it, and nothing else."""
        under, holder = self._window, self._engine.active_input
        grows = self.live.map == "whole" and snapshot is not under.timeline
        if not grows or holder is None or under.timeline.known_until_s is None:
            return
        place = max(self._engine.meters.cursor, holder[1] / HALF_TURN) + AHEAD
        happened = under.timeline.known_until_s / under.timeline.duration_s
        refused = self._refused
        tried = refused is not None and refused[0] is snapshot and place >= refused[1] - AHEAD
        if tried or place >= happened + AHEAD:
            return
        if under.grow_ahead(snapshot, place):
            self._put_back = True  # all of it comes when the hand lets go
            self._next = now + EVERY_S
        else:
            self._refused = (snapshot, place)

    def _held_by_a_hand(self) -> bool:
        """Whether anybody pulls the disk but the pattern's tap."""
        holder = self._engine.active_input
        if self._pattern is not None and self._pattern[1]:
            return holder not in (None, ("touch", TAP * HALF_TURN))
        return holder is not None or (self._pattern is None and self._is_arriving())

    def _is_arriving(self) -> bool:
        """Whether the disk is still on its way to where a hand released it."""
        engine = self._engine
        return engine.meters.engaged and engine.preset.values["disk.release"] == "recoil"

    def restarted(self) -> None:
        """The engine has begun anew: whatever was being told is over."""
        self._pattern = None

    # --- what is new ----------------------------------------------------------------------------

    def _look_at_news(self) -> None:
        changes = self.live.changes_since(self._seen)
        if not changes:
            return
        self._seen = changes[-1].revision
        preset = self._engine.preset
        least, silent = self._least(preset), self._is_silent(preset)
        for change in changes:
            event = change.event
            strength = _strength(preset, event)
            if strength < least:
                continue
            words = f"{event.kind.replace('_', ' ')} {event.display_label}".strip()
            at = clock_text(event.time_s)
            if change.what == "retracted":
                self._say(f"taken back: {words} at {at}")
                if self._news == event:
                    self._news = None
                continue
            self._say(f"new: {words} at {at}")
            fresh = event.time_s >= self.live.now_s - FRESH_S
            stronger = self._news is None or strength >= _strength(preset, self._news)
            if fresh and stronger and not silent:
                self._news = event

    def _least(self, preset: Preset) -> float:
        """From which strength on an event is told."""
        kind = preset.kinds.get(self._growth.tell or "own_goal")
        if kind is not None:
            return kind.height
        named = [one.height for name, one in preset.kinds.items() if name != DEFAULT_KIND]
        return max(named or [preset.kinds[DEFAULT_KIND].height])

    def _is_silent(self, preset: Preset) -> bool:
        """Whether new events are said and shown, but no pattern tells of them."""
        tell = self._growth.tell
        return tell == "none" or (tell is None and DISCREET in preset.tags.usage)

    # --- the pattern ----------------------------------------------------------------------------

    def _tell(self, event: Event, now: float) -> None:
        self._news = None
        change = pattern_change(event)
        try:
            set_pattern(self._engine, change)
        except InputError:
            return
        except OverviewError:  # two surfaces fade already: at the next poll
            self._news = event
            return
        self._engine.control(TAP * HALF_TURN, True)
        self._pattern = (now, True)
        self.told = [*self.told[-99:], event]

    def _go_on_telling(self, now: float, finger: bool, hands: bool) -> None:
        """Let go, and have the timeline back; at once where a hand wants the disk."""
        assert self._pattern is not None
        since, holds = self._pattern
        if holds and (hands or now >= since + HOLDS_S):
            if not finger:  # it is the same source: its hold has taken the tap's place
                self._engine.control(TAP * HALF_TURN, False)
            self._pattern = (since, False)
        if hands or now >= since + LASTS_S:
            self._pattern = None
            self._put_back = not self._window.grow(self.live.felt())


def _strength(preset: Preset, event: Event) -> float:
    kind = preset.kinds[preset.kind_for(event.kind) or DEFAULT_KIND]
    return kind.height * event.weight
