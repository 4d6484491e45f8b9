"""Names and syntax of a session's commands, which `commands` executes; this imports nothing."""

from __future__ import annotations

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
    "layout": "layout whole|so-far",
    "expected-duration": "expected-duration LENGTH",
    "missed": "missed [SINCE]",
    "blind": "blind a|b|x|is-a|is-b",
}
KEYS = {
    "R": ("record",), "P": ("replay",), "N": ("missed",),
    "1": ("preset", "1"), "2": ("preset", "2"),
}  # fmt: skip
"""Commands that are one key on the screen."""


def parse_command(line: str) -> tuple[str, ...] | None:
    """Return the command of a line, split into words; None if the line isn't a command."""
    words = line.split()
    if line.strip().upper() in KEYS:
        return KEYS[line.strip().upper()]
    return tuple(words) if words and words[0] in FORMS else None
