"""Draw the sheet of the page's pictures for the documentation: `python tools/draw_page.py`.

The script needs playwright, a Chromium and Pillow. It writes docs/pictures/page.png: six timelines
(rows) in windows of six sizes and in both colour modes, each size in another state of the page. The
last row has all states. All data but the match are made up here. Look at each picture.

    python tools/draw_page.py --pictures FOLDER    also writes each picture, in its full size
"""

from __future__ import annotations

import argparse
import contextlib
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import overview_dsp as ov
from overview_dsp.web.static_site import write_site
from tests.web.browser import launched, opened_driver
from tests.web.driving import at, until
from tests.web.exported import opened_host
from tests.web.layouts import settled

SHEET = Path(__file__).parent.parent / "docs" / "pictures" / "page.png"
LARGEST = 400_000  # bytes
SIZES = {
    (320, 568): "first visit",
    (390, 844): "touched",
    (568, 320): "playing",
    (844, 390): "zoomed",
    (768, 1024): "released",
    (1440, 900): "touched",
}
"""Sizes of the window, each with the state that its pictures show."""
STATES = (
    "first visit", "touched", "playing", "released", "zoomed", "in progress", "events", "more",
    "offline", "error",
)  # fmt: skip
PHONE = (390, 844)
MODES = ("light", "dark")
HEIGHT, GAP = 210, 6
BETWEEN = "#8a8f94"
COLOURS = 160
DAY_S, MINUTE_S = 86_400.0, 60.0


def series(
    value: np.ndarray[Any, Any], start: str, title: str, unit: str, folder: Path
) -> ov.Timeline:
    """Return daily values as their reader gives them, with events of its rules; NaN is a gap."""
    first = datetime.fromisoformat(start)
    rows = [
        f"{first + timedelta(days=day):%Y-%m-%d},{one:.2f}"
        for day, one in enumerate(value)
        if not np.isnan(one)
    ]
    file = folder / "table.csv"
    file.write_text("\n".join([f"date,{title} ({unit})", *rows]))
    return replace(ov.load_timeline(file), title=title)


def timelines(folder: Path) -> dict[str, tuple[ov.Timeline, str]]:
    """Return the six timelines, each with its preset."""
    random = np.random.default_rng(5)
    days = np.arange(3200)
    growth = np.exp(np.cumsum(random.normal(9e-4, 0.017, len(days))))
    season = -np.cos(2 * np.pi * (days[:1461] - 20) / 365.25)
    walk = 60 + np.cumsum(random.normal(0, 1, len(days)))
    walk[900:1100] = np.nan
    beats = np.cumsum(60 / (76 + 9 * np.sin(np.arange(760) / 55) + random.normal(0, 1.5, 760)))
    rates = 60 / np.diff(beats, prepend=beats[0] - 0.8)
    early = set(random.choice(760, 7, replace=False).tolist())
    heart = tuple(
        ov.Event(float(time), "premature_atrial" if i in early else "beat")
        for i, time in enumerate(beats)
    )
    visits = np.sort(np.concatenate([
        random.normal(8.5 * 3600, 2400, 4200), random.normal(17.5 * 3600, 4500, 5200),
        random.uniform(0, DAY_S, 600),
    ]).clip(0, DAY_S - 1))  # fmt: skip
    doors = tuple(
        ov.Event(float(time), ("north", "south", "lift")[i % 7 % 3], str(i))
        for i, time in enumerate(visits)
    )
    return {
        "match": (ov.load_timeline("world-cup-final-2018"), "football"),
        "share": (
            series(8 * growth, "2010-01-04", "Orchard, share price", "dollars", folder),
            "stocks",
        ),
        "weather": (
            series(
                12 + 9 * season + random.normal(0, 2.6, 1461),
                "2012-01-01", "Harbour, highest temperature", "°C", folder,
            ),
            "weather",
        ),
        "heart": (
            ov.Timeline(
                "Heartbeat, ten minutes on the stairs", float(beats[-1]) + 1, heart,
                ov.Intensity(beats, rates, "beats/min"),
            ),
            "heart",
        ),
        "gap": (series(walk, "2000-03-01", "River level at the mill", "cm", folder), "series"),
        "many": (ov.Timeline("Ten thousand visits in a day", DAY_S, doors), "plain"),
    }  # fmt: skip


def running(match: ov.Timeline) -> ov.Timeline:
    """Return a match of which 64 minutes are known."""
    until_s = 64 * MINUTE_S
    events = tuple(one for one in match.events if one.time_s <= until_s)
    title = "France 3-1 Croatia, World Cup final, live"
    curve = match.intensity
    assert curve is not None
    known = np.asarray(curve.time_s) <= until_s
    time_s, value = np.asarray(curve.time_s)[known], np.asarray(curve.value)[known]
    intensity = ov.Intensity(time_s, value, curve.unit)
    return replace(match, title=title, events=events, intensity=intensity, known_until_s=until_s)


