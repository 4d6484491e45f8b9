"""The command group `overview sensor`: setup, firmware and profiles of sensors."""

from __future__ import annotations

from pathlib import Path

import click

from overview_dsp.cli.common import show
from overview_dsp.cli.control_learning import listen
from overview_dsp.cli.devices import BAUD
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable, write_file


@click.group(name="sensor", epilog="Example: overview sensor setup /dev/ttyACM0 -o mine.toml")
def command() -> None:
    """Set up a sensor for overview play --input serial:PORT,sensor=FILE.

    Or get the profile of a known sensor, or firmware for a board.
    """


@cli_command("sensor setup /dev/ttyACM0 -o mine.toml", group=command)
def setup(
    port: str,
    *,
    output: str = option(type=click.Path(dir_okay=False), required=True),
    baud: int = BAUD,
    timeout: float = option(type=click.FloatRange(0.1, 3600.0), default=60.0, metavar="S"),
    as_json: bool = JSON,
) -> None:
    """Write the profile of the sensor at PORT (axes, units, ends) from two twists.

    Lay the sensor face up and keep it still. Then turn it face down and back, twice. Turn a knob
    from one end to the other and back, twice.
    """
    from overview_dsp.devices.sensors.setup import Setup
    from overview_dsp.live.ports.serial import SerialPort

    require_writable(output)
    watched = Setup()

    def decode(messages: list[bytes], now_s: float) -> str | None:
        for data in messages:
            watched.feed(data, now_s)
        if watched.problem:
            raise InputError(watched.problem)
        return watched.toml() if watched.done else None

    opened = SerialPort(port.removeprefix("serial:"), baud)
    write_file(output, listen(opened, watched, decode, timeout))
    report = {"port": port.removeprefix("serial:"), "file": output}
    show(as_json, report, f"{Path(output)}: play it with --input serial:{port},sensor={output}")


@cli_command("sensor firmware imu -o sketches", group=command)
def firmware(
    name: str | None,
    *,
    output: str | None = option(type=click.Path(file_okay=False)),
    as_json: bool = JSON,
) -> None:
    """Copy the firmware NAME for a board; without NAME, list all firmware."""
    from overview_dsp.devices.sensors.firmware import copy_firmware, firmware_head, firmware_names

    if name is None:
        if output is not None:
            raise InputError(f"NAME is missing; must be {' or '.join(firmware_names())}")
        heads = {one: firmware_head(one) for one in firmware_names()}
        firsts = {one: " ".join(head.partition("\n\n")[0].split()) for one, head in heads.items()}
        show(as_json, heads, *(f"{one:12s} {first}" for one, first in firsts.items()))
        return
    head = firmware_head(name)
    to = None if output is None else str(copy_firmware(name, Path(output)))
    text = head if to is None else f"{head}\n\n{to}: flash this folder"
    show(as_json, {"name": name, "folder": to, "head": head}, text)


@cli_command("sensor profile simplefoc -o my-knob.toml", group=command)
def profile(
    name: str | None,
    *,
    output: str | None = option(type=click.Path(dir_okay=False)),
    as_json: bool = JSON,
) -> None:
    """Copy the sensor profile NAME, to adapt it; without NAME, list all profiles.

    A profile is for overview play --input serial:PORT,sensor=FILE.
    """
    from overview_dsp.devices.sensors.profile import LIBRARY, load_sensor

    if name is None:
        if output is not None:
            raise InputError(f"NAME is missing; must be {' or '.join(LIBRARY.bundled)}")
        about = {one: load_sensor(one).description for one in LIBRARY.bundled}
        show(as_json, about, *(f"{one:14s} {description}" for one, description in about.items()))
        return
    text = LIBRARY.path(name).read_text(encoding="utf-8")
    if output is not None:
        if Path(output).exists():
            raise InputError(f"{output} already exists; move it, or name another file (-o)")
        require_writable(output)
        write_file(output, text)
    message = text.rstrip() if output is None else f"{output}: play it with sensor={output}"
    show(as_json, {"name": name, "file": output, "text": text}, message)
