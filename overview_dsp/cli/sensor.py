"""`overview sensor`: what a sensor's numbers are, learned by turning it; firmware for boards."""

from __future__ import annotations

import time

import click

from overview_dsp.cli.common import show


@click.group(name="sensor", epilog="Example: overview sensor setup /dev/ttyACM0 -o mine.toml")
def command() -> None:
    """Learn what a sensor sends, for `overview play --sensor`; get its file, or firmware."""


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

    from overview_dsp.devices.sensors.setup import Setup
    from overview_dsp.errors import InputError
    from overview_dsp.files.atomic import require_writable, whole_file
    from overview_dsp.live.ports.port import WAIT_S
    from overview_dsp.live.ports.serial import SerialPort

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
                    f"{opened.name}: in {seconds:g} s {watched.twists} of 2 twists were "
                    f"seen ({watched.problem or watched.ask})"
                )
            for data in opened.receive(WAIT_S):
                watched.feed(data, now)
            if watched.problem:
                raise InputError(f"{opened.name}: {watched.problem}")
            if watched.ask != asked:
                asked = watched.ask
                click.echo(f"{opened.name}: {asked}", err=True)
    finally:
        opened.close()
    text = watched.toml()
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    report = {"port": port.removeprefix("serial:"), "file": path}
    show(as_json, report, f"{Path(path)}: play it with --input serial:{port} --sensor {path}")


@command.command(name="firmware", epilog="Example: overview sensor firmware imu -o sketches")
@click.argument("name", required=False)
@click.option("-o", "--output", "folder", type=click.Path(file_okay=False),
              help="The folder in which NAME is made; left out: it is only described.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def firmware(name: str | None, folder: str | None, as_json: bool) -> None:
    """Get the firmware NAME, to flash on a board; without NAME, list what there is."""
    from pathlib import Path

    from overview_dsp.devices.sensors.firmware import copy_firmware, firmware_head, firmware_names
    from overview_dsp.errors import InputError

    if name is None:
        if folder is not None:
            raise InputError(f"which one? There is {', '.join(firmware_names())}")
        heads = {one: firmware_head(one) for one in firmware_names()}
        lines = (f"{one:12s} {' '.join(head.split(chr(10) * 2)[0].split())}"
                 for one, head in heads.items())  # fmt: skip
        show(as_json, heads, "\n".join(lines))
        return
    head = firmware_head(name)
    to = None if folder is None else str(copy_firmware(name, Path(folder)))
    text = head if to is None else f"{head}\n\n{to}: flash this"
    show(as_json, {"name": name, "folder": to, "head": head}, text)


@command.command(
    name="profile", epilog="Example: overview sensor profile simplefoc -o my-knob.toml"
)
@click.argument("name", required=False)
@click.option("-o", "--output", "path", type=click.Path(dir_okay=False),
              help="The file that NAME is copied to; left out: it is printed.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def profile(name: str | None, path: str | None, as_json: bool) -> None:
    """Get the sensor's file NAME, to make one's own of, for `overview play --sensor`.

    Without NAME, list what there is.
    """
    from pathlib import Path

    from overview_dsp.devices.sensors.profile import LIBRARY, load_sensor
    from overview_dsp.errors import InputError
    from overview_dsp.files.atomic import require_writable, whole_file

    if name is None:
        if path is not None:
            raise InputError(f"which one? There is {', '.join(LIBRARY.bundled)}")
        about = {one: load_sensor(one).description for one in LIBRARY.bundled}
        show(as_json, about, "\n".join(f"{one:14s} {words}" for one, words in about.items()))
        return
    text = LIBRARY.path(name).read_text(encoding="utf-8")
    if path is not None:
        if Path(path).exists():
            raise InputError(f"{path}: already there; move it away or give another file (-o)")
        require_writable(path)
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    words = text.rstrip() if path is None else f"{path}: play it with --sensor {path}"
    show(as_json, {"name": name, "file": path, "text": text}, words)
