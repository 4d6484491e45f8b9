"""An exported folder within an article, by one script tag and one element."""

from __future__ import annotations

import contextlib
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from tests.web.driving import PATIENCE_S, PHONE, violations
from tests.web.exported import opened_host

ARTICLE = """<!doctype html>
<html lang="en"><head><title>Report</title><meta name="viewport" content="width=device-width">
<style>body {{ margin: 0 }} p {{ height: 600px; margin: 0 }}</style></head>
<body><main><h1>Report</h1><p>before</p>
{script}
{elements}
<p>between</p><p>after</p><p>after</p></main></body></html>"""

SCRIPT = '<script src="{url}embed.js" async></script>'
PLAIN = '<overview-timeline src="{url}"></overview-timeline>'
DRESSED = (
    '<overview-timeline src="{url}" title="Das Finale" lang="de" ink="rgb(10, 20, 30)"'
    ' paper="ivory" at="goal:2"></overview-timeline>'
)
FALLBACK = (
    '<overview-timeline src="{url}"><iframe src="{url}" title="The final"></iframe>'
    "</overview-timeline>"
)


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *unused):
        pass


@pytest.fixture
def article(chromium, site, tmp_path):
    """Open an article with elements, on another origin than the folder."""
    with opened_host(site) as host, contextlib.ExitStack() as stack:
        server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=tmp_path))
        stack.callback(server.server_close)
        stack.callback(server.shutdown)
        threading.Thread(target=server.serve_forever, daemon=True).start()

        def open_article(*elements, script=SCRIPT, size=PHONE):
            text = ARTICLE.format(script=script, elements="\n".join(elements))
            (tmp_path / "index.html").write_text(text.replace("{url}", host.url))
            context = chromium.new_context(viewport=size, has_touch=True)
            stack.callback(context.close)
            page = context.new_page()
            page.goto(f"http://127.0.0.1:{server.server_port}/")
            page.evaluate(
                """() => {
                    window.said = [];
                    for (const name of ['enter', 'move'])
                        addEventListener(`overview:${name}`, ({ detail, target }) =>
                            said.push({ name, src: target.getAttribute('title'), ...detail }));
                }"""
            )
            return page

        yield open_article


def frame_of(page, number=0):
    """Return the frame of an element once its page is ready."""
    from playwright.sync_api import Error

    page.locator("iframe").nth(number).scroll_into_view_if_needed()
    for _ in range(round(PATIENCE_S / 0.05)):
        frames = page.frames[1:]
        with contextlib.suppress(Error):  # the frame changes from an empty page to its own
            if len(frames) > number and frames[number].evaluate(
                "() => Boolean(window.overview?.view && overview.sound.ready)"
            ):
                return frames[number]
        page.wait_for_timeout(50)
    raise AssertionError("the embedded page is not ready")


def stage_of(page, number=0):
    box = page.locator("iframe").nth(number).bounding_box()
    return box["x"] + 0.2 * box["width"], box["y"] + 0.5 * box["height"]


def test_one_tag_and_one_element_show_a_timeline_that_reports_its_events(article):
    page = article(PLAIN)
    frame = frame_of(page)
    assert frame.evaluate("document.documentElement.classList.contains('embedded')")
    x, y = stage_of(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 220, y, steps=30)
    page.wait_for_timeout(1500)
    page.mouse.up()
    said = page.evaluate("said")
    entered = [one for one in said if one["name"] == "enter"]
    moves = [one for one in said if one["name"] == "move"]
    assert any(one["kind"] == "goal" and one["label"] for one in entered)
    assert all(one["text"] and one["time_s"] >= 0 for one in entered)
    positions = [one["position"] for one in moves]
    assert positions == sorted(positions)
    assert positions[-1] > 0.5
    assert all(one["text"] for one in moves)


