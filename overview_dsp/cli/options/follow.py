"""The options of a timeline that grows: what it is followed from, its map, how it is told."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.options.timeline import open_timeline

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.live.session.growing import Growth

FIRST_WITHIN_S = 3.0
"""So long something is waited for, as the preset is chosen by what it is."""

_NAMES = ("follow", "expect", "tell", "update_after")


def follow_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options for `followed`; the command gets them as `following`."""

    @functools.wraps(function)
    def collected(*arguments: Any, **named: Any) -> Any:
        following = {name: named.pop(name) for name in _NAMES}
        return function(*arguments, following=following, **named)

    options = (
        click.option("--follow", metavar="SOURCE", help="In place of TIMELINE, one that grows: "
                     "a file, - (standard input), http://, ws://, audio:DEVICE, pcm:RATE[:CH]."),
        click.option("--expect", metavar="LENGTH", help="How long it will be: 95m, 1:35:00."),
        click.option("--tell", metavar="KIND", help="Tell of new events as strong as KIND and "
                     "more by a pattern; none never.  [default: own_goal; none in company]"),
        click.option("--update-after", type=float, metavar="S", help="A hand that holds on gets "
                     "what is new after so long.  [default: when it lets go]"),
    )  # fmt: skip
    for option in reversed(options):
        collected = option(collected)
    return collected


@contextmanager
def followed(
    timeline: str | None, following: dict[str, Any], load: dict[str, Any]
) -> Iterator[Growth | None]:
    """What the options follow; None where TIMELINE is a finished one.

    Raises
    ------
    InputError
        No timeline or two, a source, map or length that can't be, options of files.
    """
    from overview_dsp.errors import InputError

    source = following["follow"]
    if source is None:
        for name in _NAMES:
            if following[name] is not None:
                raise InputError(f"--{name.replace('_', '-')} is for --follow; give that too")
        if timeline is None:
            raise InputError("name a TIMELINE, or one that grows with --follow")
        yield None
        return
    if timeline is not None:
        raise InputError(f"--follow {source} is the timeline; leave {timeline} out")
    from overview_dsp.data.feeds.follower import Follower
    from overview_dsp.data.feeds.live_timeline import LiveTimeline
    from overview_dsp.data.feeds.sources import Sound
    from overview_dsp.live.inputs.feeds import expected_s, map_named, source_named
    from overview_dsp.live.session.growing import Growth

    map = load.pop("map", None)
    for name in load:
        raise InputError(f"--{name.replace('_', '-')} is for a file that is read, not for --follow")
    after_s = following["update_after"]
    if after_s is not None and not after_s >= 0.0:
        raise InputError(f"--update-after {after_s:g}; it is 0 s or more")
    expect = following["expect"]
    live = LiveTimeline(
        expect_s=None if expect is None else expected_s(expect),
        map=None if map is None else map_named(map),
    )
    named = source_named(source, sys.stdin.buffer)
    follower = Follower(live, named).start()
    try:
        until = time.monotonic() + FIRST_WITHIN_S
        while live.revision == 0 and not follower.over and time.monotonic() < until:
            time.sleep(0.02)
        if live.revision == 0 and follower.over:
            raise InputError("; ".join(follower.take_messages()) or f"{source}: nothing in it")
        fits = "crowd" if isinstance(named, Sound) else None  # it is silent at first
        yield Growth(live, follower, after_s, following["tell"], map is not None, fits)
    finally:
        follower.close()


def laid_out(data: Timeline, growth: Growth | None, preset: str) -> Timeline:
    """What `open_growing` gave, as the preset (a name or a path) lays it unless an option does."""
    if growth is None:
        return data
    from overview_dsp.design.presets.library import load_preset

    growth.lay_out(load_preset(preset))
    return growth.live.felt()


def open_growing(timeline: str | None, load: dict[str, Any], growth: Growth | None) -> Timeline:
    """The timeline as it is now, or the finished one that was named; errors as `open_timeline`."""
    if growth is not None:
        return growth.live.felt()
    assert timeline is not None
    return open_timeline(timeline, load)
