"""`overview sensor`: what a sensor's numbers are, learned by turning it."""

from __future__ import annotations

import time

import click

from overview_dsp.cli.common import show


@click.group(name="sensor", epilog="Example: overview sensor setup /dev/ttyACM0 -o mine.toml")
def command() -> None:
    """Learn what a sensor sends, for `overview play --sensor`."""


@command.command(name="setup", epilog="Example: overview sensor setup /dev/ttyACM0 -o mine.toml")
@click.argument("port")
@click.option("-o", "--output", "path", type=click.Path(dir_okay=False), required=True,
              help="The sensor's file that is written.")  # fmt: skip
@click.option("--baud", type=click.IntRange(300, 4_000_000), default=115_200, show_default=True,
              help="Speed of the port.")  # fmt: skip
@click.option("--seconds", type=click.FloatRange(0.1, 3600.0), default=60.0, show_default=True,
              help="Give up after so long.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def setup(port: str, path: str, baud: int, seconds: float, as_json: bool) -> None:
    """Watch two twists of what is at PORT and write its file: axes, units, ends.

    Lay it still, face up, then turn it face down and back, twice; a knob from one end to the other
    and back.
    """
    from pathlib import Path

    from overview_dsp.errors import InputError
    from overview_dsp.files.atomic import require_writable, whole_file
    from overview_dsp.live.serial_port import SerialPort
    from overview_dsp.sensors.setup import Setup

    require_writable(path)
    watched = Setup()
    asked = ""
    opened = SerialPort(port.removeprefix("serial:"), baud)
    try:
        until = time.monotonic() + seconds
        while not watched.done:
            now = time.monotonic()
            if now > until:
                raise InputError(
                    f"serial:{opened.device}: in {seconds:g} s {watched.twists} of 2 twists were "
                    f"seen ({watched.problem or watched.ask})"
                )
            data = opened.read()
            if data:
                watched.feed(data, now)
            if watched.problem:
                raise InputError(f"serial:{opened.device}: {watched.problem}")
            if watched.ask != asked:
                asked = watched.ask
                click.echo(f"serial:{opened.device}: {asked}", err=True)
    finally:
        opened.close()
    text = watched.toml()
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    report = {"port": opened.device, "file": path}
    show(as_json, report, f"{Path(path)}: play it with --input serial:{port} --sensor {path}")
