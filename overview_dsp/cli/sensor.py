"""`overview sensor`: what a sensor's numbers are, learned by turning it; firmware for boards."""

from __future__ import annotations

from pathlib import Path

import click

from overview_dsp.cli.common import show, write_text
from overview_dsp.cli.control_learning import listen
from overview_dsp.cli.devices import BAUD
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import require_writable


@click.group(name="sensor", epilog="Example: overview sensor setup /dev/ttyACM0 -o mine.toml")
def command() -> None:
    """Learn what a sensor sends, for `overview play --input serial:PORT,sensor=FILE`.

    Or get the file of a known sensor, or firmware for a board.
    """


@cli_command("sensor setup /dev/ttyACM0 -o mine.toml", group=command)
def setup(
    port: str,
    *,
    output: str = option(
        "The sensor's file that is written.", type=click.Path(dir_okay=False), required=True
    ),
    baud: int = BAUD,
    timeout: float = option(
        "Give up after S seconds.", type=click.FloatRange(0.1, 3600.0), default=60.0, metavar="S"
    ),
    as_json: bool = JSON,
) -> None:
    """Watch two twists of what is at PORT and write its file: axes, units, ends.

    Lay it still, face up, then turn it face down and back, twice; a knob from one end to the other
    and back.
    """
    from overview_dsp.devices.sensors.setup import Setup
    from overview_dsp.live.ports.serial import SerialPort

    require_writable(output)
    watched = Setup()

    def hear(came: list[bytes], now_s: float) -> str | None:
        for data in came:
            watched.feed(data, now_s)
        if watched.problem:
            raise InputError(watched.problem)
        return watched.toml() if watched.done else None

    def otherwise() -> str:
        return f"{watched.twists} of 2 twists were seen ({watched.problem or watched.instruction})"

    opened = SerialPort(port.removeprefix("serial:"), baud)
    write_text(output, listen(opened, lambda: watched.instruction, hear, timeout, otherwise))
    report = {"port": port.removeprefix("serial:"), "file": output}
    show(as_json, report, f"{Path(output)}: play it with --input serial:{port},sensor={output}")


@cli_command("sensor firmware imu -o sketches", group=command)
def firmware(
    name: str | None,
    *,
    output: str | None = option(
        "Folder in which NAME is made; left out: it is only described.",
        type=click.Path(file_okay=False),
    ),
    as_json: bool = JSON,
) -> None:
    """Get the firmware NAME, to flash on a board; without NAME, list what there is."""
    from overview_dsp.devices.sensors.firmware import copy_firmware, firmware_head, firmware_names

    if name is None:
        if output is not None:
            raise InputError(f"which one? There is {', '.join(firmware_names())}")
        heads = {one: firmware_head(one) for one in firmware_names()}
        lines = (f"{one:12s} {' '.join(head.split(chr(10) * 2)[0].split())}"
                 for one, head in heads.items())  # fmt: skip
        show(as_json, heads, "\n".join(lines))
        return
    head = firmware_head(name)
    to = None if output is None else str(copy_firmware(name, Path(output)))
    text = head if to is None else f"{head}\n\n{to}: flash this"
    show(as_json, {"name": name, "folder": to, "head": head}, text)


@cli_command("sensor profile simplefoc -o my-knob.toml", group=command)
def profile(
    name: str | None,
    *,
    output: str | None = option(
        "File that NAME is copied to; left out: it is printed.", type=click.Path(dir_okay=False)
    ),
    as_json: bool = JSON,
) -> None:
    """Get the sensor's file NAME, to make one's own of.

    It is for `overview play --input serial:PORT,sensor=FILE`.

    Without NAME, list what there is.
    """
    from overview_dsp.devices.sensors.profile import LIBRARY, load_sensor

    if name is None:
        if output is not None:
            raise InputError(f"which one? There is {', '.join(LIBRARY.bundled)}")
        about = {one: load_sensor(one).description for one in LIBRARY.bundled}
        show(as_json, about, "\n".join(f"{one:14s} {words}" for one, words in about.items()))
        return
    text = LIBRARY.path(name).read_text(encoding="utf-8")
    if output is not None:
        if Path(output).exists():
            raise InputError(f"{output}: already there; move it away or give another file (-o)")
        require_writable(output)
        write_text(output, text)
    words = text.rstrip() if output is None else f"{output}: play it with sensor={output}"
    show(as_json, {"name": name, "file": output, "text": text}, words)
