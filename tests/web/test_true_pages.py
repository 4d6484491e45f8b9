"""Extremes, events and random positions of twelve timelines: as heard, and in the picture."""

from __future__ import annotations

import warnings
from collections import Counter

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.web.site_data import event_fields
from overview_dsp.web.static_site import write_site
from tests.web.driving import PHONE, until
from tests.web.exported import opened_host
from tests.web.layouts import events_of
from tests.web.test_values import shared, with_gaps

POSITIONS = 100
SLOWED = 6  # times slower than this processor, as a phone

SAY = """(positions) => positions.map((position) => {
    const p = window.overview;
    const region = document.getElementById("announcement");
    document.getElementById("next").focus(); // the region speaks where the slider has no focus
    p.navigation.to(position);
    p.draw();
    p.slider.show(p.view, p.reading, p.info, Infinity);
    const { geometry: g } = p.picture;
    const moved = (id) => new DOMMatrix(getComputedStyle(document.getElementById(id)).transform);
    const dot = moved("at-input").multiply(moved("dot"));
    const { event, info } = { event: p.currentEvent, info: p.info };
    return {
        heard: region.textContent.trim(),
        number: document.getElementById("number").textContent,
        dot: [(dot.e - g.left) / (g.right - g.left), (g.bottom - dot.f) / (g.bottom - g.y(1))],
        isShown: document.getElementById("dot").style.visibility === "visible",
        event: event && { time_s: event.time_s, kind: event.kind, position: event.position },
    };
})"""

DRAWN = """async () => {
    const { markPoint } = await import("./modules/layer.js");
    const { view, info, picture: { geometry: g, colours } } = window.overview;
    const isFlat = view.level.every((one) => !one);
    const marks = [];
    const columns = []; // of the band, or of the number of events
    const lines = []; // parts of a match
    for (const path of document.querySelectorAll("#canvas path")) {
        const box = path.getBBox();
        const [stroke, fill] = [path.getAttribute("stroke"), path.getAttribute("fill")];
        if (box.width < 30 && box.height < 30) marks.push(box);
        if (box.width === 0 && stroke === colours.edge) lines.push(box.x);
        const isBand = stroke === colours.edge && path.getAttribute("stroke-width") === "3";
        if (isBand || (isFlat && fill === colours.fill)) {
            const numbers = (path.getAttribute("d").match(/-?[\\d.]+/g) ?? []).map(Number);
            columns.push(...numbers.filter((_, i) => i % 2 === 0));
        }
    }
    const counts = {};
    for (const { kind } of view.events) counts[kind] = (counts[kind] ?? 0) + 1;
    const at = view.events.map((event) => markPoint(g, view, info, event));
    const holds = (box, x, y) => x > box.x - 4 && x < box.x + box.width + 4
        && y > box.y - 4 && y < box.y + box.height + 4;
    return view.events.map(({ kind }, i) => {
        const [x, y] = at[i];
        if (marks.some((box) => holds(box, x, y))) return "mark";
        if (columns.some((one) => Math.abs(one - x) <= 4)) return "band";
        if (kind === "period" && lines.some((one) => Math.abs(one - x) < 1)) return "line";
        // the note: frequent kinds are left out beside a mark of a rarer one
        const isBeside = at.some(([otherX, otherY], k) => otherY === y
            && Math.abs(otherX - x) < 11 && counts[view.events[k].kind] < counts[kind]);
        return counts[kind] > 12 && isBeside ? "left out" : "nothing";
    });
}"""


def spiky(seed, count):
    timeline, _, _ = with_gaps(seed, count)
    return timeline


DATA = {
    "shares": lambda: (shared("stocks/bokeh_AAPL.csv"), "stocks"),
    "index": lambda: (shared("stocks/sp500-2000.csv"), "stocks"),
    "temperature": lambda: (
        shared("weather/seattle-weather-hourly-normals.csv", value="temperature"), "weather",
    ),
    "weather": lambda: (shared("weather/seattle-weather.csv", value="temp_max"), "weather"),
    "match": lambda: (shared("football/statsbomb/69321.json"), "football"),
    "second match": lambda: (shared("football/statsbomb/22936.json"), "football"),
    "gaps 300": lambda: (spiky(0, 300), "series"),
    "gaps 3000": lambda: (spiky(1, 3000), "series"),
    "gaps 10000": lambda: (spiky(2, 10_000), "stocks"),
    "gaps 16000": lambda: (spiky(3, 16_000), "weather"),
    "ten thousand": lambda: (
        events_of(10_000, ["launch", "landing"], "x", "Ten thousand", 86_000.0), "plain",
    ),
    "a hundred": lambda: (events_of(100, ["launch"], "the launch", "A hundred"), "plain"),
}  # fmt: skip


