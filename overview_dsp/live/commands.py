"""What a hand, a line of standard input or an OSC message may ask of a session, besides moving.

`record [0|1]`, `replay [0|1]`, `preset 1|2|NAME`, `window START END` (s).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from overview_dsp.errors import InputError, OverviewError

if TYPE_CHECKING:
    from overview_dsp.live.player import Player


def do(player: Player, name: str, *words: str) -> None:
    """Do one of `COMMANDS`; what is wrong with it is told to the person."""
    try:
        COMMANDS[name](player, *words)
    except TypeError:
        player.say(f"{' '.join((name, *words))}: not so many words; see {FORMS[name]}")
    except OverviewError as error:
        player.say(f"{' '.join((name, *words))}: {error}")


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


COMMANDS: dict[str, Callable[..., None]] = {
    "record": _record,
    "replay": _replay,
    "preset": _preset,
    "window": _window,
}
FORMS = {
    "record": "record [0|1]",
    "replay": "replay [0|1]",
    "preset": "preset 1|2|NAME",
    "window": "window START END",
}
