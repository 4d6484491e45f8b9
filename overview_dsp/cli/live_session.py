"""What commands that play live share: the device, the player, its end by a signal or in time."""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import note, say
from overview_dsp.cli.options.output import actuator_option, output_options
from overview_dsp.cli.stopping import signals_that_end
from overview_dsp.files.atomic import remove_temporaries

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.session.growing import Growth
    from overview_dsp.live.session.headless import Passed
    from overview_dsp.live.session.player import Player


END_WITHIN_S = 2.0


def live_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Options of the device and the session, which `opened_player` takes as `live`."""
    options = (
        click.option("--device", help="Output: a name or number of `overview devices`, pad, none."),
        click.option("--block-size", default=256, show_default=True,
                     help="Frames, 0 = the device's own."),
        click.option("--sample-rate", type=float, callback=rate_given,
                     help="Hz; the device's own if left out."),
        click.option("--callback", type=click.Choice(["native", "python"]), default="native",
                     show_default=True, help="What PortAudio calls."),
        click.option("--record", metavar="TAKE.csv", help="Keep what was played, to the bit."),
        click.option("--seed", default=0, show_default=True, help="Of the surface's grain."),
        actuator_option,
        output_options,
    )  # fmt: skip
    for option in reversed(options):
        function = option(function)
    return function


def rate_given(context: Any, option: Any, rate: float | None) -> float | None:
    """A sample rate, refused here: the device would be asked for its own at 0."""
    from overview_dsp.errors import InputError
    from overview_dsp.signal.engine.engine import MAX_SAMPLE_RATE, MIN_SAMPLE_RATE

    if rate is not None and not MIN_SAMPLE_RATE <= rate <= MAX_SAMPLE_RATE:
        raise InputError(
            f"sample rate {rate:g} Hz is out of range; it is {MIN_SAMPLE_RATE:g} to "
            f"{MAX_SAMPLE_RATE:g} Hz"
        )
    return rate


def seconds_given(context: Any, option: Any, seconds: float | None) -> float | None:
    """How long to play; written so that NaN fails."""
    from overview_dsp.errors import InputError

    if seconds is not None and not 0.0 <= seconds < math.inf:
        raise InputError(f"--seconds {seconds:g}; it is 0 or more")
    return seconds


@contextmanager
def opened_player(
    data: Timeline,
    part: tuple[float, float] | None,
    preset: str,
    live: dict[str, Any],
    ab: str | None = None,
    growth: Growth | None = None,
    linear: bool = False,
) -> Iterator[tuple[Player, list[int]]]:
    """A player on the device that the options name, and the signals that ask for its end.

    It is closed, saved and remembered afterwards. `part` (s) is what it shows first, `ab` a second
    preset to switch to; with `growth` the data, which are its snapshot, grow; `linear` leaves the
    presets' angle maps out.

    Raises
    ------
    OverviewError
        A device, file or value that can't be used.
    """
    from overview_dsp.live.session.opened import OpenedPlayer, PlayerSettings

    keys = {"channel": "channel", "gain": "gain_db", "mute": "mute", "delay": "delay_ms",
            "ceiling": "ceiling_db"}  # fmt: skip
    changed: dict[str, Any] = {
        signal: {
            key: live[f"{signal}_{option}"]
            for option, key in keys.items()
            if live[f"{signal}_{option}"] is not None
        }
        for signal in ("click", "tactor")
    }
    names = ("device", "block_size", "sample_rate", "callback", "record", "seed", "actuator")
    given = {name: live[name] for name in names}
    settings = PlayerSettings(preset, ab, linear, part, growth, **given, **changed)
    opened = OpenedPlayer(data, settings, note, say)
    with ended_by_signals(opened.player.takes.end) as received, opened as player:
        yield player, received


@contextmanager
def ended_by_signals(save: Callable[[], None] | None = None) -> Iterator[list[int]]:
    """The signals that ask for an end, collected instead of obeyed.

    A process that hasn't ended `END_WITHIN_S` after the first one (a terminal that takes nothing
    more, a device that doesn't answer) is ended then, after `save`.
    """
    received: list[int] = []

    def receive(number: int, frame: Any) -> None:
        received.append(number)
        if len(received) == 1:
            threading.Thread(target=end_anyway, name="end", daemon=True).start()

    def end_anyway() -> None:
        time.sleep(END_WITHIN_S)
        try:
            if save is not None:
                save()
            remove_temporaries()
        finally:
            os._exit(128 + received[0])

    before = {number: signal.signal(number, receive) for number in signals_that_end()}
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def exit_if_stopped(received: list[int]) -> None:
    """End the program as signals do, if one came."""
    if received:
        say(f"stopped by {signal.Signals(received[0]).name}")
        sys.exit(128 + received[0])


def print_lines(
    player: Player,
    source: Input | None,
    received: list[int],
    seconds: float | None,
    logged: bool = False,
) -> None:
    """Play with a line of JSON a second; the last one says what happened, unless it is `logged`."""
    from overview_dsp.live.session.headless import run

    def describe(passed: list[Passed]) -> dict[str, Any]:
        from overview_dsp.offline.rendering.event_log import as_records, of_events

        times, events, levels = zip(*passed, strict=True) if passed else ((), (), ())
        timeline = player.engine.timeline
        return {"happened": as_records(of_events(times, levels, events, timeline))}

    for report in run(
        player, source, lambda: bool(received), note, seconds, None if logged else describe
    ):
        print(json.dumps(report), flush=True)
    player.close()  # before anything else that may take its time
