"""The option --input: parsing and opening of input sources."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from overview_dsp.cli.common import read_gesture
from overview_dsp.cli.options.declaring import option, require_none
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.validation import float_or_nan

if TYPE_CHECKING:
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.inputs.takes_and_lines import TextLineInput
    from overview_dsp.live.session.player import Player

PARTS: dict[str, tuple[str, ...]] = {
    "serial": ("sensor", "baud", "force"),
    **dict.fromkeys(("pad", "http", "post", "ble"), ("sensor",)),
    **dict.fromkeys(("osc", "midi"), ("map", "smooth")),
}
"""Allowed settings after the port, for each kind of device."""

MAX_SMOOTH_MS = 100.0

MAX_BAUD, MIN_BAUD = 4_000_000, 300

SILENT_BATCHES_S = 2.0  # longest silence of an app that posts batches, s

FORCE_BLOCK = 128
"""Default block size with a motor, frames: 375 torque updates per second at 48 kHz."""


@dataclass(frozen=True)
class Controls:
    """Options of inputs and of OSC output."""

    heading: ClassVar[str] = "Input"

    input: tuple[str, ...] = option(metavar="SOURCE")
    osc_out: str | None = option(metavar="[HOST:]PORT")
    replay: str | None = option(metavar="TAKE.csv[,loop]")
    remote: str | None = option(metavar="[HOST:PORT]", is_flag=False, flag_value="")

    def require_consistent(self, timeline: str | None, follow: str | None) -> None:
        """Check the options against each other; click.UsageError otherwise."""
        problems = {
            f"--remote {self.remote} is an address; name TIMELINE before it": (
                self.remote and timeline is None and follow is None
            ),
            f"--follow {follow} and --input - both read standard input; remove one": (
                "-" in self.input
                and follow is not None
                and (follow == "-" or follow.startswith(("-,", "pcm:")))
            ),
            "--replay doesn't apply to --follow; remove one": self.replay and follow is not None,
            "--replay and --input exclude each other; remove one": self.replay and self.input,
        }
        require_none(problems)


@dataclass
class Sources:
    """Checked sources of --input; `open` opens them, and sets `lines` if standard input is one."""

    openers: dict[str, Callable[[Player], Input]]
    force: bool = False
    lines: TextLineInput | None = None

    def open(self, player: Player, closing: Callable[[Callable[[], None]], Any]) -> Input | None:
        """Open the sources as one input; `closing` receives the close function of each."""
        from overview_dsp.live.inputs.input import CombinedInput
        from overview_dsp.live.inputs.takes_and_lines import TextLineInput

        inputs: dict[str, Input] = {}
        for name, open_one in self.openers.items():
            one = inputs[name] = open_one(player)
            closing(one.close)
            if isinstance(one, TextLineInput):
                self.lines = one
        if len(inputs) > 1:
            return CombinedInput(inputs)
        return next(iter(inputs.values()), None)


def parse_sources(sources: tuple[str, ...]) -> Sources:
    """Parse the sources of --input; nothing is opened.

    InputError: an unknown source or setting, or two sources of one kind.
    """
    openers: dict[str, Callable[[str, str, dict[str, str]], Callable[[Player], Input]]] = {
        "serial": _serial,
        "osc": _osc,
        "midi": _midi,
    }
    found = Sources({})
    for source in sources:
        kind, colon, rest = source.partition(":")
        opener: Callable[[Player], Input]
        if source == "-":
            name, opener = "lines", _open_lines
        elif colon and kind in PARTS:
            where, parts = _settings(source, kind, rest)
            if not where and kind != "pad":
                raise InputError(f"--input {source} names no port; overview devices lists them")
            # all sensors share one input of the engine
            name = "serial" if "sensor" in PARTS[kind] else kind
            opener = openers.get(kind, _named)(kind, where, parts)
            found.force = found.force or "force" in parts
        else:
            name, opener = "take", _take(source)
        if name in found.openers:
            raise InputError(f"--input {source}: a second source of this kind; remove one")
        found.openers[name] = opener
    if "take" in found.openers and len(found.openers) > 1:
        raise InputError("--input: a gesture or take must be the only source; remove the others")
    return found


def _settings(source: str, kind: str, rest: str) -> tuple[str, dict[str, str]]:
    """Split settings from the name of a port, which can contain commas."""
    parts: dict[str, str] = {}
    while (last := re.fullmatch(r"(.*?),(force|[a-z_]+=[^,]*)", rest)) is not None:
        rest, (key, equals, value) = last[1], last[2].partition("=")
        allowed = PARTS[kind]
        if key not in allowed or bool(equals) == (key == "force"):
            whose = [f"{one}:" for one, keys in PARTS.items() if key in keys]
            why = f"{key} applies to {', '.join(whose)}" if whose else f"unknown setting {key!r}"
            near = "" if whose else did_you_mean(key, allowed)
            raise InputError(f"--input {source}: {why}{near}; {kind}: allows {', '.join(allowed)}")
        parts.setdefault(key, value)
    return rest, parts


def _open_lines(player: Player) -> Input:
    from overview_dsp.live.inputs.takes_and_lines import TextLineInput

    return TextLineInput(sys.stdin, player.engine, player.queue_command)


def _take(source: str) -> Callable[[Player], Input]:
    from overview_dsp.live.inputs.takes_and_lines import TakeInput

    gesture = read_gesture(source)
    return lambda player: TakeInput(gesture)


def _serial(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.force_feedback.motor_loop import require_motor
    from overview_dsp.devices.sensors.profile import Sensor, load_sensor
    from overview_dsp.live.inputs.sensors import MotorInput, SensorInput

    baud = None
    if "baud" in parts:
        text = parts["baud"]
        baud = int(text) if text.isdecimal() else 0
        if not MIN_BAUD <= baud <= MAX_BAUD:
            raise InputError(
                f"--input {kind}:{where}: baud={text}; must be {MIN_BAUD} to {MAX_BAUD}"
            )
    profile = load_sensor(parts["sensor"]) if "sensor" in parts else Sensor()
    if "force" in parts:
        require_motor(profile)
        return lambda player: MotorInput(player.engine, where, profile, baud)
    return lambda player: SensorInput(player.engine, where, profile, baud)


def _named(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    """Return the opener of a game pad, a phone app or a Bluetooth sensor."""
    from overview_dsp.devices.sensors.profile import load_sensor
    from overview_dsp.live.inputs.sensors import SILENT_S, NamedInput
    from overview_dsp.live.ports.bluetooth import BlePort
    from overview_dsp.live.ports.pads import PadPort, find_pad
    from overview_dsp.live.ports.phones import PhyphoxPort, PostPort
    from overview_dsp.live.ports.port import Port

    ports: dict[str, tuple[Callable[[str], Port], str]] = {
        "pad": (PadPort, ""),
        "ble": (BlePort, "imu"),
        "post": (PostPort, "phone"),
        "http": (PhyphoxPort, "phone"),
    }
    open_port, default = ports[kind]
    default = default or find_pad(where).kind
    silent_s = SILENT_BATCHES_S if kind == "post" else SILENT_S
    if kind == "http":
        kind, where = "phyphox", f"http:{where}"
    profile = load_sensor(parts.get("sensor", default))
    return lambda player: NamedInput(player.engine, kind, where, profile, open_port, silent_s)


def _smooth_s(source: str, parts: dict[str, str]) -> float:
    """Return the delay that makes movements more even, s; 0: they apply in the next block."""
    text = parts.get("smooth", "0")
    smooth_ms = float_or_nan(text)
    if not 0.0 <= smooth_ms <= MAX_SMOOTH_MS:
        raise InputError(f"--input {source}: smooth={text}; must be 0 to {MAX_SMOOTH_MS:g} (ms)")
    return 1e-3 * smooth_ms


def _osc(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_map import load_osc_map
    from overview_dsp.devices.controllers.osc_messages import SILENT_S, OscReader
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.osc import OscPort, parse_address

    parse_address(where)
    smooth_s = _smooth_s(f"{kind}:{where}", parts)
    controls = load_osc_map(parts["map"]) if "map" in parts else ()
    open_port, make_reader = partial(OscPort, where), partial(OscReader, controls=controls)
    return lambda player: ControllerInput(
        player.engine, kind, open_port, make_reader, SILENT_S, player.queue_command, smooth_s
    )


def _midi(kind: str, where: str, parts: dict[str, str]) -> Callable[[Player], Input]:
    from overview_dsp.devices.controllers.control_map import DEFAULT, load_map
    from overview_dsp.devices.controllers.control_messages import require_parameters
    from overview_dsp.devices.controllers.midi_messages import MidiReader
    from overview_dsp.live.inputs.controllers import ControllerInput
    from overview_dsp.live.ports.midi import MidiPort

    controls = load_map(parts["map"]) if "map" in parts else DEFAULT
    smooth_s = _smooth_s(f"{kind}:{where}", parts)
    open_port, make_reader = partial(MidiPort, where), partial(MidiReader, controls)

    def opened(player: Player) -> Input:
        require_parameters(controls, player.engine.preset)
        return ControllerInput(player.engine, kind, open_port, make_reader, smooth_s=smooth_s)

    return opened
