"""Draw the terminal application into docs/pictures/play.svg: a finger on the way to a goal.

python tools/draw_terminal.py [OUT.svg]

Notes in italics beside the parts of the screen explain them to a newcomer.
"""

from __future__ import annotations

import asyncio
import os
import re
import sys
from pathlib import Path

import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.screen import PlayApp
from overview_dsp.live.screen.timeline_view import TimelineView
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch

OUT = Path(__file__).parent.parent / "docs" / "pictures" / "play.svg"
SIZE = (110, 30)
WAY = range(5, 70, 2)
AHEAD = 12
ATTEMPTS = 20
WANTED = "╱╲╱╲"
"""In a picture of a disk that sticks behind the finger: its spring."""

COLUMN, ROW, LEFT, TOP = 12.2, 24.4, 9.0, 66.0
"""Of the picture: a character's width, a line's height, where the first line stands."""

NOTES = (
    (60.0, 1.1, "←  the value, the moment and the event under your finger"),
    (84.0, 4.0, "below: a lane for each team"),
    (47.5, 9.0, "light: behind the disk"),
    (82.0, 11.0, "grey: the crowd, ahead of the disk"),
    (84.0, 21.9, "←  finger: mouse or arrow keys"),
    (96.0, 27.0, "←  last seconds"),
)
"""Column, line and words."""


def noted(drawn: str) -> str:
    """A picture with the notes."""
    texts = "".join(
        f'<text x="{LEFT + COLUMN * column:.1f}" y="{TOP + ROW * (line - 0.08):.1f}" '
        'fill="#ffd75f" font-family="DejaVu Sans, sans-serif" font-style="italic" '
        f'font-size="18px">{words}</text>\n'
        for column, line, words in NOTES
    )
    return drawn.replace("</svg>", f"{texts}</svg>")


async def draw(player: Player) -> str:
    app = PlayApp(player)
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause(0.5)
        await pilot.mouse_down(TimelineView, offset=(WAY[0], 6))
        for column in WAY:
            await pilot.hover(TimelineView, offset=(column, 6))
            await pilot.pause(0.02)
        # a jerk: the spring is drawn out while the disk sticks on the goal
        await pilot.hover(TimelineView, offset=(WAY[-1] + AHEAD, 6))
        await pilot.pause(0.04)
        return app.export_screenshot(title="overview play world-cup-final-2018")


def main() -> None:
    os.environ.update(COLORTERM="truecolor", COLORFGBG="15;0", LC_ALL="C.UTF-8")
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else OUT
    for _ in range(ATTEMPTS):
        player = Player(
            ov.load_timeline("world-cup-final-2018"),
            PresetWatch("football"),
            lambda engine, settings: NullStream(engine, 1024, settings),
            OutputSettings(),
            callback="python",
        )
        try:
            drawn = asyncio.run(draw(player))
        finally:
            player.close()
        if WANTED in drawn and "were&#160;late" not in drawn:
            break
    else:
        raise SystemExit(f"no picture of {ATTEMPTS} has {WANTED}; use a machine with nothing to do")
    # the viewer's own monospaced font: a picture fetches nothing from elsewhere
    drawn = re.sub(r"@font-face\s*\{.*?\}", "", drawn, flags=re.DOTALL)
    out.write_text(noted(drawn.replace("Fira Code", "DejaVu Sans Mono")), encoding="utf-8")
    print(out)


if __name__ == "__main__":
    main()
