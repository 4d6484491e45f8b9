"""Commands of a session: all but movements, given by keys, lines, OSC or the command palette."""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Callable
from dataclasses import replace

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline.time_expressions import window_of
from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.live.inputs.feeds import parse_duration, parse_layout
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.output.settings import parse_channels
from overview_dsp.live.session.command_forms import FORMS
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.signal.actuators.calibration import apply_calibration
from overview_dsp.signal.actuators.stage import warn_of_carrier
from overview_dsp.validation import float_or_nan


def poll(player: Player, source: Input | None = None) -> Status:
    """Poll the input, execute the queued commands, and poll the player.

    Return the player's status. Its messages are those of the player, then those of the input.
    """
    if source is not None:
        source.poll(player.engine)
    while player.queued_commands:
        execute(player, *player.queued_commands.popleft())
    status = player.poll()
    if source is None:
        return status
    return replace(status, messages=(*status.messages, *source.take_messages()))


def execute(player: Player, name: str, *arguments: str) -> None:
    """Execute one of `COMMANDS`; an error is shown to the user."""
    command = " ".join((name, *arguments))
    if name not in COMMANDS:
        player.say(f"{command}: unknown command; must be one of {', '.join(FORMS.values())}")
        return
    try:
        inspect.signature(COMMANDS[name]).bind(player, *arguments)
    except TypeError:
        player.say(f"{command}: wrong number of arguments; must be {FORMS[name]}")
        return
    with warnings.catch_warnings(record=True, action="always") as caught:
        try:
            COMMANDS[name](player, *arguments)
        except OverviewError as error:
            player.say(f"{command}: {error}")
    for one in caught:
        if issubclass(one.category, OverviewWarning):
            player.say(str(one.message))


def _is_toggle(word: str, is_on: bool) -> bool:
    """Return whether the word of a command (0, 1 or none) changes a state that is `is_on`."""
    if word not in ("", "0", "1"):
        raise InputError(f"{word!r} must be 0, 1 or left out")
    return word == "" or (word == "1") != is_on


def _record(player: Player, on: str = "") -> None:
    if _is_toggle(on, player.takes.recording_path is not None):
        player.toggle_take()


def _replay(player: Player, on: str = "") -> None:
    if _is_toggle(on, player.loop.playing):
        player.toggle_replay()


def _preset(player: Player, name: str) -> None:
    if name in ("1", "2"):
        player.choose_preset(int(name) - 1)
    else:
        player.use_preset(name)


def _window(player: Player, start: str, end: str) -> None:
    player.show(*window_of(player.timeline, start, end))


def _number(word: str, quantity: str) -> float:
    value = float_or_nan(word)
    if not math.isfinite(value):
        raise InputError(f"{quantity} {word!r} must be a number")
    return value


def _device(player: Player, *name: str) -> None:
    device = " ".join(name) or None
    player.reopen(replace(player.output.opener, device=device, rescans=True))


def _block_size(player: Player, frames: str) -> None:
    size = int(_number(frames, "block size"))
    player.reopen(replace(player.output.opener, block_size=size, rescans=True))


def _rate(player: Player, rate: str) -> None:
    player.reopen(sample_rate=_number(rate, "sample rate"))


def _channels(player: Player, click: str, tactor: str) -> None:
    changes = [{"channel": parse_channels(one)} for one in (click, tactor)]
    player.reopen(settings=player.output.settings.changed(*changes))


def _actuator(player: Player, name: str) -> None:
    actuator = None if name == "none" else apply_calibration(name)
    if actuator is not None:
        warn_of_carrier(actuator, player.engine.preset.number("tactor.frequency_hz"))
    player.reopen(settings=replace(player.output.settings, actuator=actuator))


def _gain(player: Player, signal: str, gain_db: str) -> None:
    change = {"gain_db": _number(gain_db, "gain")}
    player.output.set(player.output.settings.changed(**{_signal(signal): change}))
    player.say(f"{signal.replace('click', 'clicks')} {change['gain_db']:g} dB")


def _mute(player: Player, signal: str, on: str = "") -> None:
    settings = player.output.settings
    muted = getattr(settings, _signal(signal)).mute
    if _is_toggle(on, muted):
        player.output.set(settings.changed(**{signal: {"mute": not muted}}))
        player.say(f"{signal.replace('click', 'clicks')} {'on' if muted else 'muted'}")


def _signal(word: str) -> str:
    if word not in ("click", "tactor"):
        raise InputError(f"{word!r} must be click or tactor")
    return word


def _live(player: Player) -> LiveTimeline:
    if player.live_updates is None:
        raise InputError("this timeline is complete; this command needs a live one (--follow)")
    return player.live_updates.live


def _layout(player: Player, *name: str) -> None:
    _live(player).layout = parse_layout(" ".join(name))
    player.say(f"layout {_live(player).layout}")


def _expected_duration(player: Player, length: str) -> None:
    _live(player).expected_duration_s = parse_duration(length)
    player.say(f"expected duration {length}")


def _missed(player: Player, minute: str = "") -> None:
    _live(player)
    assert player.missed_events is not None
    player.missed_events.visit(parse_duration(minute) if minute else None)


def _mark(player: Player, *name: str) -> None:
    player.marks.set(" ".join(name))


def _unmark(player: Player) -> None:
    player.marks.undo()


def _name_mark(player: Player, word: str, *more: str) -> None:
    player.marks.rename(" ".join((word, *more)))


def _blind(player: Player, word: str) -> None:
    if player.blind is None:
        raise InputError("this session has no blind comparison; start it with --compare --blind")
    player.blind.run(word)


COMMANDS: dict[str, Callable[..., None]] = {
    name: globals()[f"_{name.replace('-', '_')}"] for name in FORMS
}
"""Functions of this module, by the names of their commands."""
