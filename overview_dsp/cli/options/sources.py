"""`--input`: which control sources play, and how they are opened."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from overview_dsp.cli.common import read_gesture

if TYPE_CHECKING:
    from overview_dsp.live.inputs.controllers import Reader
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.inputs.lines import LineInput
    from overview_dsp.live.session.player import Player

DEVICES = ("serial", "osc", "midi", "pad", "http", "post", "ble")
SENSORS = {"serial", "pad", "http", "post", "ble"}
"""Of those, what is turned in the hand: one of them, as they are one source."""

BATCHES_S = 2.0
"""An app that posts what it measured in batches is silent between them."""

SILENT_OSC_S = 5.0
"""UDP knows no connection: who holds on by it and says nothing for so long has let go."""

FORCE_BLOCK = 128
"""Frames: the torque changes with each block, 375 times a second at 48 kHz."""

_OF = {
    "sensor": "serial:PORT",
    "baud": "serial:PORT",
    "midi_map": "midi:NAME",
    "osc_map": "osc:PORT",
    "force": "serial:PORT",
}


def input_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of control sources, for `parse_sources`."""
    options = (
        click.option("--input", "sources", multiple=True, help="serial:PORT, a sensor; pad:, "
                     "a DualSense or Joy-Con; http://PHONE:8080 (phyphox); post:PORT (Sensor "
                     "Logger); ble:NAME; osc:PORT or osc:HOST:PORT; midi:NAME; - for lines of "
                     "standard input: theta2 (rad) and touching (0 or 1); several together. Or a "
                     "gesture or take to play."),
        click.option("--sensor", help="What is on the serial port: a name (imu, roll, encoder, "
                     "potentiometer, simplefoc) or a TOML file; left out: detected by content."),
        click.option("--baud", type=click.IntRange(300, 4_000_000), help="Of the serial port, "
                     "instead of the sensor file's (115200)."),
        click.option("--force", is_flag=True, help="Brake the motor on the serial port as the "
                     "surface brakes the disk (docs/guide/force.md); blocks are of 128 frames if "
                     "no size is given."),
        click.option("--midi-map", metavar="FILE.toml", help="What the controls of a MIDI "
                     "controller do; `overview midi learn` writes one."),
        click.option("--osc-map", metavar="NAME", help="What other messages do: gyrosc, zigsim, "
                     "touchosc or a TOML file; `overview osc learn` writes one."),
        click.option("--osc-out", metavar="[HOST:]PORT", help="Send cursor, torque and events."),
    )  # fmt: skip
    for option in reversed(options):
        function = option(function)
    return function


@dataclass
class Sources:
    """What `--input` asks for, checked; `opened` opens it.

    Attributes
    ----------
    lines : LineInput or None
        Standard input, once it is opened.
    """

    openers: dict[str, Callable[[Player], Input]]
    lines: LineInput | None = None

    @property
    def by_lines(self) -> bool:
        """Whether standard input is one of them."""
        return "lines" in self.openers

    def opened(self, player: Player, closing: Callable[[Callable[[], None]], Any]) -> Input | None:
        """The sources, begun, as one; `closing` receives what closes each. InputError as they."""
        from overview_dsp.live.inputs.input import SeveralInputs
        from overview_dsp.live.inputs.lines import LineInput

        inputs: dict[str, Input] = {}
        for name, open_one in self.openers.items():
            one = inputs[name] = open_one(player)
            closing(one.close)
            if isinstance(one, LineInput):
                self.lines = one
        if len(inputs) > 1:
            return SeveralInputs(inputs)
        return next(iter(inputs.values()), None)


def parse_sources(
    sources: tuple[str, ...],
    sensor: str | None,
    baud: int | None,
    midi_map: str | None,
    osc_map: str | None,
    force: bool = False,
) -> Sources:
    """The sources that the options name; nothing is opened.

    Raises
    ------
    InputError
        Not a source, two of one kind, or an option of one that isn't there.
    """
    from overview_dsp.errors import InputError

    openers: dict[str, Callable[[Player], Input]] = {}
    for source in sources:
        kind, colon, where = source.partition(":")
        open_one: Callable[[Player], Input]
        if source == "-":
            name, open_one = "lines", _open_lines
        elif colon and kind in DEVICES:
            if not where and kind != "pad":
                raise InputError(f"--input {source} names no port; `overview devices` lists them")
            name = "serial" if kind in SENSORS else kind
            if kind == "osc":
                open_one = _osc(where, osc_map)
            elif kind == "midi":
                open_one = _midi(where, midi_map)
            elif kind == "serial":
                open_one = _serial(where, sensor, baud, force)
            else:
                open_one = _named(kind, where, sensor)
        else:
            name, open_one = "take", _take(source)
        if name in openers:
            raise InputError(f"--input {source}: one of a kind; there is one before it")
        openers[name] = open_one
    if "take" in openers and len(openers) > 1:
        raise InputError("--input: a gesture or take plays alone; leave it or the others out")
    options = {"sensor": sensor, "baud": baud, "midi_map": midi_map, "osc_map": osc_map,
               "force": force or None}  # fmt: skip
    for option, value in options.items():
        if value is not None and _OF[option].partition(":")[0] not in openers:
            raise InputError(
                f"--{option.replace('_', '-')} is for --input {_OF[option]}, and that isn't given"
            )
    return Sources(openers)


