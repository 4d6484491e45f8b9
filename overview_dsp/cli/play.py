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
from overview_dsp.cli.live_session import SECONDS, Session, begin_blind, open_player, play_headless
from overview_dsp.cli.options.declaring import cli_command, option, require_none
from overview_dsp.cli.options.follow import Feed, open_data
from overview_dsp.cli.options.input import FORCE_BLOCK, Controls, parse_sources
from overview_dsp.cli.options.output import Output
from overview_dsp.cli.options.reading import PresetChoice, Reading, Window
from overview_dsp.cli.options.server import open_server, require_server, server_at
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
    compare: str | None = option(heading=PresetChoice.heading, metavar="PRESET"),
    blind: bool = option(heading=PresetChoice.heading, is_flag=True),
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
    JSON per second and a summary. A saved change of the preset file is heard at once. Channels,
    gains, mutes, delays, ceilings and the actuator are saved for each output device.
    """
    server = None if controls.remote is None else server_at(controls.remote)
    controls.require_consistent(timeline, feed.follow)
    if blind:
        _require_blind(compare, session.record, controls.remote, screen)
    replay = controls.replay or ""
    path = replay.removesuffix(LOOP)
    movement = read_gesture(path) if path else None
    sources = parse_sources(controls.input)
    terminal = sys.stdin.isatty() and sys.stdout.isatty() and "lines" not in sources.openers
    if blind and not (terminal or controls.input):
        raise click.UsageError("--blind needs a terminal for its keys, or --input with commands")
    with ExitStack() as stack:
        data = stack.enter_context(open_data(timeline, feed, reading, window, choice.preset))
        block = {"default_block": FORCE_BLOCK} if sources.force else {}
        player, received = stack.enter_context(
            open_player(data, output, session, choice.linear, compare, **block)
        )
        if blind:
            begin_blind(player, path, movement, path != replay)
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
            routes = data.routes("host", choice.linear)
            is_live = data.follow is not None
            address = stack.enter_context(open_server(server, host, routes, is_live)).text
        until = math.inf if seconds is None else time.monotonic() + seconds

        def stopped() -> bool:
            return bool(received) or time.monotonic() >= until

        if screen == "json" or not terminal:
            play_headless(player, source, received, seconds, controls.osc_out is not None)
        elif screen == "lines" or blind or (screen is None and os.environ.get("TERM") == "dumb"):
            from overview_dsp.live.screen.plain_mode import run as run_lines

            run_lines(player, source, stopped, say, address)
        else:
            from overview_dsp.live.screen import run

            run(player, source, stopped, address)
        if (lines := sources.lines) is not None and lines.rejected:
            note(
                f"{lines.rejected} lines were not `theta2 touching`; first: {lines.first_rejected}"
            )
    exit_if_stopped(received)


def _require_blind(
    compare: str | None, record: str | None, remote: str | None, screen: str | None
) -> None:
    """Check the options beside --blind; click.UsageError."""
    problems = {
        "--blind needs a second preset: --compare PRESET": compare is None,
        "--blind restarts the engine, which ends a take; remove --record": record is not None,
        "--blind doesn't apply to --remote, whose page shows the preset": remote is not None,
        "--blind doesn't apply to --screen full, which shows the presets": screen == "full",
    }
    require_none(problems)
