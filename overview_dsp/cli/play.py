"""`overview play`: a timeline under a live hand."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.actuator_option import actuator_option
from overview_dsp.cli.common import announce_compile, part_of, window_options
from overview_dsp.cli.output_options import SILENT, device_named, output_options, output_settings
from overview_dsp.cli.timeline_options import (
    open_timeline,
    preset_for,
    preset_option,
    timeline_options,
)

if TYPE_CHECKING:
    from overview_dsp.engine import Engine
    from overview_dsp.live.output_settings import OutputSettings
    from overview_dsp.live.player import Stream
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
@click.option("--device", help="Output: a name or number of `overview devices`, or none.")
@click.option("--block-size", default=256, show_default=True, help="Frames, 0 = the device's own.")
@click.option("--sample-rate", type=float, help="Hz; the device's own if left out.")
@click.option("--callback", type=click.Choice(["native", "python"]), default="native",
              show_default=True, help="What PortAudio calls.")  # fmt: skip
@click.option("--record", metavar="TAKE.csv", help="Keep what was played, to the bit.")
@window_options
@click.option("--seed", default=0, show_default=True, help="Of the surface's grain.")
@click.option("--seconds", type=float, help="Stop after so long.")
@click.option(
    "--headless", "--json", "headless", is_flag=True, help="Lines of JSON, as without a terminal."
)
@timeline_options
@actuator_option
@output_options
def command(
    timeline: str,
    preset: str | None,
    source: str | None,
    sensor: str | None,
    baud: int | None,
    device: str | None,
    block_size: int,
    sample_rate: float | None,
    callback: str,
    record: str | None,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    seed: int,
    seconds: float | None,
    headless: bool,
    load: dict[str, Any],
    actuator: str | None,
    **signals: Any,
) -> None:
    """Play TIMELINE live: drag, tap and let go with the mouse or the keys, and hear and feel it.

    Without a terminal (or with --headless) it prints a line of JSON a second and a summary. The
    preset's file is watched: save it, feel it. Channels, gains, mutes, delays, ceilings and the
    actuator are remembered for each output device.
    """
    from overview_dsp.actuators.stage import warn_of_carrier
    from overview_dsp.errors import InputError
    from overview_dsp.files import require_writable
    from overview_dsp.gestures import parse_gesture
    from overview_dsp.live.inputs import LineInput, TakeInput
    from overview_dsp.live.output_settings import save_settings
    from overview_dsp.live.player import Input, Player
    from overview_dsp.live.preset_watch import PresetWatch
    from overview_dsp.live.sensor_input import SensorInput

    if block_size < 0 or block_size > MAX_BLOCK:
        raise InputError(f"block size {block_size}; it is 1 to {MAX_BLOCK} frames, or 0")
    if record is not None:
        require_writable(record)
    data = open_timeline(timeline, load)
    part = part_of(data, window, zoom_to)
    if part is not None and window:
        data = data.window(*part)
    watch = PresetWatch(preset_for(data, preset))
    port = _port(source, sensor, baud)
    plain = source is not None and source != "-" and port is None
    gesture = parse_gesture(source) if plain and source is not None else None
    profile = _profile(sensor)
    name, rate = _device(device, sample_rate)
    chosen = output_settings(None if device == SILENT else name, signals, actuator)
    settings = chosen.settings
    if settings.actuator is not None:
        warn_of_carrier(settings.actuator, watch.preset.number("tactor.frequency_hz"))
    native = callback == "native" and device != SILENT
    announce_compile("_callback" if native else "finish_block")
    player = Player(
        data,
        watch,
        _opener(device, block_size, callback),
        settings,
        sample_rate=rate,
        max_block_size=MAX_BLOCK,
        callback="native" if native else "python",
        record=record,
        seed=seed,
    )
    if part is not None and not window:
        player.show(*part)
    hand: Input | None = None
    with _signals() as received:
        try:
            if port is not None:
                hand = SensorInput(player.engine, port, profile, baud)
            elif gesture is not None:
                hand = TakeInput(gesture)
            elif source == "-":
                hand = LineInput(sys.stdin, player.engine)
            lines = headless or source == "-" or not (sys.stdin.isatty() and sys.stdout.isatty())
            if lines:
                _print_lines(player, hand, received, seconds)
            else:
                from overview_dsp.tui import run

                run(player, hand, stopped=lambda: bool(received))
        finally:
            if hand is not None:
                hand.close()
            player.close()
            if device != SILENT and chosen.differ(player.settings):
                save_settings(name, player.settings)
    if record is not None:
        click.echo(f"{record}: the take, to the bit", err=True)
    if received:
        click.echo(f"stopped by {signal.Signals(received[0]).name}", err=True)
        sys.exit(128 + received[0])


MAX_BLOCK = 8192
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


def _device(device: str | None, sample_rate: float | None) -> tuple[str, float]:
    """The device's full name and the rate to play at."""
    if device == SILENT:
        return SILENT, sample_rate or 48_000.0
    from overview_dsp.live.portaudio import find_output

    found = find_output(device_named(device))
    return f"{found.name} ({found.host})", sample_rate or found.sample_rate


def _opener(
    device: str | None, block_size: int, callback: Any
) -> Callable[[Engine, OutputSettings], Stream]:
    first = True

    def open_stream(engine: Engine, settings: OutputSettings) -> Stream:
        nonlocal first
        if device == SILENT:
            from overview_dsp.live.silent import SilentStream

            return SilentStream(engine, block_size or 256, settings)
        from overview_dsp.live.portaudio import OutputStream, rescan

        if not first:
            rescan()
        first = False
        return OutputStream(engine, device_named(device), block_size, settings, callback)

    return open_stream


@contextmanager
def _signals() -> Iterator[list[int]]:
    """The signals that ask for an end, collected instead of obeyed."""
    received: list[int] = []
    names = ("SIGINT", "SIGTERM", "SIGHUP")
    wanted = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = {
        number: signal.signal(number, lambda got, _: received.append(got)) for number in wanted
    }
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _print_lines(player: Any, hand: Any, received: list[int], seconds: float | None) -> None:
    from overview_dsp.live.headless import run

    def note(message: str) -> None:
        click.echo(f"note: {message}", err=True)

    for report in run(player, hand, lambda: bool(received), note, seconds):
        print(json.dumps(report), flush=True)
    refused = getattr(hand, "refused", 0)
    if refused:
        note(f"{refused} lines weren't `theta2 touching`; the first: {hand.first_refused}")
