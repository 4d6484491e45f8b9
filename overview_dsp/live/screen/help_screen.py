"""Texts over the screen: the keys, explained, and whatever else is to be read."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import ModalScreen
from textual.widgets import Static

HELP = """\
drag         the finger holds the disk and pulls it over the surface
click        a tap: everything up to that point, then let go
release      let go: the disk recoils

left right   move the finger (with shift, ten times as far)
Home End     touch the start, the end
space        let go; or tap, if nothing holds
Enter        tap where the finger was last
Escape       let go
[ ]          touch the previous, the next event
+ -  0       zoom about the disk; the whole
R            begin a take, end it
P            play the last take in a loop, or stop
1 2          the first, the second preset: from the loop's start
             on; pressed again: at once
c            change preset, window, gains, device, block size, rate,
             channels, actuator
m t          mute the clicks, the tactor
r            the address for a phone (with --remote)
q            quit

MARKS
▼ finger  ~ spring  ◉ disk: it sticks where friction is high

any key closes this"""


class TextScreen(ModalScreen[None]):
    """Closed by any key or click."""

    CSS = """
    TextScreen { align: center middle; }
    TextScreen Static { width: auto; height: auto; border: round $accent; padding: 0 1;
        background: black; color: white; }
    """
    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text = text

    def compose(self) -> ComposeResult:
        """The text."""
        yield Static(self._text, markup=False)

    def on_key(self) -> None:
        """Close."""
        self.dismiss()

    def on_click(self) -> None:
        """Close."""
        self.dismiss()
