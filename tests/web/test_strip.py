"""The whole over a window of it: where that lies, moved by a finger, zoomed gently by two."""

from __future__ import annotations

import contextlib
from itertools import pairwise

import pytest

import overview_dsp as ov
from tests.web.driving import PHONE, until
from tests.web.exported import opened_host
from tests.web.serving import served
from tests.web.test_served_page import page_of


@contextlib.contextmanager
def page_at(chromium, url):
    context = chromium.new_context(viewport=PHONE, has_touch=True)
    page = context.new_page()
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(url)
    until(page, "p.view && p.sound.node")
    yield page
    assert wrong == []
    assert page.text_content("#fault") == ""
    context.close()


def test_the_strip_tells_where_the_window_lies_and_moves_it(chromium, site, match):
    with opened_host(site) as host, page_at(chromium, host.url) as page:
        scores = page.locator("#canvas text[font-weight='600']").all_text_contents()
        assert {"1\u20130", "4\u20132"} <= set(scores)  # the whole tells them at its marks
        assert not page.is_visible("#strip-window")
        page.click("#in")
        until(page, "p.view.zoom === 1")
        strip = page.locator("#strip").bounding_box()

        def window():
            box = page.locator("#strip-window").bounding_box()
            return (box["x"] - strip["x"]) / strip["width"], box["width"] / strip["width"]

        ends = page.evaluate("[overview.view.start_s, overview.view.end_s]")
        surface = ov.build_surface(match, ov.load_preset("football"))
        start, end = surface.position_of(ends)
        assert window() == pytest.approx((start, end - start), abs=0.01)
        y = strip["y"] + strip["height"] / 2
        page.mouse.move(strip["x"] + strip["width"] * (window()[0] + 0.05), y)
        page.mouse.down()
        page.mouse.move(strip["x"] + strip["width"] * 0.99, y, steps=10)
        until(page, f"p.view.end_s === {match.duration_s}")
        page.mouse.up()
        last = surface.position_of(match.duration_s * 2 / 3)
        assert window()[0] == pytest.approx(last, abs=0.01)
        assert page.evaluate("overview.input.active") is None  # the disk isn't touched by it
        page.click("#out")
        until(page, "p.view.zoom === 0")
        assert not page.is_visible("#strip-window")


def test_only_longer_texts_lay_the_page_out_again(chromium, site):
    with opened_host(site) as host, page_at(chromium, host.url) as page:
        page.evaluate("""() => {
            window.layouts = 0;
            const count = (records) => { layouts += records.length; };
            const watched = { attributes: true, attributeFilter: ["data-fit"] };
            new MutationObserver(count).observe(document.documentElement, watched);
        }""")
        for seen in ("first", "again"):
            page.evaluate("window.layouts = 0")
            for at in (0.1, 0.5, 0.9):
                page.evaluate(f"overview.viewState.zoom(1, {at})")
                until(page, "p.view.zoom === 1")
                page.evaluate("overview.viewState.showWhole()")
                until(page, "p.view.zoom === 0")
            layouts = page.evaluate("layouts")
            print(f"\n{seen}: {layouts} layouts of the text")
        assert layouts == 0


def pinch(page, factor, steps=24):
    """Two fingers spread by `factor` about the middle of the picture; lengths shown meanwhile."""
    box = page.locator("#slider").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 100
    apart = 40 if factor > 1 else 40 / factor
    client = page.context.new_cdp_session(page)
    lengths = []

    def touch(kind, *positions):
        points = [{"x": position, "y": y, "id": i} for i, position in enumerate(positions)]
        client.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", x - apart)
    touch("touchStart", x - apart, x + apart)
    for step in range(1, steps + 1):
        now = apart * factor ** (step / steps)
        touch("touchMove", x - now, x + now)
        page.wait_for_timeout(40)
        drawn = "overview.picture.view.end_s - overview.picture.view.start_s"
        lengths.append(page.evaluate(drawn))
    touch("touchEnd")
    return lengths


def test_a_pinch_zooms_a_folder_in_gentle_steps_to_its_nearest_window(chromium, site, match):
    with opened_host(site) as host, page_at(chromium, host.url) as page:
        seen = [match.duration_s, *pinch(page, 2.9)]
        assert seen[-1] < 0.5 * match.duration_s
        assert len({round(one) for one in seen}) > 8
        until(page, "p.view.zoom === 1 && p.picture.view === p.view")
        pinch(page, 1 / 2.9)
        until(page, "p.view.zoom === 0 && p.picture.view === p.view")


def test_a_pinch_on_a_server_ends_where_the_fingers_do(match, chromium):
    with (
        served(match, plays=False) as server,
        page_of(server, chromium, has_touch=True) as (page, wrong),
    ):
        until(page, "p.view && p.sound.node")
        page.evaluate("""() => {
            window.under = [overview.view.end_s];
            const take = overview.viewState.setView.bind(overview.viewState);
            overview.viewState.setView = (view) => {
                under.push(view.end_s - view.start_s);
                take(view);
            };
        }""")
        pinch(page, 2.0)
        until(
            page, f"Math.abs((p.view.end_s - p.view.start_s) * 2 / {match.duration_s} - 1) < 0.05"
        )
        until(page, "p.picture.view === p.view")
        under = page.evaluate("window.under")
        assert len(under) >= 3
        assert all(1 <= before / after < 2 for before, after in pairwise(under))
        assert wrong == []