def _open_lines(player: Player) -> Input:
    from overview_dsp.live.inputs.lines import LineInput

    return LineInput(sys.stdin, player.engine, player.ask)


def _take(source: str) -> Callable[[Player], Input]:
    from overview_dsp.live.inputs.lines import TakeInput

    gesture = read_gesture(source)
    return lambda player: TakeInput(gesture)


def _serial(
    where: str, sensor: str | None, baud: int | None, force: bool
) -> Callable[[Player], Input]:
    from overview_dsp.devices.force_feedback.loop import require_motor
    from overview_dsp.devices.sensors.profile import Sensor, load_sensor
    from overview_dsp.live.inputs.motors import MotorInput
    from overview_dsp.live.inputs.sensors import SensorInput

    profile = Sensor() if sensor is None else load_sensor(sensor)
    if force:
        require_motor(profile)
        return lambda player: MotorInput(player.engine, where, profile, baud)
    return lambda player: SensorInput(player.engine, where, profile, baud)


def _named(kind: str, where: str, sensor: str | None) -> Callable[[Player], Input]:
    """A pad, a phone's app or a radio."""
    from overview_dsp.devices.sensors.profile import load_sensor
    from overview_dsp.live.inputs.sensors import SILENT_S, NamedInput
    from overview_dsp.live.ports.port import Port

    silent_s, usual = SILENT_S, "phone"
    open_port: Callable[[str], Port]
    if kind == "pad":
        from overview_dsp.live.ports.pads import PadPort as open_port  # noqa: N813
        from overview_dsp.live.ports.pads import find_pad

        usual = find_pad(where).kind
    elif kind == "ble":
        from overview_dsp.live.ports.bluetooth import BlePort as open_port  # noqa: N813

        usual = "imu"
    elif kind == "post":
        from overview_dsp.live.ports.phones import PostPort as open_port  # noqa: N813

        silent_s = BATCHES_S
    else:
        from overview_dsp.live.ports.phones import PhyphoxPort as open_port  # noqa: N813

        kind, where = "phyphox", f"http:{where}"
    profile = load_sensor(usual if sensor is None else sensor)
    return lambda player: NamedInput(player.engine, kind, where, profile, open_port, silent_s)


def _osc(where: str, osc_map: str | None) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_messages import Counters
    from overview_dsp.devices.controllers.osc_map import load_osc_map
    from overview_dsp.devices.controllers.osc_messages import OscReader
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.osc import OscPort, parse_address

    parse_address(where)
    controls = () if osc_map is None else load_osc_map(osc_map)

    def reader(counters: Counters) -> Reader:
        return OscReader(counters, controls)

    return lambda player: ControllerInput(
        player.engine, "osc", lambda: OscPort(where), reader, SILENT_OSC_S, player.ask
    )


def _midi(where: str, midi_map: str | None) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_messages import Counters
    from overview_dsp.devices.controllers.midi_map import DEFAULT, load_map
    from overview_dsp.devices.controllers.midi_messages import MidiReader
    from overview_dsp.devices.controllers.parameters import require_parameters
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.midi import MidiPort

    controls = DEFAULT if midi_map is None else load_map(midi_map)

    def reader(counters: Counters) -> Reader:
        return MidiReader(controls, counters)

    def opened(player: Player) -> Input:
        require_parameters(controls, player.engine.preset)
        return ControllerInput(player.engine, "midi", lambda: MidiPort(where), reader)

    return opened


def choose_force_block(live: dict[str, Any]) -> None:
    """Blocks that renew a motor's torque often enough, unless the command line names a size."""
    from click.core import ParameterSource

    given = click.get_current_context().get_parameter_source("block_size")
    if given is ParameterSource.DEFAULT:
        live["block_size"] = FORCE_BLOCK
