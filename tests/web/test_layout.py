"""Every timeline has room on every screen, also with text twice as large: nothing is cut."""

from __future__ import annotations

import contextlib
import itertools

import pytest

import overview_dsp as ov
from overview_dsp.web.static_site import write_site
from tests.web.driving import until, violations
from tests.web.exported import opened_host
from tests.web.layouts import FAULTS, SIZES, TEXTS, preset_of, settled, timelines

STATES = ("first", "event", "released", "zoomed", "fault")
FAULT = "unknown position corner:9; use goal:5, 67:30 or seconds; unknown gesture dance"


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    return timelines(tmp_path_factory.mktemp("tables"))


@contextlib.contextmanager
def opened(chromium, host, size, text):
    width, height = size
    context = chromium.new_context(viewport={"width": width, "height": height})
    page = context.new_page()
    page.goto(host.url)
    until(page, "p.view && p.sound.node && (!p.info.series || p.view.points)")
    if text != 1:
        page.evaluate(f"document.documentElement.style.fontSize = '{100 * text}%'")
    settled(page)
    yield page
    context.close()


def faults_of(page, name, size, text):
    """Return what is wrong in the states of a page."""
    found = []
    for state in STATES:
        if state == "event":
            page.evaluate("""() => {
                const { events } = overview.view;
                const longer = (a, b) => (b.label.length > (a?.label.length ?? -1) ? b : a);
                const longest = events.reduce(longer, null);
                overview.goTo(longest?.position ?? 0.5);
            }""")
            page.wait_for_timeout(500)
        elif state == "released":
            page.keyboard.press("Escape")
            until(page, "document.getElementById('let-go').style.visibility === 'visible'")
        elif state == "zoomed":
            if page.evaluate("overview.info.windows.length") < 2:
                continue
            page.keyboard.press("+")
            until(page, "p.view.zoom === 1 && p.picture.view === p.view")
        settled(page)
        where = f"{name}, {size[0]} x {size[1]}, text {text:g}, {state}"
        if state == "fault":
            before = page.locator("#stage").bounding_box()
            page.evaluate(f"overview.fault({FAULT!r})")
            settled(page)
            if page.locator("#stage").bounding_box() != before:
                found.append(f"{where}: the picture moves")
        found += [f"{where}: {one}" for one in page.evaluate(FAULTS)]
    page.evaluate("overview.fault('')")
    return found


def dialog_faults(page, name, size, text):
    found = []
    for dialog, opens in (("events", "events"), ("dialog", "settings")):
        if opens == "settings":
            page.click("#settings")
        else:
            page.evaluate("overview.open('events')")
        settled(page)
        page.wait_for_timeout(100)
        where = f"{name}, {size[0]} x {size[1]}, text {text:g}, {dialog}"
        found += [f"{where}: {one}" for one in page.evaluate(FAULTS)]
        page.keyboard.press("Escape")
    return found


@pytest.fixture(scope="module")
def folders(drawn, tmp_path_factory):
    """Folders with a page of each timeline, written when first asked for."""
    written = {}

    def folder_of(name):
        if name not in written:
            written[name] = tmp_path_factory.mktemp("sites") / "site"
            timeline = drawn[name]
            with pytest.warns() if "kind" in str(timeline.kinds()) else contextlib.nullcontext():
                write_site(timeline, ov.load_preset(preset_of(timeline)), written[name], levels=1)
        return written[name]

    return folder_of


NAMES = [
    "world cup", "half a match", "price", "small numbers", "large numbers", "long words",
    "ten", "a hundred", "a thousand", "ten thousand", "one event", "no events",
]  # fmt: skip
SAMPLE = [
    ("world cup", (390, 844), 1), ("world cup", (568, 320), 1), ("world cup", (320, 568), 2),
    ("long words", (320, 568), 1), ("long words", (568, 320), 2), ("long words", (390, 664), 2),
    ("price", (667, 375), 1), ("price", (375, 667), 2), ("a hundred", (320, 480), 1),
    ("a thousand", (768, 1024), 2), ("ten thousand", (1440, 900), 1), ("no events", (844, 390), 2),
]  # fmt: skip


@pytest.mark.parametrize(("name", "size", "text"), SAMPLE)
def test_a_sample_of_timelines_has_room(chromium, axe, folders, name, size, text):
    with opened_host(folders(name)) as host, opened(chromium, host, size, text) as page:
        assert faults_of(page, name, size, text) == []
        assert dialog_faults(page, name, size, text) == []
        assert violations(page, axe) == []


@pytest.mark.soak
@pytest.mark.parametrize("name", NAMES)
def test_every_timeline_has_room_on_every_screen(chromium, axe, folders, name):
    found, count = [], 0
    with opened_host(folders(name)) as host:
        for size, text in itertools.product(SIZES, TEXTS):
            with opened(chromium, host, size, text) as page:
                found += faults_of(page, name, size, text)
                found += dialog_faults(page, name, size, text)
                found += [f"{name} {size} {text}: {one}" for one in violations(page, axe)]
                count += 1
    print(f"\n{name}: {count} screens, {len(found)} faults")
    assert found == []
