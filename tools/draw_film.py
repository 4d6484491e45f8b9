"""Make the README's film and sound: a hand on the page and on the terminal, and the sound.

python tools/draw_film.py [--frames FOLDER]          needs playwright and a Chromium

Writes docs/pictures/film.gif and docs/sounds/world-cup-final.mp3. One movement (`PATH`) drives the
page of an exported folder and the terminal application, each in real time; every frame of the film
shows both at one moment of that movement. Run it on a machine with nothing else to do.
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import io
import os
import re
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.screen import PlayApp
from overview_dsp.live.screen.timeline_view import TimelineView
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.web.static_site import write_site
from tests.web.browser import launched, opened_driver
from tests.web.driving import until
from tests.web.exported import opened_host

ROOT = Path(__file__).parent.parent
FILM = ROOT / "docs" / "pictures" / "film.gif"
SOUND = ROOT / "docs" / "sounds" / "world-cup-final.mp3"
MATCH = "world-cup-final-2018"
LARGEST_FILM, LARGEST_SOUND = 2_000_000, 300_000  # bytes, as README readers load both at once

PATH = ((0.0, 0.02), (2.4, 0.70), (2.9, 0.62), (3.4, 0.70), (4.4, 0.95))
"""Seconds and positions of the hand; between them it speeds up and slows down as an arm does."""
RELEASE_S, END_S = 4.6, 7.4
RECOIL_S = 3.4  # of the sound, after the release
FRAMES_PER_SECOND = 12.5
PAGE = {"width": 390, "height": 780}
TERMINAL = (96, 30)
HEIGHT, WIDTH = 510, 1000
COLOURS = 48


def pointer_position(seconds: float) -> float | None:
    """Return the position at a time, or None after the release."""
    if seconds > RELEASE_S:
        return None
    times, positions = zip(*PATH, strict=True)
    index = min(int(np.searchsorted(times, seconds, side="right")), len(PATH) - 1)
    share = np.clip((seconds - times[index - 1]) / (times[index] - times[index - 1]), 0, 1)
    eased = 10 * share**3 - 15 * share**4 + 6 * share**5  # minimum jerk
    return float(positions[index - 1] + (positions[index] - positions[index - 1]) * eased)


# --- page -----------------------------------------------------------------------------------------


def page_frames(browser: Any, folder: Path) -> list[tuple[float, Image.Image]]:
    """Return pictures of the page with the seconds at which each was taken."""
    write_site(ov.load_timeline(MATCH), ov.load_preset("football"), folder)
    with opened_host(folder) as host:
        page = browser.new_context(viewport=PAGE, device_scale_factor=1).new_page()
        page.goto(host.url)
        until(page, "p.sound.node")
        box = page.locator("#canvas").bounding_box()
        left, right = page.evaluate(
            "[overview.picture.geometry.left, overview.picture.geometry.right]"
        )
        client = page.context.new_cdp_session(page)
        frames: list[tuple[float, bytes]] = []

        def keep(frame: dict[str, Any]) -> None:
            frames.append((frame["metadata"]["timestamp"], base64.b64decode(frame["data"])))
            client.send("Page.screencastFrameAck", {"sessionId": frame["sessionId"]})

        client.on("Page.screencastFrame", keep)
        client.send("Page.startScreencast", {"format": "png"})
        page.mouse.move(box["x"] + left + (right - left) * PATH[0][1], box["y"] + 120)
        page.mouse.down()
        began = time.time()
        touching = True
        while (now := time.time() - began) < END_S:
            position = pointer_position(now)
            if position is not None:
                page.mouse.move(box["x"] + left + (right - left) * position, box["y"] + 120)
            elif touching:
                page.mouse.up()
                touching = False
            page.wait_for_timeout(15)
        client.send("Page.stopScreencast")
        page.context.close()
    return [(at - began, Image.open(io.BytesIO(data)).convert("RGB")) for at, data in frames]


# --- terminal -------------------------------------------------------------------------------------


async def play(player: Player) -> list[tuple[float, str]]:
    """Return drawings (SVG) of the terminal with the seconds at which each was made."""
    app = PlayApp(player)
    frames = []
    async with app.run_test(size=TERMINAL) as pilot:
        await pilot.pause(0.5)
        column = app.query_one(TimelineView).column
        await pilot.mouse_down(TimelineView, offset=(column(PATH[0][1]), 6))
        began = time.monotonic()
        touching = True
        while (now := time.monotonic() - began) < END_S:
            position = pointer_position(now)
            if position is not None:
                await pilot.hover(TimelineView, offset=(column(position), 6))
            elif touching:
                await pilot.mouse_up(TimelineView, offset=(column(PATH[-1][1]), 6))
                touching = False
            await pilot.pause(0.02)
            if not frames or now - frames[-1][0] >= 0.5 / FRAMES_PER_SECOND:
                frames.append((now, app.export_screenshot(title=f"overview play {MATCH}")))
    return frames


def terminal_drawings() -> list[tuple[float, str]]:
    """Return drawings (SVG) of the terminal with the seconds at which each was made."""
    player = Player(
        ov.load_timeline(MATCH),
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 1024, settings),
        OutputSettings(),
        callback="python",
    )
    try:
        return asyncio.run(play(player))
    finally:
        player.close()


def terminal_frames(browser: Any, drawn: Sequence[tuple[float, str]]) -> list[Image.Image]:
    """Return pictures of the terminal, one per moment of the film."""
    page = browser.new_page()
    frames = []
    for drawing in nearest_of(drawn):
        # no font is fetched from elsewhere
        plain = re.sub(r"@font-face\s*\{.*?\}", "", drawing, flags=re.DOTALL)
        page.set_content(
            f'<body style="margin:0">{plain.replace("Fira Code", "DejaVu Sans Mono")}</body>'
        )
        picture = page.locator("svg").screenshot()
        frames.append(Image.open(io.BytesIO(picture)).convert("RGB"))
    page.close()
    return frames


# --- film -----------------------------------------------------------------------------------------


def nearest_of(frames: Sequence[tuple[float, Any]]) -> list[Any]:
    """Return one frame per moment of the film, the last that was taken by then."""
    times = [at for at, _ in frames]
    moments = np.arange(0, END_S, 1 / FRAMES_PER_SECOND)
    indices = np.maximum(np.searchsorted(times, moments, side="right") - 1, 0)
    return [frames[index][1] for index in indices]


def composed(page: Image.Image, terminal: Image.Image, touching: bool) -> Image.Image:
    """Return one frame of the film: the page on the left, the terminal on the right."""
    frame = Image.new("RGB", (WIDTH, HEIGHT), "#ffffff")
    margin, top = 8, 26
    height = HEIGHT - top - margin
    page = page.resize((round(page.width * height / page.height), height), Image.LANCZOS)
    room = WIDTH - page.width - 3 * margin
    terminal = terminal.resize(
        (room, round(terminal.height * room / terminal.width)), Image.LANCZOS
    )
    frame.paste(page, (margin, top))
    frame.paste(terminal, (2 * margin + page.width, top))
    draw, font = ImageDraw.Draw(frame), ImageFont.load_default(14)
    draw.text((margin, 5), "a phone's page", "#333333", font)
    draw.text((2 * margin + page.width, 5), "the terminal", "#333333", font)
    state = "the hand moves" if touching else "released: the disk springs back"
    draw.text((WIDTH - margin, 5), state, "#b03a00" if touching else "#333333", font, anchor="ra")
    return frame


def write_film(frames: Sequence[Image.Image], out: Path) -> None:
    """Write an animated picture with one palette for all frames."""
    sample = Image.new("RGB", (WIDTH, HEIGHT * 4))
    for row, index in enumerate(np.linspace(0, len(frames) - 1, 4).astype(int)):
        sample.paste(frames[index], (0, HEIGHT * row))
    palette = sample.quantize(COLOURS, dither=Image.Dither.NONE)
    drawn = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    drawn[0].save(
        out,
        save_all=True,
        append_images=drawn[1:],
        duration=round(1000 / FRAMES_PER_SECOND),
        loop=0,
        optimize=True,
    )


def write_sound(out: Path) -> None:
    """Write the same movement as it is heard (left) and felt (right)."""
    times = np.arange(0, RELEASE_S, 1 / 200)
    angles = np.pi * np.array([pointer_position(seconds) for seconds in times])
    gesture = ov.Gesture(times, angles, times < times[-1], duration_s=RELEASE_S)
    result = ov.render(ov.load_timeline(MATCH), ov.load_preset("football"), gesture, tail=RECOIL_S)
    result.save(out)


def main() -> None:
    """Write film and sound, and print their sizes."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=Path, help="folder for single frames (PNG), to look at")
    options = parser.parse_args()
    os.environ.update(COLORTERM="truecolor", COLORFGBG="15;0", LC_ALL="C.UTF-8")
    drawings = terminal_drawings()
    with (
        tempfile.TemporaryDirectory() as folder,
        opened_driver() as driver,
        launched(driver) as browser,
    ):
        pages = nearest_of(page_frames(browser, Path(folder) / "site"))
        terminals = terminal_frames(browser, drawings)
    frames = [
        composed(page, terminal, pointer_position(index / FRAMES_PER_SECOND) is not None)
        for index, (page, terminal) in enumerate(zip(pages, terminals, strict=True))
    ]
    if options.frames:
        options.frames.mkdir(parents=True, exist_ok=True)
        for index, frame in enumerate(frames):
            frame.save(options.frames / f"{index:03}.png")
    FILM.parent.mkdir(exist_ok=True)
    SOUND.parent.mkdir(exist_ok=True)
    write_film(frames, FILM)
    write_sound(SOUND)
    for path, largest in ((FILM, LARGEST_FILM), (SOUND, LARGEST_SOUND)):
        size = path.stat().st_size
        print(f"{path.relative_to(ROOT)}: {size / 1e3:.0f} kB (at most {largest / 1e3:.0f})")
        if size > largest:
            raise SystemExit(1)


if __name__ == "__main__":
    main()
