"""`overview play`: a timeline under a live hand."""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack

import click

from overview_dsp.cli.common import note, read_gesture, say
from overview_dsp.cli.live_session import SECONDS, Session, open_player, play_headless
from overview_dsp.cli.options.declaring import cli_command, option
from overview_dsp.cli.options.follow import Feed, open_data
from overview_dsp.cli.options.input import FORCE_BLOCK, Controls, parse_sources
from overview_dsp.cli.options.output import Output
from overview_dsp.cli.options.reading import PresetChoice, Reading, Window
from overview_dsp.cli.options.server import open_server, require_server, server_at
from overview_dsp.cli.signals import exit_if_stopped

LOOP = ",loop"


@cli_command("play world-cup-final-2018 --preset football --record take.csv", name="play")
def command(
    timeline: str | None,
    *,
    reading: Reading,
    window: Window,
    choice: PresetChoice,
    compare: str | None = option(
        "Second preset: 1 and 2 switch between them.",
        heading=PresetChoice.heading,
        metavar="PRESET",
    ),
    feed: Feed,
    controls: Controls,
    replay: str | None = option(
        "Play a take or a gesture as the input, from the first sample on; loop repeats it.",
        heading=Controls.heading,
        metavar="TAKE.csv[,loop]",
    ),
    remote: str | None = option(
        "Serve a page on which a phone or a browser holds the disk.  [default: 127.0.0.1:8765]",
        heading=Controls.heading,
        metavar="[HOST:PORT]",
        is_flag=False,
        flag_value="",
    ),
    output: Output,
    session: Session,
    seconds: float | None = SECONDS,
    screen: str = option(
        "full; lines of text, for screen readers; or a line of JSON per second.  "
        "[default: full in a terminal, else json]",
        heading=Session.heading,
        type=click.Choice(["full", "lines", "json"]),
    ),
) -> None:
    """Play TIMELINE live: drag, tap and release with the mouse or the keys; hear and feel it.

    With --follow a timeline that grows takes its place.

    Without a terminal (or with --screen json) it prints a line of JSON a second and a summary. The
    preset's file is watched: save it, feel it. Channels, gains, mutes, delays, ceilings and the
    actuator are remembered for each output device.
    """
    if remote is not None:
        require_server()
        server = server_at(remote)
        if remote and timeline is None and feed.follow is None:
            raise click.UsageError(f"--remote {remote} is an address; name the TIMELINE before it")
    if feed.follow == "-" and "-" in controls.input:
        raise click.UsageError("--follow - and --input - both read standard input")
    if feed.follow is not None and replay is not None:
        raise click.UsageError("--replay is for a timeline that is finished; leave --follow out")
    if replay is not None and controls.input:
        raise click.UsageError("--replay is the input; leave --input out")
    path = (replay or "").removesuffix(LOOP)
    movement = None if replay is None else read_gesture(path)
    sources = parse_sources(controls.input)
    with ExitStack() as stack:
        data = stack.enter_context(open_data(timeline, feed, reading, window, choice.preset))
        block = {"usual_block": FORCE_BLOCK} if sources.force else {}
        player, received = stack.enter_context(
            open_player(data, output, session, choice.linear, compare, **block)
        )
        if movement is not None:
            player.loop.begin(movement, os.path.basename(path), path != replay)
        source = sources.opened(player, stack.callback)
        invitation = ""
        if controls.osc_out is not None:
            from overview_dsp.live.ports.osc import OscOut

            stack.callback(OscOut(player.engine, controls.osc_out, player.say).close)
        if remote is not None:
            from overview_dsp.web.session import HostSession

            source = host = HostSession(player, source)
            routes = data.routes("host", choice.linear)
            opened = stack.enter_context(open_server(server, host, routes, data.growth is not None))
            invitation = opened.text
        terminal = sys.stdin.isatty() and sys.stdout.isatty() and not sources.by_lines
        if screen == "json" or not terminal:
            play_headless(player, source, received, seconds, controls.osc_out is not None)
        elif screen == "lines":
            from overview_dsp.live.screen.lines import run as run_lines

            run_lines(player, source, lambda: bool(received), say)
        else:
            from overview_dsp.live.screen import run

            run(player, source, lambda: bool(received), invitation)
        lines = sources.lines
        if lines is not None and lines.refused:
            note(
                f"{lines.refused} lines weren't `theta2 touching`; the first: {lines.first_refused}"
            )
    exit_if_stopped(received)
