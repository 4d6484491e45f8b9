"""Names and syntax of a session's commands, which `commands` executes."""

from __future__ import annotations

from overview_dsp.files.toml import load_toml

FORMS: dict[str, str] = load_toml(__file__, "command_forms.toml")
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