def drag(page: Any, position: float) -> None:
    """Touch the disk at its start, and move it in small steps."""
    page.mouse.move(*at(page, 0.02))
    page.mouse.down()
    for share in np.linspace(0.02, position, 14):
        page.mouse.move(*at(page, float(share)))
        page.wait_for_timeout(16)
    page.wait_for_timeout(700)


def bring_into(page: Any, state: str) -> None:
    """Bring a page of the first visit into a state."""
    if state == "touched":
        drag(page, 0.62)
    elif state == "released":
        drag(page, 0.55)
        page.mouse.up()
        page.wait_for_timeout(120)
    elif state == "playing":
        page.click("#run")
        page.wait_for_timeout(4500)
    elif state == "zoomed":
        drag(page, 0.7)
        page.evaluate("overview.navigation.zoom(1)")
        until(page, "p.view.zoom === 1 && p.picture.view === p.view")
        page.wait_for_timeout(500)
    elif state in ("events", "more"):
        page.click("#list" if state == "events" else "#settings")
        page.wait_for_timeout(300)


@contextlib.contextmanager
def opened(browser: Any, url: str, size: tuple[int, int], mode: str, state: str) -> Iterator[Any]:
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=mode)
    page = context.new_page()
    if state == "error":
        page.route("**/data/timeline.json", lambda route: route.abort())
        page.goto(url)
        page.get_by_role("button", name="Try again").wait_for()
    else:
        page.goto(url)
        until(page, "p.view && p.sound.node && (!p.info.series || p.view.points)")
        if state == "offline":
            page.evaluate("navigator.serviceWorker.ready.then(() => true)")
            page.wait_for_timeout(1500)
            context.set_offline(True)
            page.reload()
            until(page, "p.view && p.sound.node")
        settled(page)
        bring_into(page, state)
    yield page
    context.close()


def picture(browser: Any, url: str, file: Path, *state: Any) -> Image.Image:
    """Return a picture of the page, and write it into a file."""
    with opened(browser, url, *state) as page:
        page.screenshot(path=str(file))
    return Image.open(file).convert("RGB")


def rows_of(browser: Any, folder: Path, pictures: Path) -> list[list[Image.Image]]:
    """Return the rows of the sheet."""
    rows = []
    drawn = timelines(folder)
    for name, (timeline, preset) in drawn.items():
        write_site(timeline, ov.load_preset(preset), folder / name, levels=1)
        with opened_host(folder / name) as host:
            row = []
            for mode in MODES:
                for size, state in SIZES.items():
                    file = pictures / f"{name}-{size[0]}-{mode}.png"
                    row.append(picture(browser, host.url, file, size, mode, state))
            rows.append(row)
    match, preset = drawn["match"]
    write_site(running(match), ov.load_preset(preset), folder / "running", levels=1)
    states = []
    with opened_host(folder / "match") as host, opened_host(folder / "running") as live:
        for mode in MODES:
            for state in STATES:
                url = live.url if state == "in progress" else host.url
                file = pictures / f"{state.replace(' ', '-')}-{mode}.png"
                states.append(picture(browser, url, file, PHONE, mode, state))
    return [*rows, states]


def sheet_of(rows: list[list[Image.Image]]) -> Image.Image:
    """Return the pictures as one: those of one row have one height."""
    smaller = []
    tallest = max(height for _, height in SIZES)
    for row in rows[:-1]:
        scale = HEIGHT / tallest
        smaller.append([one.resize((round(one.width * scale), round(one.height * scale)),
                                   Image.Resampling.LANCZOS) for one in row])  # fmt: skip
    width = max(sum(one.width + GAP for one in row) + GAP for row in smaller)
    last = rows[-1]
    share = (width - GAP) / len(last) - GAP
    scale = share / PHONE[0]
    smaller.append([one.resize((round(share), round(one.height * scale)),
                               Image.Resampling.LANCZOS) for one in last])  # fmt: skip
    heights = [max(one.height for one in row) for row in smaller]
    sheet = Image.new("RGB", (width, sum(heights) + GAP * (len(heights) + 1)), BETWEEN)
    y = GAP
    for row, height in zip(smaller, heights, strict=True):
        x = GAP
        for one in row:
            sheet.paste(one, (x, y))
            x += one.width + GAP
        y += height + GAP
    return sheet


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pictures", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, opened_driver() as driver:
        folder = Path(name)
        pictures = arguments.pictures or folder / "pictures"
        pictures.mkdir(parents=True, exist_ok=True)
        with launched(driver, "--autoplay-policy=no-user-gesture-required") as browser:
            sheet = sheet_of(rows_of(browser, folder, pictures))
    few = sheet.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.save(SHEET, optimize=True)
    size = SHEET.stat().st_size
    print(f"{SHEET.name}: {sheet.width} x {sheet.height}, {size / 1000:.0f} kB")
    if size > LARGEST:
        raise SystemExit(f"the sheet is larger than {LARGEST / 1000:.0f} kB")


if __name__ == "__main__":
    main()
