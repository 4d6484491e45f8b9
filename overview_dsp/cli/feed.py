"""The command `overview feed`: a timeline as a live feed."""

from __future__ import annotations

import math
import sys
import time
from typing import Any

from overview_dsp.cli.options.declaring import cli_command, option
from overview_dsp.cli.options.reading import Reading, open_timeline
from overview_dsp.errors import InputError


def _speed(context: Any, parameter: Any, speed: float) -> float:
    if not speed > 0.0:  # NaN too
        raise InputError(f"--speed is {speed:g}; must be above 0 (1: real time, inf: at once)")
    return speed


@cli_command("feed world-cup-final-2018 --speed 60 | overview play --follow -", name="feed")
def command(
    timeline: str, *, speed: float = option(default=1.0, callback=_speed), reading: Reading
) -> None:
    """Print TIMELINE as a live feed: one line of JSON per event, at its time.

    overview play --follow - and overview serve --follow - read it.
    """
    from overview_dsp.data.feeds.feed_lines import encode_line, lines_of_timeline

    data = open_timeline(timeline, reading)
    start = time.monotonic()
    for time_s, line in lines_of_timeline(data):
        if speed != math.inf:
            time.sleep(max(start + time_s / speed - time.monotonic(), 0.0))
        sys.stdout.write(encode_line(line))
        if speed != math.inf:
            sys.stdout.flush()
