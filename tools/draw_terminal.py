"""Draw the terminal application into docs/pictures/play.svg: a finger on the way to a goal.

python tools/draw_terminal.py [OUT.svg]

Notes in italics beside the parts of the screen explain them to a newcomer.
"""

from __future__ import annotations

import asyncio
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
WANTED = ("&#160;0&#160;late", "◉~~~~")
"""In a picture of a machine that has time, and of a disk that sticks behind the finger."""

COLUMN, ROW, LEFT, TOP = 12.2, 24.4, 9.0, 66.0
"""Of the picture: a character's width, a line's height, where the first line stands."""

NOTES = (
    (84.0, 1.9, "below: a lane for each team"),
    (44.3, 6.9, "each bar is an event:"),
    (44.3, 7.9, "the higher, the harder"),
    (44.3, 8.9, "to pull the disk over it"),
    (84.0, 7.9, "grey between them:"),
    (84.0, 8.9, "the crowd"),
    (13.5, 16.0, "the disk sticks on a goal, on a spring to your finger ahead of it  →"),
    (84.0, 16.0, "←  your mouse or arrow keys"),
    (9.0, 20.0, "what was felt and heard in the last seconds  →"),
    (75.0, 21.0, "←  now: the pull, and the moment"),
    (46.0, 22.0, "←  for the ear"),
    (46.0, 23.0, "←  for the finger: a vibration"),
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
        if all(words in drawn for words in WANTED):
            break
    else:
        raise SystemExit(f"no picture of {ATTEMPTS} has {WANTED}; use a machine with nothing to do")
    # the viewer's own monospaced font: a picture fetches nothing from elsewhere
    drawn = re.sub(r"@font-face\s*\{.*?\}", "", drawn, flags=re.DOTALL)
    out.write_text(noted(drawn.replace("Fira Code", "DejaVu Sans Mono")), encoding="utf-8")
    print(out)


if __name__ == "__main__":
    main()
