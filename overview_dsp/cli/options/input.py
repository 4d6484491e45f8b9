"""`--input`: which sources of control events play, with their parts, and how they are opened."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from overview_dsp.cli.common import read_gesture
from overview_dsp.cli.options.declaring import option
from overview_dsp.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from overview_dsp.live.inputs.controllers import Reader
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.inputs.lines import LineInput
    from overview_dsp.live.session.player import Player

PARTS: dict[str, tuple[str, ...]] = {
    "serial": ("sensor", "baud", "force"),
    "pad": ("sensor",),
    "http": ("sensor",),
    "post": ("sensor",),
    "ble": ("sensor",),
    "osc": ("map",),
    "midi": ("map",),
}
"""Each kind of device, and the parts that may follow its port."""

MAX_BAUD, MIN_BAUD = 4_000_000, 300

BATCHES_S = 2.0
"""An app that posts what it measured in batches is silent between them."""

SILENT_OSC_S = 5.0
"""UDP knows no connection: a sender that touches and is silent for so long has released."""

FORCE_BLOCK = 128
"""Frames: the torque changes with each block, 375 times a second at 48 kHz."""


@dataclass(frozen=True)
class Controls:
    """Options of inputs and of what is sent back to them."""

    heading: ClassVar[str] = "Input"

    input: tuple[str, ...] = option(
        "Input; may be repeated. serial:PORT[,sensor=NAME][,baud=N][,force]: a sensor (imu, roll, "
        "encoder, potentiometer, simplefoc, a TOML file; else detected), force drives its motor. "
        "pad:, a DualSense or Joy-Con; http://PHONE:8080 (phyphox); post:PORT (Sensor Logger); "
        "ble:NAME; each with [,sensor=NAME]. osc:[HOST:]PORT[,map=NAME]: gyrosc, zigsim, touchosc "
        "or a TOML file. midi:NAME[,map=FILE.toml]. -: lines of standard input, theta2 (rad) and "
        "touching (0 or 1). Or a gesture or take.",
        metavar="SOURCE",
    )
    osc_out: str | None = option("Send cursor, torque and events as OSC.", metavar="[HOST:]PORT")


@dataclass
class Sources:
    """Inputs that `--input` names, checked; `opened` opens them.

    Attributes
    ----------
    lines : LineInput or None
        Standard input, once it is opened.
    """

    openers: dict[str, Callable[[Player], Input]]
    force: bool = False
    lines: LineInput | None = None

    @property
    def by_lines(self) -> bool:
        """Whether standard input is one of them."""
        return "lines" in self.openers

    def opened(self, player: Player, closing: Callable[[Callable[[], None]], Any]) -> Input | None:
        """Open the sources as one input; `closing` receives what closes each. Errors as they."""
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


def parse_sources(sources: tuple[str, ...]) -> Sources:
    """Return the sources that --input names; nothing is opened.

    Raises
    ------
    InputError
        Not a source, two of one kind, or a part that this kind doesn't have.
    """
    found = Sources({})
    for source in sources:
        kind, colon, rest = source.partition(":")
        opener: Callable[[Player], Input]
        if source == "-":
            name, opener = "lines", _open_lines
        elif colon and kind in PARTS:
            where, parts = _parts(source, kind, rest)
            if not where and kind != "pad":
                raise InputError(f"--input {source} names no port; `overview devices` lists them")
            # what is turned in the hand is one source: one of them
            name = "serial" if "sensor" in PARTS[kind] else kind
            opener = {"serial": _serial, "osc": _osc, "midi": _midi}.get(kind, _named)(
                kind, where, parts
            )
            found.force = found.force or "force" in parts
        else:
            name, opener = "take", _take(source)
        if name in found.openers:
            raise InputError(f"--input {source}: one of a kind; there is one before it")
        found.openers[name] = opener
    if "take" in found.openers and len(found.openers) > 1:
        raise InputError("--input: a gesture or take plays alone; leave it or the others out")
    return found


def _parts(source: str, kind: str, rest: str) -> tuple[str, dict[str, str]]:
    """Split the parts from a port's name, which may hold commas itself."""
    parts: dict[str, str] = {}
    while (last := re.fullmatch(r"(.*?),(force|[a-z_]+=[^,]*)", rest)) is not None:
        rest, (key, equals, value) = last[1], last[2].partition("=")
        takes = PARTS[kind]
        if key not in takes or bool(equals) == (key == "force"):
            whose = [f"{one}:" for one, keys in PARTS.items() if key in keys]
            why = f"{key} is for {', '.join(whose)}" if whose else f"unknown part {key!r}"
            near = "" if whose else did_you_mean(key, takes)
            raise InputError(f"--input {source}: {why}{near}; {kind}: takes {', '.join(takes)}")
        parts.setdefault(key, value)
    return rest, parts


def _open_lines(player: Player) -> Input:
    from overview_dsp.live.inputs.lines import LineInput

    return LineInput(sys.stdin, player.engine, player.ask)


def _take(source: str) -> Callable[[Player], Input]:
    from overview_dsp.live.inputs.lines import TakeInput

    gesture = read_gesture(source)
    return lambda player: TakeInput(gesture)


def _serial(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.force_feedback.motor_loop import require_motor
    from overview_dsp.devices.sensors.profile import Sensor, load_sensor
    from overview_dsp.live.inputs.motors import MotorInput
    from overview_dsp.live.inputs.sensors import SensorInput

    baud = None
    if "baud" in parts:
        text = parts["baud"]
        baud = int(text) if text.isdecimal() else 0
        if not MIN_BAUD <= baud <= MAX_BAUD:
            raise InputError(
                f"--input {kind}:{where}: baud={text} is out of range; it is {MIN_BAUD} to "
                f"{MAX_BAUD}"
            )
    profile = load_sensor(parts["sensor"]) if "sensor" in parts else Sensor()
    if "force" in parts:
        require_motor(profile)
        return lambda player: MotorInput(player.engine, where, profile, baud)
    return lambda player: SensorInput(player.engine, where, profile, baud)


def _named(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    """Return what opens a pad, a phone's app or a radio."""
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
    profile = load_sensor(parts.get("sensor", usual))
    return lambda player: NamedInput(player.engine, kind, where, profile, open_port, silent_s)


def _osc(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_map import load_osc_map
    from overview_dsp.devices.controllers.control_messages import Counters
    from overview_dsp.devices.controllers.osc_messages import OscReader
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.osc import OscPort, parse_address

    parse_address(where)
    controls = load_osc_map(parts["map"]) if "map" in parts else ()

    def reader(counters: Counters) -> Reader:
        return OscReader(counters, controls)

    return lambda player: ControllerInput(
        player.engine, kind, lambda: OscPort(where), reader, SILENT_OSC_S, player.ask
    )


def _midi(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_map import DEFAULT, load_map
    from overview_dsp.devices.controllers.control_messages import Counters
    from overview_dsp.devices.controllers.midi_messages import MidiReader
    from overview_dsp.devices.controllers.parameters import require_parameters
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.midi import MidiPort

    controls = load_map(parts["map"]) if "map" in parts else DEFAULT

    def reader(counters: Counters) -> Reader:
        return MidiReader(controls, counters)

    def opened(player: Player) -> Input:
        require_parameters(controls, player.engine.preset)
        return ControllerInput(player.engine, kind, lambda: MidiPort(where), reader)

    return opened
