"""The page in a real Chromium: it comes in by its address and holds the host's disk."""

from __future__ import annotations

import contextlib
import time

import pytest

from tests.web.serving import served

api = pytest.importorskip(
    "playwright.sync_api", reason="needs a driver for a browser: pip install playwright"
)


@contextlib.contextmanager
def page_of(server, chromium, token=None, **given):
    """A tab with the page, once it is connected; nothing may go wrong in it or leave the server."""
    context = chromium.new_context(viewport={"width": 400, "height": 700}, **given)
    tab = context.new_page()
    wrong = []
    tab.on("console", lambda message: message.type == "error" and wrong.append(message.text))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on(
        "request",
        lambda request: request.url.startswith(server.origin) or wrong.append(request.url),
    )
    tab.goto(f"{server.origin}/#token={token or server.access.token}")
    try:
        yield tab, wrong
    finally:
        context.close()


def connected(tab):
    api.expect(tab.locator("#state")).to_have_text("connected")


def test_a_drag_on_the_page_moves_the_disk_and_letting_go_frees_it(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        connected(tab)
        assert tab.url == f"{server.origin}/"  # the token has left the address
        assert tab.evaluate("crossOriginIsolated")
        assert tab.title() == match.title
        tab.mouse.move(100, 300)
        tab.mouse.down()
        server.until(lambda meters: meters.touching)
        for x in range(100, 301, 10):
            tab.mouse.move(x, 300)
        server.until(lambda meters: abs(meters.cursor - 0.75) < 0.02)
        time.sleep(0.8)  # held still, it is held
        assert server.player.engine.meters.touching
        api.expect(tab.locator("#latency")).to_contain_text("finger to sound")
        tab.mouse.up()
        server.until(lambda meters: not meters.touching)
        assert wrong == []


def test_a_touching_page_that_is_closed_frees_the_disk(match, chromium):
    with served(match) as server:
        with page_of(server, chromium) as (tab, _):
            connected(tab)
            tab.mouse.move(200, 300)
            tab.mouse.down()
            server.until(lambda meters: meters.touching)
        server.until(lambda meters: not meters.touching)


def test_a_finger_taps_on_a_phone(match, chromium):
    with served(match) as server, page_of(server, chromium, has_touch=True) as (tab, wrong):
        connected(tab)
        before = len(server.player.engine.take_applied(0)[0])
        tab.touchscreen.tap(320, 300)
        end = time.monotonic() + 5.0
        while len(applied := server.player.engine.take_applied(0)[0]) < before + 2:
            assert time.monotonic() < end
            time.sleep(0.02)
        assert applied["touching"].tolist() == [True, False]
        assert applied["theta2"][0] == pytest.approx(0.8 * 3.14159265, abs=0.02)
        assert wrong == []


def test_a_page_with_a_wrong_token_says_what_to_do(match, chromium):
    with served(match) as server, page_of(server, chromium, "wrong") as (tab, _):
        api.expect(tab.locator("#state")).to_contain_text("open the address printed last")


def test_the_page_finds_its_host_again(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, _):
        connected(tab)
        tab.mouse.move(200, 300)
        tab.mouse.down()
        server.until(lambda meters: meters.touching)
        server.cut()
        server.until(lambda meters: not meters.touching)
        connected(tab)
        server.until(lambda meters: meters.touching)  # the finger is still there


def test_a_browser_that_cant_open_the_socket_is_told_what_it_needs(match, chromium):
    nothing_plays = served(match, plays=False, audio="host")
    with nothing_plays as server, page_of(server, chromium) as (tab, _):
        api.expect(tab.locator("#state")).to_contain_text("--cert")


def test_a_page_that_sounds_nowhere_says_what_to_start(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        api.expect(tab.locator("#state")).to_contain_text("--audio host")
