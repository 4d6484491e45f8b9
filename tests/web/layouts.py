"""Timelines and screens that a page must have room for."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

import overview_dsp as ov
from overview_dsp.data.timeline.curve_builder import CurveBuilder

SIZES = [
    (320, 480), (320, 568), (360, 640), (375, 667), (390, 664), (390, 844),
    (568, 320), (667, 375), (844, 390), (768, 1024), (1280, 800), (1440, 900),
]  # fmt: skip
TEXTS = (1.0, 2.0)
LONG = "Rises above the level of the mean of twelve months, 3rd time"
"""A label of 60 characters."""
UNIT = "micromoles/l"
"""A unit of 12 characters."""

FAULTS = """() => {
    const clipped = (one) => getComputedStyle(one).clipPath !== "none";
    const shown = (one) => one.checkVisibility({ visibilityProperty: true })
        && !clipped(one) && !(one.closest("header") && clipped(one.closest("header")));
    const name = (one) => one.id || one.getAttribute("class") || one.tagName;
    const found = [];
    const root = document.documentElement;
    if (root.scrollWidth > innerWidth || root.scrollHeight > innerHeight) {
        found.push(`the page scrolls: ${root.scrollWidth} x ${root.scrollHeight}`);
    }
    const open = document.querySelector("dialog:modal");
    // a list beside the picture is a part of the page that scrolls for itself
    const inside = (one) => (open ? open.contains(one)
        : !one.closest("dialog:not([open]), #editor"));
    const scrolls = (one) => one.closest("dialog");
    for (const one of document.querySelectorAll("button, input, select, a, summary")) {
        if (!shown(one) || !inside(one) || one.id === "slider") continue;
        const box = (one.closest("label") ?? one).getBoundingClientRect();
        if (box.width < 43.5 || box.height < 43.5) {
            found.push(`small: ${name(one)} ${box.width.toFixed(0)} x ${box.height.toFixed(0)}`);
        }
        const off = box.left < -0.5 || box.right > innerWidth + 0.5;
        if (off || (!scrolls(one) && (box.top < -0.5 || box.bottom > innerHeight + 0.5))) {
            found.push(`off screen: ${name(one)}`);
        }
        if (one.tagName === "BUTTON" && one.scrollWidth > one.clientWidth + 1) {
            found.push(`cut: ${name(one)}`);
        }
    }
    const texts = document.querySelectorAll(
        "h1, h2, h3, p, small, legend, dt, dd, td, th, li, label span, #clock, #number, #unit, "
        + "#event, #legend, svg text"
    );
    for (const one of texts) {
        if (!shown(one) || !inside(one) || !one.textContent.trim()) continue;
        if (one.matches(".spoken, #live")) continue;
        const box = one.getBoundingClientRect();
        const into = one.ownerSVGElement ? one.ownerSVGElement.getBoundingClientRect()
            : { left: 0, right: innerWidth, top: 0, bottom: scrolls(one) ? Infinity : innerHeight };
        if (box.left < into.left - 1 || box.right > into.right + 1
            || (!scrolls(one) && (box.top < into.top - 1 || box.bottom > into.bottom + 2))) {
            found.push(`beyond its place: ${name(one)} ${one.textContent.slice(0, 30)}`);
        }
        if (one.clientWidth > 0 && one.scrollWidth > one.clientWidth + 1) {
            found.push(`cut: ${name(one)} ${one.textContent.slice(0, 30)}`);
        }
    }
    const rows = ["header", "#moment", "#stage", "#tools", "nav"]
        .map((one) => document.querySelector(one)).filter(shown)
        .map((one) => [name(one), one.getBoundingClientRect()]);
    for (const [i, [first, a]] of rows.entries()) {
        for (const [second, b] of rows.slice(i + 1)) {
            const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
            if (over && a.height > 0 && b.height > 0) found.push(`${first} lies over ${second}`);
        }
    }
    const texts_above = ["clock", "number", "unit", "event"]
        .map((id) => document.getElementById(id));
    for (const [i, one] of texts_above.entries()) {
        for (const other of texts_above.slice(i + 1)) {
            const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 6;
            const boxes = [...other.getClientRects()];
            const over = [...one.getClientRects()].some((a) => boxes.some((b) => meet(a, b)));
            if (over) found.push(`${one.id} lies over ${other.id}`);
        }
    }
    const words = document.createRange();
    words.selectNodeContents(document.getElementById("let-go"));
    const beside = document.getElementById("when").getBoundingClientRect();
    for (const box of words.getClientRects()) { // the whole words, or nothing
        const isCut = box.right > beside.right + 1 || box.bottom > beside.bottom + 2;
        if (box.top < beside.bottom - 1 && isCut) {
            found.push("cut: where you released it");
        }
    }
    const reading = document.getElementById("moment");
    if (reading.scrollHeight > reading.clientHeight + 1) found.push("cut: moment");
    const picture = document.getElementById("stage").getBoundingClientRect();
    if (picture.height < 150) found.push(`picture of ${picture.height.toFixed(0)} px`);
    const labels = [...document.querySelectorAll("#canvas text")]
        .filter((one) => one.getAttribute("fill") !== "none")
        .map((one) => [one.textContent, one.getBoundingClientRect()]);
    for (const [i, [first, a]] of labels.entries()) {
        for (const [second, b] of labels.slice(i + 1)) {
            const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
            const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
            if (across > 1 && down > 4) found.push(`labels overlap: ${first}, ${second}`);
        }
    }
    return found;
}"""

KINDS = [f"kind of number {i}" for i in range(1, 21)]


def _read(timeline: ov.Timeline, folder: Path) -> ov.Timeline:
    """Return a series as its reader gives it, with the events of its rules."""
    file = folder / f"{timeline.title.split(',')[0]}.csv"
    start, curve = timeline.start, timeline.intensity
    known = timeline.has_data(np.asarray(curve.time_s))
    rows = [
        f"{start + timedelta(seconds=float(time)):%Y-%m-%dT%H:%M:%S},{value:.2f}"
        for time, value in zip(curve.points.time_s[known], curve.value[known], strict=True)
    ]
    file.write_text("\n".join([f"time,{timeline.title} ({curve.unit})", *rows]))
    return ov.load_timeline(file)


def _series(count: int, step: float, unit: str, start: str | None, title: str, **given: float):
    value = np.cumsum(np.random.default_rng(count).standard_normal(count)) * given.get("scale", 1.0)
    value += given.get("level", 0.0)
    builder = CurveBuilder()
    missing = np.zeros(count, dtype=bool)
    missing[int(count * 0.3) : int(count * given.get("until", 0.3))] = True
    builder.append(np.where(missing, np.nan, value), np.arange(count) * step)
    curve = builder.finish()
    end = (count - 1) * step
    intensity = ov.Intensity(curve.time_s, curve.value, unit)
    return ov.Timeline(
        title,
        end,
        intensity=intensity,
        gaps=builder.gaps(end),
        start=None if start is None else datetime.fromisoformat(start),
    )


def events_of(
    count: int, kinds: list[str], label: str, title: str, duration: float = 6000.0
) -> ov.Timeline:
    """Return evenly spaced events whose kinds take turns."""
    times = np.linspace(0.0, duration, count + 2)[1:-1]
    events = tuple(
        ov.Event(float(time), kinds[i % len(kinds)], label) for i, time in enumerate(times)
    )
    return ov.Timeline(title, duration, events)


def _mixed(count: int, label: str, title: str):
    series = _series(3000, 3600.0, UNIT, "2008-09-17T14:30", title, scale=3.4, level=-1234.56)
    times = np.linspace(0.0, series.duration_s, count + 2)[1:-1]
    events = tuple(
        ov.Event(float(time), KINDS[i % 3].replace(" ", "_"), label) for i, time in enumerate(times)
    )
    return ov.Timeline(
        title, series.duration_s, events, series.intensity, gaps=series.gaps, start=series.start
    )


def timelines(folder: Path) -> dict[str, ov.Timeline]:
    """Return twelve timelines by name: matches, series with gaps, many events, long texts."""
    match = ov.load_timeline("world-cup-final-2018")
    title = "Sea surface temperature at the light vessel Fehmarnbelt, 1 m"
    kinds = [kind.replace(" ", "_") for kind in KINDS]
    return {
        "world cup": match,
        "half a match": match.window(0.0, 2880.0),
        "price": _read(
            _series(3150, 86_400.0, "dollars", "2000-03-01", "Orchard", until=0.35, level=60.0),
            folder,
        ),
        "small numbers": _series(40, 3600.0, "°C", None, "hours", scale=0.001),
        "large numbers": _series(500, 60.0, "Pa", "2020-02-29", "Pressure", level=101_325.0),
        "long words": _mixed(24, LONG, title),
        "ten": events_of(10, kinds[:2], "something", "Ten events"),
        "a hundred": events_of(100, kinds, LONG, title),
        "a thousand": events_of(1000, kinds[:8], "", "A thousand events of eight kinds"),
        "ten thousand": events_of(10_000, kinds[:3], "x", "Ten thousand events", 86_000.0),
        "one event": events_of(1, ["launch"], "the launch of A", "One", 10.0),
        "no events": _series(12, 86_400.0, "", "2024-01-01", "Twelve rows"),
    }


def preset_of(timeline: ov.Timeline) -> str:
    """Return a preset that suits a timeline."""
    if "foul" in timeline.kinds():
        return "football"
    return "plain" if timeline.intensity is None else "series"


def settled(page: Any) -> None:
    """Wait until the sizes stay as they are for two frames."""
    page.evaluate("""async () => {
        const frame = () => new Promise((done) => requestAnimationFrame(done));
        const sizes = () => JSON.stringify(["#moment", "#stage", "nav"].map((one) =>
            document.querySelector(one).getBoundingClientRect()));
        for (let before = "", same = 0; same < 3;) {
            await frame();
            same = sizes() === before ? same + 1 : 0;
            before = sizes();
        }
    }""")
