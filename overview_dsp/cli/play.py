"""`overview play`: a timeline under a live hand."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import part_of, window_options
from overview_dsp.cli.live_session import (
    exit_if_stopped,
    live_options,
    note,
    opened_player,
    print_lines,
)
from overview_dsp.cli.server_options import (
    open_server,
    refuse_server_options,
    require_server,
    server_options,
)
from overview_dsp.cli.timeline_options import (
    open_timeline,
    preset_for,
    preset_option,
    timeline_options,
)

if TYPE_CHECKING:
    from overview_dsp.live.player import Input
    from overview_dsp.sensors.profile import Sensor


@click.command(
    name="play",
    epilog="Example: overview play world-cup-final-2018 --preset football --record take.csv",
)
@click.argument("timeline")
@preset_option
@click.option("--input", "source", help="A gesture or take to play; serial:PORT, a sensor; or - "
              "for lines of standard input: theta2 (rad) and touching (0 or 1).")  # fmt: skip
@click.option("--sensor", help="What is on the serial port: a name (imu, roll, encoder, "
              "potentiometer) or a TOML file; told by content if left out.")  # fmt: skip
@click.option("--baud", type=click.IntRange(300, 4_000_000), help="Of the serial port, instead of "
              "the sensor file's (115200).")  # fmt: skip
@window_options
@click.option("--seconds", type=float, help="Stop after so long.")
@click.option(
    "--headless", "--json", "headless", is_flag=True, help="Lines of JSON, as without a terminal."
)
@click.option("--remote", is_flag=True, help="Also let a phone or a browser hold the disk.")
@server_options
@timeline_options
@live_options
def command(
    timeline: str,
    preset: str | None,
    source: str | None,
    sensor: str | None,
    baud: int | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    seconds: float | None,
    headless: bool,
    remote: bool,
    server: dict[str, Any],
    load: dict[str, Any],
    **live: Any,
) -> None:
    """Play TIMELINE live: drag, tap and let go with the mouse or the keys, and hear and feel it.

    Without a terminal (or with --headless) it prints a line of JSON a second and a summary. The
    preset's file is watched: save it, feel it. Channels, gains, mutes, delays, ceilings and the
    actuator are remembered for each output device.
    """
    from overview_dsp.gestures import parse_gesture
    from overview_dsp.live.inputs import LineInput, TakeInput
    from overview_dsp.live.sensor_input import SensorInput

    if remote:
        require_server()
    else:
        refuse_server_options()
    data = open_timeline(timeline, load)
    part = part_of(data, window, zoom_to)
    if part is not None and window:
        data, part = data.window(*part), None
    port = _port(source, sensor, baud)
    plain = source is not None and source != "-" and port is None
    gesture = parse_gesture(source) if plain and source is not None else None
    profile = _profile(sensor)
    name = preset_for(data, preset)
    with ExitStack() as stack:
        player, received = stack.enter_context(opened_player(data, part, name, live))
        hand: Input | None = None
        lines: LineInput | None = None
        invitation = ""
        if port is not None:
            hand = SensorInput(player.engine, port, profile, baud)
        elif gesture is not None:
            hand = TakeInput(gesture)
        elif source == "-":
            hand = lines = LineInput(sys.stdin, player.engine)
        if hand is not None:
            stack.callback(hand.close)
        if remote:
            from overview_dsp.web.data import data_routes
            from overview_dsp.web.session import HostSession

            hand = session = HostSession(player, hand)
            routes = data_routes(data, name, audio="host", first=part)
            invitation = stack.enter_context(open_server(server, session, routes)).text
        if headless or source == "-" or not (sys.stdin.isatty() and sys.stdout.isatty()):
            print_lines(player, hand, received, seconds)
        else:
            from overview_dsp.tui import run

            run(player, hand, lambda: bool(received), invitation)
        if lines is not None and lines.refused:
            note(
                f"{lines.refused} lines weren't `theta2 touching`; the first: {lines.first_refused}"
            )
    exit_if_stopped(received)


SERIAL = "serial:"


def _port(source: str | None, sensor: str | None, baud: int | None) -> str | None:
    """The serial port that is the input, or None; InputError for options without one."""
    from overview_dsp.errors import InputError

    if source is not None and source.startswith(SERIAL):
        if source == SERIAL:
            raise InputError("--input serial: names no port; `overview devices` lists them")
        return source.removeprefix(SERIAL)
    for option, value in (("--sensor", sensor), ("--baud", baud)):
        if value is not None:
            raise InputError(f"{option} is for --input serial:PORT, and that isn't given")
    return None


def _profile(sensor: str | None) -> Sensor:
    from overview_dsp.sensors.profile import Sensor
    from overview_dsp.sensors.profile_file import load_sensor

    return Sensor() if sensor is None else load_sensor(sensor)
