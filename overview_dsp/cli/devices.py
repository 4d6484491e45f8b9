"""The command `overview devices`."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import click

from overview_dsp.cli.common import print_json
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.output import DEVICE, SET, output_changes
from overview_dsp.errors import InputError, OverviewError

if TYPE_CHECKING:
    from collections.abc import Callable

    from overview_dsp.live.output.devices import OutputDevice

_T = TypeVar("_T")

BAUD = option(type=click.IntRange(300, 4_000_000), default=115_200)


@cli_command("devices --json", name="devices")
def command(
    *,
    as_json: bool = JSON,
    listen: float = option(type=click.FloatRange(0.0, 60.0), default=2.0, metavar="S"),
    baud: int = BAUD,
    serial: tuple[str, ...] = option(metavar="PORT"),
    device: str | None = DEVICE,
    settings: tuple[str, ...] = SET,
) -> None:
    """List audio outputs with their channels and latency, serial and MIDI ports, game pads.

    Each serial port is opened to detect its format, which restarts many boards. --set changes
    the settings of --device (or of the default output) first.
    """
    from overview_dsp.live.output.devices import devices
    from overview_dsp.live.output.portaudio_library import platform_hint
    from overview_dsp.live.ports.midi import midi_ports
    from overview_dsp.live.ports.pads import pads
    from overview_dsp.live.ports.serial import PortInfo, ports
    from overview_dsp.live.ports.serial import listen as listen_to_ports

    if settings or device is not None:
        _remember(device, settings)
    missing: dict[str, str] = {}

    def listed(name: str, search: Callable[[], list[_T]]) -> list[_T]:
        """Return the results of a search; after an error none, with the reason in `missing`."""
        try:
            return search()
        except OverviewError as error:
            missing[name] = str(error)
            return []

    found = listed("outputs", devices)
    found_ports = ports()
    known = {port.device for port in found_ports}
    found_ports += [PortInfo(port, "", "") for port in serial if port not in known]
    formats = listen_to_ports([port.device for port in found_ports], listen, baud) if listen else {}
    midi = listed("midi_ports", midi_ports)
    found_pads = listed("pads", pads)
    if as_json:
        print_json(
            {
                "outputs": [{**vars(output), "plays": _plays(output)} for output in found],
                "serial_ports": [
                    {**vars(port), "speaks": formats.get(port.device)} for port in found_ports
                ],
                "midi_ports": midi,
                "pads": [{"kind": pad.kind, "name": pad.name} for pad in found_pads],
                "missing": missing,
            }
        )
        return
    if not found:
        why = missing.get("outputs") or f"PortAudio finds none: {platform_hint('output')}"
        click.echo(f"no audio output: {why}; rendering to files works without one")
    for output in found:
        star = "*" if output.default else " "
        click.echo(
            f"{star}{output.index:>3}  {output.name} ({output.host}): {output.channels} channels, "
            f"{output.sample_rate:g} Hz, latency {output.latency_s * 1e3:.1f} ms"
        )
        if plays := _plays(output):
            click.echo(f"       {plays}")
    for port in found_ports:
        about = " ".join(word for word in (port.description, port.identity) if word)
        click.echo(f"  serial:{port.device} {about}".rstrip())
        if port.device in formats:
            click.echo(f"       {formats[port.device]}")
    if not found_ports:
        click.echo("no serial port with a device (tools/simulated_knob.py simulates one)")
    for name in midi:
        click.echo(f"  midi:{name}")
    if not midi:
        click.echo(f"no MIDI port: {missing.get('midi_ports', 'no controller is plugged in')}")
    for pad in found_pads:
        click.echo(f"  pad:{pad.kind} {pad.name}")
    if not found_pads:
        click.echo(f"no game pad: {missing.get('pads', 'none is plugged in or paired')}")


def _remember(device: str | None, texts: tuple[str, ...]) -> None:
    """Change the saved settings of a device, except its actuator; InputError."""
    from overview_dsp.live.output.devices import find_device
    from overview_dsp.live.output.portaudio_library import SILENT, device_named
    from overview_dsp.live.output.settings import resolve_output, save_settings

    if not texts:
        raise InputError("--device needs --set KEY=VALUE; add it")
    if device == SILENT:
        raise InputError(f"--device {device} has no settings; name an output")
    found = find_device(device_named(device))
    changes = output_changes(texts)
    resolved = resolve_output(found.full_name, **changes, actuator=None, channels=found.channels)
    save_settings(found.full_name, resolved.settings)


def _plays(output: OutputDevice) -> str | None:
    """Return the channels and actuator of an output if they aren't the default."""
    from overview_dsp.live.output.settings import OutputSettings, load_settings, remembered_actuator

    try:
        settings = load_settings(output.full_name, output.channels)
        actuator = remembered_actuator(output.full_name, output.channels)
    except OverviewError as error:
        return str(error)
    if actuator is None and settings.channels_text == OutputSettings().channels_text:
        return None
    return f"plays {settings.channels_text}" + (f", actuator {actuator}" if actuator else "")
