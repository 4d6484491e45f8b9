"""The command `overview play`: a timeline under live control."""

from __future__ import annotations

import math
import os
import sys
import time
from contextlib import ExitStack
from dataclasses import astuple

import click

from overview_dsp.cli.common import note, read_gesture, say
from overview_dsp.cli.live_session import SECONDS, Comparison, Session, open_player, play_headless
from overview_dsp.cli.options.declaring import cli_command, option, require_none
from overview_dsp.cli.options.follow import Feed, open_data
from overview_dsp.cli.options.input import Controls, parse_sources
from overview_dsp.cli.options.output import Output
from overview_dsp.cli.options.reading import PresetChoice, Reading, Window
from overview_dsp.cli.options.server import require_server, server_at
from overview_dsp.cli.signals import exit_if_stopped

LOOP = ",loop"


@cli_command(
    "play world-cup-final-2018 --preset football --record take.csv",
    name="play",
    first="preset window follow input remote device record screen",
)
def command(
    timeline: str | None,
    *,
    reading: Reading,
    window: Window,
    choice: PresetChoice,
    comparison: Comparison,
    feed: Feed,
    controls: Controls,
    output: Output,
    session: Session,
    seconds: float | None = SECONDS,
    screen: str | None = option(
        heading=Session.heading, type=click.Choice(["full", "lines", "json"])
    ),
) -> None:
    """Play TIMELINE live, by mouse, keys, sensors, controllers or a take.

    --follow replaces TIMELINE by a live source. Without a terminal, the command prints one line of
    JSON per second and a summary, unless --screen is lines. A saved change of the preset file is
    heard at once. Channels, gains, mutes, delays, ceilings and the actuator are saved for each
    output device.
    """
    server = None if controls.remote is None else server_at(controls.remote)
    controls.require_consistent(timeline, feed.follow)
    replay = controls.replay or ""
    path = replay.removesuffix(LOOP)
    movement = read_gesture(path) if path else None
    sources = parse_sources(controls.input)
    terminal = sys.stdin.isatty() and "lines" not in sources.openers
    terminal &= screen == "lines" or sys.stdout.isatty()  # lines go to standard error
    has_keys = terminal or bool(controls.input)
    comparison.require_consistent(session.record, controls.remote, screen, has_keys)
    problem = "--screen full needs a terminal, whose keys --input - excludes; give lines or json"
    require_none({problem: screen == "full" and not terminal})
    with ExitStack() as stack:
        data = stack.enter_context(open_data(timeline, feed, reading, window, choice.preset))
        player, received = stack.enter_context(
            open_player(data, output, session, choice.linear, comparison.compare, sources.force)
        )
        if comparison.blind:
            comparison.begin(player, path, movement, path != replay)
            stack.callback(lambda: say(player.blind.result_text if player.blind else ""))
        elif movement is not None:
            player.loop.begin(movement, os.path.basename(path), path != replay)
        source = sources.open(player, stack.callback)
        address = ""
        if controls.osc_out is not None:
            from overview_dsp.live.ports.osc import OscOut

            out = OscOut(player.engine, controls.osc_out, player.say, lambda: astuple(player.state))
            stack.callback(out.close)
        if server is not None:
            from overview_dsp.web.session import HostSession

            require_server()
            source = host = HostSession(player, source)
            address = stack.enter_context(data.served(server, host, choice.linear)).text
        until = math.inf if seconds is None else time.monotonic() + seconds

        def stopped() -> bool:
            return bool(received) or time.monotonic() >= until

        is_plain = comparison.blind or os.environ.get("TERM") == "dumb"
        if screen == "lines" or (screen is None and terminal and is_plain):
            from overview_dsp.live.screen.plain_mode import run as run_lines

            run_lines(player, source, stopped, say, address, terminal)
        elif screen == "json" or not terminal:
            play_headless(player, source, received, seconds, controls.osc_out is not None)
        else:
            from overview_dsp.live.screen import run

            run(player, source, stopped, address)
        if (lines := sources.lines) is not None and lines.rejected:
            note(
                f"{lines.rejected} lines were not `theta2 touching`; first: {lines.first_rejected}"
            )
    exit_if_stopped(received)