def test_title_language_colours_and_place_are_attributes(article):
    page = article(PLAIN, DRESSED)
    plain, dressed = frame_of(page), frame_of(page, 1)
    look = """() => [document.documentElement.lang, document.querySelector('h1').textContent,
        getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]"""
    assert dressed.evaluate(look) == ["de", "Das Finale", "rgb(10, 20, 30)", "rgb(255, 255, 240)"]
    assert plain.evaluate(look)[0] == "en"
    assert plain.evaluate(look)[3] != "rgb(255, 255, 240)"
    goal = dressed.evaluate(
        "overview.view.events.filter(({ kind }) => kind === 'goal')[1].position"
    )
    assert dressed.evaluate("overview.reading") == pytest.approx(goal, abs=0.01)
    assert page.locator("iframe").nth(1).get_attribute("title") == "Das Finale"
    page.evaluate("document.querySelectorAll('overview-timeline')[1].setAttribute('paper', 'red')")
    page.wait_for_timeout(300)
    assert dressed.evaluate(look)[3] == "rgb(255, 0, 0)"
    page.evaluate("document.querySelectorAll('overview-timeline')[1].setAttribute('ink', 'url(x)')")
    page.wait_for_timeout(300)
    assert dressed.evaluate(look)[2] != "rgb(10, 20, 30)"


def test_a_timeline_below_the_screen_loads_when_it_comes_near(article):
    page = article(PLAIN, *("<p>more</p>",) * 400, PLAIN)
    frame_of(page)
    assert page.frames[2].url in ("", "about:blank")
    frame_of(page, 1)


@pytest.mark.parametrize("width", [320, 390, 768, 1280])
def test_nothing_is_cut_at_any_width_of_the_article(article, width):
    page = article(PLAIN, size={"width": width, "height": 800})
    frame = frame_of(page)
    page.wait_for_timeout(300)
    sizes = frame.evaluate(
        """() => { const root = document.documentElement;
            return [root.scrollWidth, innerWidth, root.scrollHeight, innerHeight]; }"""
    )
    assert sizes[0] <= sizes[1]
    assert sizes[2] <= sizes[3] + 1
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def swipe(page, session, x, y, distance):
    """Swipe by touch; return how far the article has scrolled."""
    before = page.evaluate("scrollY")
    session.send(
        "Input.synthesizeScrollGesture",
        {"x": x, "y": y, "yDistance": -distance, "gestureSourceType": "touch", "speed": 1600,
         "preventFling": True},
    )  # fmt: skip
    page.wait_for_timeout(30)
    return page.evaluate("scrollY") - before


def test_swipes_over_a_timeline_scroll_the_article_as_far_as_beside_it(article):
    page = article(PLAIN)
    frame = frame_of(page)
    session = page.context.new_cdp_session(page)
    swipe(page, session, 0.5 * PHONE["width"], 400, 100)  # the first one may wait for the page
    farther = []
    for n in range(50):
        page.evaluate("scrollTo(0, 450)")
        box = page.locator("iframe").bounding_box()
        beside = swipe(page, session, 0.5 * PHONE["width"], box["y"] - 30, 100)
        page.evaluate("scrollTo(0, 450)")
        x = (0.15 + 0.7 * (n % 7) / 6) * PHONE["width"]
        over = swipe(page, session, x, box["y"] + (0.35 + 0.3 * (n % 5) / 4) * box["height"], 100)
        farther.append(over - beside)
    assert max(map(abs, farther)) <= 2, farther
    assert frame.evaluate("overview.position") == 0.0
    assert page.evaluate("said.filter(({ name }) => name === 'enter').length") == 0


def test_a_finger_that_drags_sideways_or_taps_moves_the_disk(article):
    page = article(PLAIN)
    frame = frame_of(page)
    session = page.context.new_cdp_session(page)
    x, y = stage_of(page)

    def touch(kind, *points):
        listed = [{"x": x_, "y": y_} for x_, y_ in points]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": listed})

    touch("touchStart", (x, y))
    for step in range(1, 21):
        touch("touchMove", (x + 10 * step, y))
        page.wait_for_timeout(10)
    assert frame.evaluate("overview.input.active") == "touch"
    assert frame.evaluate("overview.position") > 0.5
    touch("touchEnd")
    page.wait_for_timeout(100)
    assert frame.evaluate("overview.input.active") is None
    page.evaluate("said.length = 0")
    touch("touchStart", (x + 100, y))
    touch("touchEnd")
    page.wait_for_timeout(1500)
    assert page.evaluate("said.some(({ name }) => name === 'enter')")


def test_without_scripts_the_iframe_stands_alone_and_with_them_it_is_used(article):
    page = article(FALLBACK, script="")
    frame = frame_of(page)
    assert not frame.evaluate("document.documentElement.classList.contains('embedded')")
    page = article(FALLBACK)
    assert page.locator("iframe").count() == 1
    frame_of(page)


def test_axe_finds_nothing_in_an_article(article, axe):
    page = article(PLAIN)
    frame_of(page)
    assert violations(page, axe) == []
