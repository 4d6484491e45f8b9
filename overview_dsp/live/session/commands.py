"""Commands of a session besides moving, asked for by keys, lines of text, OSC or the palette."""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Callable
from dataclasses import replace

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.live.inputs.feeds import expected_s, map_named
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.output.settings import channels_in
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.status import Status
from overview_dsp.signal.actuators.calibration import apply_calibration
from overview_dsp.signal.actuators.stage import warn_of_carrier


def poll(player: Player, source: Input | None = None) -> Status:
    """Poll the input, do the commands that were asked for, and poll the player.

    Return the player's status, with the messages of the input after its own.
    """
    if source is not None:
        source.poll(player.engine)
    while player.asked:
        do(player, *player.asked.popleft())
    status = player.poll()
    if source is None:
        return status
    return replace(status, messages=(*status.messages, *source.take_messages()))


def do(player: Player, name: str, *words: str) -> None:
    """Do one of `COMMANDS`; the user is shown what is wrong with it."""
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
    if _switched(on, player.takes.growing is not None):
        player.toggle_take()


def _replay(player: Player, on: str = "") -> None:
    if _switched(on, player.loop.playing):
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


def _device(player: Player, *name: str) -> None:
    device = " ".join(name) or None
    player.reopen(replace(player.output.opener, device=device, rescans=True))


def _block_size(player: Player, frames: str) -> None:
    size = int(_number(frames, "a block size"))
    player.reopen(replace(player.output.opener, block_size=size, rescans=True))


def _rate(player: Player, rate: str) -> None:
    player.reopen(sample_rate=_number(rate, "a sample rate"))


def _channels(player: Player, click: str, tactor: str) -> None:
    wanted = [{"channel": channels_in(one)} for one in (click, tactor)]
    player.reopen(settings=player.output.settings.changed(*wanted))


def _actuator(player: Player, name: str) -> None:
    driven = None if name == "none" else apply_calibration(name)
    if driven is not None:
        warn_of_carrier(driven, player.engine.preset.number("tactor.frequency_hz"))
    player.reopen(settings=replace(player.output.settings, actuator=driven))


def _gain(player: Player, signal: str, gain_db: str) -> None:
    change = {"gain_db": _number(gain_db, "a gain")}
    player.output.set(player.output.settings.changed(**{_signal(signal): change}))


def _mute(player: Player, signal: str, on: str = "") -> None:
    muted = getattr(player.output.settings, _signal(signal)).mute
    if _switched(on, muted):
        player.output.mute(signal, not muted)


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