def found_text(number, decimals):
    return f"{number:.{decimals}f}".replace("-", "\u2212")


def faults_of(page, timeline, preset):
    """Return what the live region or the picture of a page has wrong."""
    curve = timeline.intensity
    series = page.evaluate("overview.info.series")
    angle_map = AngleMap.of(timeline, ov.load_preset(preset))
    at_events = page.evaluate("overview.view.events.map(({ position }) => position)")
    positions = np.random.default_rng(7).random(POSITIONS).tolist()
    told = page.evaluate(SAY, [*positions, *at_events])
    near = page.evaluate("overview.view.tolerance")
    faults = []
    times = None
    if series:
        known = timeline.has_data(np.asarray(curve.time_s))
        times, value = np.asarray(curve.time_s)[known], np.asarray(curve.value)[known]
        low, span = float(value.min()), float(np.ptp(value))
        for way, edge in (("toHighest", value.max()), ("toLowest", value.min())):
            page.evaluate(f"() => {{ document.getElementById('next').focus();"
                          f" overview.navigation.{way}(); }}")  # fmt: skip
            heard = page.text_content("#announcement")
            if not heard.startswith(found_text(edge, series["decimals"])):
                faults.append(f"{way}: {heard}, not {edge}")
        if page.evaluate("overview.view.scale") != pytest.approx([low, span]):
            faults.append("the axis does not span all values")
    for i, (position, state) in enumerate(zip([*positions, *at_events], told, strict=True)):
        moment = float(angle_map.time_at(np.array([position]))[0])
        event = state["event"]
        if i >= POSITIONS:
            own = timeline.events[i - POSITIONS]
            if event is None or abs(event["time_s"] - own.time_s) > 1e-6:
                faults.append(f"event at {own.time_s}: {state}")
            moment = own.time_s
        elif event is not None:
            if abs(event["position"] - position) > near * 1.001:
                faults.append(f"{position}: an event that is not near: {state}")
            moment = event["time_s"]
        if event is not None and event["kind"].split("_")[0] not in state["heard"].lower():
            kinds = page.evaluate("(kind) => overview.info.kinds[kind].name", event["kind"])
            same = [one for one in timeline.events if one.time_s == event["time_s"]]
            labels = [event_fields(one)["label"] for one in same]
            if not any(one and one in state["heard"] for one in [kinds, *labels]):
                faults.append(f"{position}: {event['kind']} is not in {state['heard']}")
        if times is None:
            continue
        if timeline.has_data(np.array([moment]))[0]:
            nearest = int(np.abs(times - moment).argmin())
            expected = found_text(float(value[nearest]), series["decimals"])
            if not state["heard"].startswith(expected) or state["number"] != expected:
                faults.append(f"{position}: {state}, not {expected}")
            if not state["isShown"]:
                faults.append(f"{position}: no dot at {expected}")
        elif "no data" not in state["heard"].lower() or state["number"] != "No data":
            faults.append(f"{position}: {state} in a gap")
    drawn = page.evaluate(DRAWN)
    faults += [
        f"{event.kind} at {event.time_s} is not drawn"
        for event, how in zip(timeline.events, drawn, strict=True) if how == "nothing"
    ]  # fmt: skip
    return faults, len(told), Counter(drawn)


@pytest.mark.soak
@pytest.mark.parametrize("name", DATA)
def test_all_that_a_page_says_and_draws_is_the_datas(chromium, tmp_path, name):
    timeline, preset = DATA[name]()
    with warnings.catch_warnings(action="ignore"):  # of kinds that the preset has not
        write_site(timeline, ov.load_preset(preset), tmp_path / "site", levels=0)
    with opened_host(tmp_path / "site") as host:
        context = chromium.new_context(viewport=PHONE, service_workers="block")
        page = context.new_page()
        if chromium.browser_type.name == "chromium":  # Firefox can't be slowed
            client = context.new_cdp_session(page)
            client.send("Emulation.setCPUThrottlingRate", {"rate": SLOWED})
        page.goto(host.url)
        until(page, "p.view && p.sound.node && (!p.info.series || p.view.points)")
        faults, said, drawn = faults_of(page, timeline, preset)
        context.close()
    print(f"\n{name}: {said} positions heard, events drawn {dict(drawn)}, {len(faults)} wrong")
    assert faults[:10] == []
