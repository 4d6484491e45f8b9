"""`overview feed`: a recorded match, told as if it were being played."""

from __future__ import annotations

import math
import sys
import time
from typing import Any

import click

from overview_dsp.cli.options.timeline import open_timeline, timeline_options


def _speed(context: Any, option: Any, speed: float) -> float:
    from overview_dsp.errors import InputError

    if not speed > 0.0:  # NaN too
        raise InputError(f"--speed {speed:g}; it is above 0, 1 is as it was, inf is at once")
    return speed


@click.command(
    name="feed",
    epilog="Example: overview feed world-cup-final-2018 --speed 60 | overview play --follow -",
)
@click.argument("timeline")
@click.option("--speed", type=float, default=1.0, show_default=True, callback=_speed,
              help="How many times as fast as it was; inf is at once.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="An error as a line of JSON too.")
@timeline_options
def command(timeline: str, speed: float, as_json: bool, load: dict[str, Any]) -> None:
    """Tell TIMELINE as a feed: a line of JSON on standard output whenever something happens.

    `overview play --follow` and `overview serve --follow` take it.
    """
    from overview_dsp.data.feeds.feed_lines import encode_line, feed_of

    data = open_timeline(timeline, load)
    begun = time.monotonic()
    for time_s, line in feed_of(data):
        if speed != math.inf:
            time.sleep(max(begun + time_s / speed - time.monotonic(), 0.0))
        sys.stdout.write(encode_line(line))
        if speed != math.inf:
            sys.stdout.flush()
