"""`overview play`: a timeline under a live hand."""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack
from typing import Any

import click

from overview_dsp.cli.common import note, part_of, read_gesture, say, window_options
from overview_dsp.cli.live_session import (
    exit_if_stopped,
    live_options,
    opened_player,
    print_lines,
    seconds_given,
)
from overview_dsp.cli.options.follow import follow_options, followed, laid_out, open_growing
from overview_dsp.cli.options.server import (
    open_server,
    refuse_server_options,
    require_server,
    server_options,
)
from overview_dsp.cli.options.sources import choose_force_block, input_options, parse_sources
from overview_dsp.cli.options.timeline import (
    linear_option,
    preset_for,
    preset_option,
    timeline_options,
)


@click.command(
    name="play",
    epilog="Example: overview play world-cup-final-2018 --preset football --record take.csv",
)
@click.argument("timeline", required=False)
@follow_options
@preset_option
@linear_option
@input_options
@window_options
@click.option("--seconds", type=float, callback=seconds_given, help="Stop after so long.")
@click.option(
    "--headless", "--json", "headless", is_flag=True, help="Lines of JSON, as without a terminal."
)
@click.option("--replay", metavar="TAKE.csv", help="Play a take or a gesture as the same hand, "
              "from the first sample on.")  # fmt: skip
@click.option("--loop", is_flag=True, help="Again and again.")
@click.option("--ab", metavar="PRESET", help="A second preset: 1 and 2 switch between them.")
@click.option("--line", "by_line", is_flag=True, help="Plain lines instead of a screen, for screen "
              "readers: the same keys.")  # fmt: skip
@click.option("--remote", is_flag=True, help="Also let a phone or a browser hold the disk.")
@server_options
@timeline_options
@live_options
def command(
    timeline: str | None,
    following: dict[str, Any],
    preset: str | None,
    linear: bool,
    sources: tuple[str, ...],
    sensor: str | None,
    baud: int | None,
    force: bool,
    midi_map: str | None,
    osc_map: str | None,
    osc_out: str | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    seconds: float | None,
    headless: bool,
    replay: str | None,
    loop: bool,
    ab: str | None,
    by_line: bool,
    remote: bool,
    server: dict[str, Any],
    load: dict[str, Any],
    **live: Any,
) -> None:
    """Play TIMELINE live: drag, tap and let go with the mouse or the keys, and hear and feel it.

    With --follow a timeline that grows takes its place: --map is whole or so-far then.

    Without a terminal (or with --headless) it prints a line of JSON a second and a summary. The
    preset's file is watched: save it, feel it. Channels, gains, mutes, delays, ceilings and the
    actuator are remembered for each output device.
    """
    if remote:
        require_server()
    else:
        refuse_server_options()
    if following["follow"] == "-" and "-" in sources:
        raise click.UsageError("--follow - and --input - both read standard input")
    if following["follow"] is not None and replay is not None:
        raise click.UsageError("--replay is for a timeline that is finished; leave --follow out")
    hand = None if replay is None else read_gesture(replay)
    if loop and hand is None:
        raise click.UsageError("--loop is for --replay")
    if hand is not None and sources:
        raise click.UsageError("--replay is the hand; leave --input out")
    named = parse_sources(sources, sensor, baud, midi_map, osc_map, force)
    if force:
        choose_force_block(live)
    with ExitStack() as stack:
        growth = stack.enter_context(followed(timeline, following, load))
        data = open_growing(timeline, load, growth)
        part = part_of(data, window, zoom_to)
        if part is not None and window and growth is None:
            data, part = data.window(*part), None
        name = preset_for(data, preset if growth is None else preset or growth.preset)
        data = laid_out(data, growth, name)
        player, received = stack.enter_context(
            opened_player(data, part, name, live, ab, growth, linear)
        )
        if hand is not None:
            assert replay is not None
            player.loop.begin(hand, os.path.basename(replay), loop)
        source = named.opened(player, stack.callback)
        invitation = ""
        if osc_out is not None:
            from overview_dsp.live.ports.osc import OscOut

            stack.callback(OscOut(player.engine, osc_out, player.say).close)
        if remote:
            from overview_dsp.web.data import data_routes
            from overview_dsp.web.session import HostSession

            source = session = HostSession(player, source)
            routes = data_routes(
                data,
                name,
                audio="host",
                first=part,
                live=None if growth is None else growth.live,
                linear=linear,
            )
            invitation = stack.enter_context(
                open_server(server, session, routes, growth is not None)
            ).text
        if headless or named.by_lines or not (sys.stdin.isatty() and sys.stdout.isatty()):
            print_lines(player, source, received, seconds, logged=osc_out is not None)
        elif by_line:
            from overview_dsp.live.screen.lines import run as run_lines

            run_lines(player, source, lambda: bool(received), say)
        else:
            from overview_dsp.live.screen import run

            run(player, source, lambda: bool(received), invitation)
        lines = named.lines
        if lines is not None and lines.refused:
            note(
                f"{lines.refused} lines weren't `theta2 touching`; the first: {lines.first_refused}"
            )
    exit_if_stopped(received)
