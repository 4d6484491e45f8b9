"""The keys, explained."""

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
m t          mute the clicks, the tactor
q            quit

▼ finger  ~ spring  ◉ disk: it sticks where friction is high

any key closes this"""


class HelpScreen(ModalScreen[None]):
    """Closed by any key or click."""

    CSS = """
    HelpScreen { align: center middle; }
    HelpScreen Static { width: auto; height: auto; border: round $accent; padding: 0 1;
        background: $surface; }
    """
    BINDINGS: ClassVar[list[BindingType]] = []

    def compose(self) -> ComposeResult:
        """The text."""
        yield Static(HELP, markup=False)

    def on_key(self) -> None:
        """Close."""
        self.dismiss()

    def on_click(self) -> None:
        """Close."""
        self.dismiss()
