"""What a hand, a line of standard input or an OSC message may ask of a session, besides moving.

`FORMS` lists them.
"""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.live.inputs.feeds import expected_s, map_named
from overview_dsp.live.output.settings import channels_in
from overview_dsp.live.output.stream_opener import Outputs
from overview_dsp.signal.actuators.calibration import calibrated_actuator
from overview_dsp.signal.actuators.stage import warn_of_carrier

if TYPE_CHECKING:
    from overview_dsp.live.session.player import Player


def do(player: Player, name: str, *words: str) -> None:
    """Do one of `COMMANDS`; what is wrong with it is told to the person."""
    asked = " ".join((name, *words))
    if name not in COMMANDS:
        player.say(f"{asked}: no such command; there are {', '.join(FORMS.values())}")
        return
    try:
        inspect.signature(COMMANDS[name]).bind(player, *words)
    except TypeError:
        player.say(f"{asked}: it is {FORMS[name]}")
        return
    with warnings.catch_warnings(record=True) as noted:
        warnings.simplefilter("always")
        try:
            COMMANDS[name](player, *words)
        except OverviewError as error:
            player.say(f"{asked}: {error}")
    for one in noted:
        if issubclass(one.category, OverviewWarning):
            player.say(str(one.message))


def _switched(word: str, now: bool) -> bool:
    """Whether a command without a word, or with 0 or 1, changes what is on `now`."""
    if word not in ("", "0", "1"):
        raise InputError("it takes 0 or 1, or nothing")
    return word == "" or (word == "1") != now


def _record(player: Player, on: str = "") -> None:
    if _switched(on, player.recording):
        player.toggle_take()


def _replay(player: Player, on: str = "") -> None:
    if _switched(on, player.replaying):
        player.toggle_replay()


def _preset(player: Player, name: str) -> None:
    if name in ("1", "2"):
        player.choose_preset(int(name) - 1)
    else:
        player.use_preset(name)


def _window(player: Player, start: str, end: str) -> None:
    try:
        part = float(start), float(end)
    except ValueError:
        raise InputError("a window is two numbers, s") from None
    player.show(*part)


def _number(word: str, what: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{what} is a number")
    return value


def _outputs(player: Player) -> Outputs:
    if not isinstance(player.outputs, Outputs):
        raise OverviewError("this session's output can't be changed")
    return player.outputs


def _device(player: Player, *name: str) -> None:
    player.reopen(_outputs(player).with_device(" ".join(name) or None))


def _block_size(player: Player, frames: str) -> None:
    player.reopen(_outputs(player).with_block_size(int(_number(frames, "a block size"))))


def _rate(player: Player, rate: str) -> None:
    player.reopen(sample_rate=_number(rate, "a sample rate"))


def _channels(player: Player, click: str, tactor: str) -> None:
    wanted = [{"channel": channels_in(one)} for one in (click, tactor)]
    player.reopen(settings=player.settings.changed(*wanted))


def _actuator(player: Player, name: str) -> None:
    driven = None if name == "none" else calibrated_actuator(name)
    if driven is not None:
        warn_of_carrier(driven, player.preset.number("tactor.frequency_hz"))
    player.reopen(settings=replace(player.settings, actuator=driven))


def _gain(player: Player, signal: str, gain_db: str) -> None:
    change = {"gain_db": _number(gain_db, "a gain")}
    player.set_output(player.settings.changed(**{_signal(signal): change}))


def _mute(player: Player, signal: str, on: str = "") -> None:
    muted = getattr(player.settings, _signal(signal)).mute
    if _switched(on, muted):
        player.set_output(player.settings.changed(**{signal: {"mute": not muted}}))


def _signal(word: str) -> str:
    if word not in ("click", "tactor"):
        raise InputError("it is click or tactor")
    return word


def _live(player: Player) -> LiveTimeline:
    if player.growing is None:
        raise InputError("this timeline is finished; --follow follows one that grows")
    return player.growing.live


def _map(player: Player, *name: str) -> None:
    _live(player).map = map_named(" ".join(name))


def _expect(player: Player, length: str) -> None:
    _live(player).expect_s = expected_s(length)


COMMANDS: dict[str, Callable[..., None]] = {
    "record": _record,
    "replay": _replay,
    "preset": _preset,
    "window": _window,
    "device": _device,
    "block-size": _block_size,
    "rate": _rate,
    "channels": _channels,
    "actuator": _actuator,
    "gain": _gain,
    "mute": _mute,
    "map": _map,
    "expect": _expect,
}
FORMS = {
    "record": "record [0|1]",
    "replay": "replay [0|1]",
    "preset": "preset 1|2|NAME",
    "window": "window START END",
    "device": "device NAME|NUMBER|none",
    "block-size": "block-size FRAMES",
    "rate": "rate HZ",
    "channels": "channels CLICK TACTOR",
    "actuator": "actuator NAME|none",
    "gain": "gain click|tactor DB",
    "mute": "mute click|tactor [0|1]",
    "map": "map whole|so-far",
    "expect": "expect LENGTH",
}
