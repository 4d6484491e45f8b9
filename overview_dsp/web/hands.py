"""The hands on the network, as one source of the engine: `remote`.

Of several pages, the last to touch holds the disk until it lets go; another that still touches then
takes it over: what the kernel does with its sources. Whatever ends a connection, its hand lets go.

Thread: the server's, which alone writes the engine's `remote` ring.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.web.clocks import MAX_DELAY_S, Delay, PageClock, SampleClock
from overview_dsp.web.messages import RemoteEvent

SOURCE = "remote"
SILENCE_S = 0.5
"""A hand that touches and says nothing for so long is lost."""


@dataclass(eq=False)
class Hand:
    """One page's hand: where it is, and when it was last heard of."""

    theta2: float = 0.0
    touching: bool = False
    heard_s: float = 0.0
    touched: int = 0
    """Who touched last, by count."""
    name: str = ""
    """Whose it is, as it says."""
    event_to_sample_s: float | None = None
    """From the page's event to the sample it acts at."""

    def __post_init__(self) -> None:
        self.clock = PageClock()
        self.delay = Delay()


class RemoteHands:
    """All pages' hands on one engine."""

    def __init__(self, engine: Engine, clock: Callable[[], float] = time.monotonic) -> None:
        self._engine = engine
        self._now = clock
        self._samples = SampleClock(engine)
        self._hands: list[Hand] = []
        self._holder: Hand | None = None
        self._touches = 0
        self._last_stamp = 0
        self.look()

    def look(self) -> None:
        """Follow the engine's clock; call it often."""
        self._samples.look(self._now())

    def join(self) -> Hand:
        """A page has connected."""
        hand = Hand(heard_s=self._now())
        self._hands.append(hand)
        return hand

    def leave(self, hand: Hand) -> None:
        """A page is gone: its hand lets go."""
        self.release(hand)
        self._hands.remove(hand)

    def silent(self, hand: Hand) -> bool:
        """Whether a hand that touches hasn't been heard of for too long."""
        return hand.touching and self._now() - hand.heard_s > SILENCE_S

    def holds(self, hand: Hand) -> bool:
        """Whether the disk is this hand's, as far as pages go."""
        return hand is self._holder

    def others(self, hand: Hand) -> list[Hand]:
        """The other hands that touch."""
        return [one for one in self._hands if one.touching and one is not hand]

    def move(self, hand: Hand, events: tuple[RemoteEvent, ...]) -> None:
        """What a hand did, in order."""
        now = hand.heard_s = self._now()
        self.look()
        for event in events:
            stamp = self._stamp(hand, event, now)
            self._apply(hand, event.theta2, event.touching, stamp)

    def release(self, hand: Hand) -> None:
        """Let a hand go, as soon as possible."""
        if hand.touching:
            self.look()
            self._apply(hand, hand.theta2, False, self._engine.sample_time)

    def _stamp(self, hand: Hand, event: RemoteEvent, now: float) -> int:
        """The sample an event acts at: never one that is over, never far ahead."""
        happened = now
        if hand.clock.known:
            # a page's clock can't be trusted to be one
            happened = min(max(hand.clock.host_time(event.time_s), now - 1.0), now)
        wait = hand.delay.note(now, now - happened)
        due = min(max(happened + wait, now), now + MAX_DELAY_S)
        stamp = max(self._samples.sample_at(due), self._engine.sample_time)
        hand.event_to_sample_s = self._samples.time_of(stamp) - happened
        return stamp

    def _apply(self, hand: Hand, theta2: float, touching: bool, stamp: int) -> None:
        fresh = touching and not hand.touching
        hand.theta2, hand.touching = theta2, touching
        if fresh:
            self._touches += 1
            hand.touched = self._touches
            if self._holder is not None:  # the new hand's touch is a step, as any
                self._push(self._holder.theta2, False, stamp)
            self._holder = hand
        if hand is not self._holder:
            return
        if touching:
            self._push(theta2, True, stamp)
            return
        others = [one for one in self._hands if one.touching]
        self._holder = max(others, key=lambda one: one.touched, default=None)
        if self._holder is None:
            self._push(theta2, False, stamp)
        else:
            self._push(self._holder.theta2, True, stamp)

    def _push(self, theta2: float, touching: bool, stamp: int) -> None:
        """Into the ring, in order; where no sound runs, only what lets go."""
        if touching and not self._samples.runs(self._now()):
            return
        # a ring is read in order: an event waits for the one before it anyway
        stamp = self._last_stamp = max(stamp, self._last_stamp)
        self._engine.control(theta2, touching, stamp, SOURCE)
