"""The page from its server, in a real Chromium: it sounds itself, or holds the host's disk."""

from __future__ import annotations

import contextlib
import time
import wave

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.web import remote_inputs
from overview_dsp.web.media import open_media
from tests.web.driving import DESKTOP, PHONE, at, not_in_firefox, until, violations
from tests.web.serving import served

MATCH, FOOTBALL = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
GOAL = float(ov.build_surface(MATCH, FOOTBALL).position_of(4050.0))  # 4-1


@contextlib.contextmanager
def page_of(server, chromium, token=None, **given):
    """A tab with the page and what went wrong in it; nothing may leave the server."""
    context = chromium.new_context(viewport=PHONE, **given)
    tab = context.new_page()
    wrong = []
    tab.on("console", lambda message: message.type == "error" and wrong.append(message.text))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on(
        "request",
        lambda request: (
            request.url.startswith((server.origin, "blob:")) or wrong.append(request.url)
        ),
    )
    tab.goto(f"{server.origin}/#token={token or server.access.token}")
    try:
        yield tab, wrong
    finally:
        context.close()


def says(tab, id, words, seconds=20.0):
    end = time.monotonic() + seconds
    while words not in (text := tab.text_content(f"#{id}")):
        assert time.monotonic() < end, text
        tab.wait_for_timeout(20)


def connected(tab):
    until(tab, "p.view")
    says(tab, "link", "connected to the host")


def test_a_drag_on_the_page_moves_the_disk_and_letting_go_frees_it(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        connected(tab)
        assert tab.url == f"{server.origin}/"  # the token has left the address
        assert tab.evaluate("crossOriginIsolated")
        assert match.title in tab.title()
        tab.mouse.move(*at(tab, 0.1))
        tab.mouse.down()
        server.until(lambda meters: meters.touching)
        tab.mouse.move(*at(tab, 0.75), steps=20)
        server.until(lambda meters: abs(meters.cursor - 0.75) < 0.02)
        until(tab, "Math.abs(p.cursor - 0.75) < 0.02")
        time.sleep(0.8)  # held still, it is held
        assert server.player.engine.meters.touching
        says(tab, "latency", "ms to sound")
        tab.mouse.up()
        server.until(lambda meters: not meters.touching)
        assert wrong == []


def test_a_movement_reaches_the_host_in_small_steps(match, chromium, monkeypatch):
    # on a busy machine a page may be silent for long; what happens then is tested elsewhere
    monkeypatch.setattr(remote_inputs, "SILENCE_TIMEOUT_S", 30.0)
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        connected(tab)
        tab.mouse.move(*at(tab, 0.1))
        tab.mouse.down()
        server.until(lambda meters: meters.touching)
        first = len(server.player.engine.pop_applied(0)[0])
        tab.mouse.move(*at(tab, 0.4), steps=30)
        server.until(lambda meters: abs(meters.cursor - 0.4) < 0.02)
        applied = server.player.engine.pop_applied(0)[0][first:]
        assert len(applied) > 90  # a pointer tells 30
        assert (applied["touching"] == 1).all()
        tab.mouse.up()
        assert wrong == []


def test_a_touching_page_that_is_closed_frees_the_disk(match, chromium):
    with served(match) as server:
        with page_of(server, chromium) as (tab, _):
            connected(tab)
            tab.mouse.move(*at(tab, 0.5))
            tab.mouse.down()
            server.until(lambda meters: meters.touching)
        server.until(lambda meters: not meters.touching)


@not_in_firefox
def test_a_finger_taps_on_a_phone(match, chromium):
    expected = ov.render(match, FOOTBALL, ov.tap(0.8)).engine.meters.strikes  # there and back
    with served(match) as server, page_of(server, chromium, has_touch=True) as (tab, wrong):
        connected(tab)
        before = len(server.player.engine.pop_applied(0)[0])
        first = server.player.engine.meters.strikes
        tab.touchscreen.tap(*at(tab, 0.8))
        # a passing state may be missed on a busy machine; what was passed is counted
        server.until(lambda meters: meters.strikes - first == expected)
        server.until(lambda meters: not meters.engaged)
        applied = server.player.engine.pop_applied(0)[0][before:]
        assert applied["theta2"][0] == pytest.approx(0.8 * 3.14159265, abs=0.02)
        assert list(applied["touching"]).count(0) == 1  # released at once
        assert server.player.engine.meters.strikes - first == expected
        assert wrong == []


def test_zooms_of_the_page_and_of_the_host_meet(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        connected(tab)
        tab.click("#in")
        until(tab, "p.view.zoom === 1")
        start, end = tab.evaluate("[p.start_s, p.end_s]".replace("p.", "overview.view."))
        wait_for(lambda: server.player.window == pytest.approx((start, end)))
        server.session.show(1000.0, 1300.0)  # as another page would: a window of its own
        until(tab, "p.view.start_s === 1000 && p.view.end_s === 1300")
        tab.focus("#slider")
        tab.keyboard.press("End")
        tab.keyboard.press("PageUp")  # beyond the window: the next one
        until(tab, "p.view.end_s > 1300")
        tab.click("#out")
        until(tab, "p.view.zoom < 2")
        assert wrong == []


def wait_for(condition, seconds=10.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_page_with_a_wrong_token_says_what_to_do(match, chromium):
    with served(match) as server, page_of(server, chromium, "wrong") as (tab, _):
        says(tab, "fault", "open the URL printed last")


def test_the_page_finds_its_host_again(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, _):
        connected(tab)
        tab.mouse.move(*at(tab, 0.5))
        tab.mouse.down()
        server.until(lambda meters: meters.touching)
        server.cut()
        server.until(lambda meters: not meters.touching)
        connected(tab)
        server.until(lambda meters: meters.touching)  # the finger is still there


def test_a_browser_that_cant_open_the_socket_is_shown_what_it_needs(match, chromium):
    nothing_plays = served(match, plays=False, audio="host")
    with nothing_plays as server, page_of(server, chromium) as (tab, _):
        says(tab, "link", "--cert")


# --- the page sounds by itself -------------------------------------------------------------------


def test_a_served_page_sounds_by_itself_from_its_first_window_on(
    match, springy_football, springy_file, chromium
):
    first = (3000.0, 4500.0)
    part = ov.build_surface(match.window(*first), springy_football)
    goal = float(part.position_of(4050.0 - first[0]))
    with (
        served(match, plays=False, preset=str(springy_file), first=first) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, "p.view")
        assert tab.evaluate("[overview.view.start_s, overview.view.end_s]") == list(first)
        tab.evaluate("""() => {
            window.struck = [];
            const take = overview.update.bind(overview);
            overview.update = (told) => {
                struck.push(...told.newStrikes.map(({ event }) => event));
                take(told);
            };
        }""")
        tab.mouse.move(*at(tab, 0.1))
        tab.mouse.down()
        tab.mouse.move(*at(tab, goal), steps=40)
        # the sound may still load
        until(tab, f"p.meters?.strikes > 5 && Math.abs(p.cursor - {goal}) < 0.01")
        # the surface of that part, with details: the whole has fewer events
        assert tab.evaluate("Math.max(...struck)") > len(match.events)
        says(tab, "clock", "67:")  # drawn a frame after the disk is there
        tab.mouse.up()
        until(tab, "p.cursor < 0.001")
        tab.click("#out")
        until(tab, "p.view.zoom === 0 && p.meters.changesWaiting === 0")
        assert tab.evaluate("navigator.serviceWorker.controller") is None
        assert wrong == []


def test_a_page_reads_out_its_own_place_until_another_takes_the_hosts_disk(match, chromium):
    with (
        served(match) as server,
        page_of(server, chromium) as (one, wrong),
        page_of(server, chromium) as (other, _),
    ):
        for tab in (one, other):
            connected(tab)
        one.mouse.move(*at(one, 0.1))
        one.mouse.down()
        one.mouse.move(*at(one, 0.63), steps=10)
        until(one, "p.cursor > 0.5")
        until(other, "p.reading > 0.5")  # which has not moved it: the disk's
        one.mouse.up()
        until(one, "p.cursor < 0.01 && p.wasFree")
        assert abs(one.evaluate("overview.reading") - 0.63) < 0.01
        moment = one.evaluate("overview.moment")
        assert one.evaluate("overview.currentEvent?.time_s ?? overview.moment") == moment
        other.mouse.move(*at(other, 0.3))
        other.mouse.down()
        until(one, "Math.abs(p.reading - 0.3) < 0.02")
        other.mouse.up()
        until(one, "p.reading < 0.01")
        assert wrong == []


def film_at(folder):
    """A recording of 20 s."""
    film = folder / "match.wav"
    with wave.open(str(film), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8_000)
        file.writeframes(bytes(2 * 8_000 * 20))
    return film


@contextlib.contextmanager
def with_film(match, preset, chromium, tmp_path, at_s=12.0, **given):
    """A page with a film so short that it holds the seconds about the goal alone, at 12 s of it."""
    media = open_media(str(film_at(tmp_path)), at_s - 4050.0)
    with (
        served(match, plays=False, preset=str(preset), media=media) as server,
        page_of(server, chromium, **given) as (tab, wrong),
    ):
        until(tab, "p.view && p.film")
        yield tab
        assert wrong == []


def watched(tab, title="goal, 4-1 Mbappé", moment=7.0):
    """That the film is open at a moment, with a title; closes it."""
    until(tab, "document.getElementById('film').open")
    assert tab.text_content("#film h2") == title
    until(tab, f"p.film.video.currentTime > {moment - 0.1}")
    assert tab.evaluate("overview.film.video.currentTime") < moment + 3.0
    tab.click("#film .done")
    until(tab, "p.film.video.paused && !document.getElementById('film').open")
    assert not tab.evaluate("overview.film.video.ended")


SMALL = {"width": 320, "height": 568}
DOUBLE = "document.documentElement.style.fontSize = '200%'"


def test_a_small_screen_has_the_film_in_more(match, springy_file, chromium, tmp_path):
    with with_film(match, springy_file, chromium, tmp_path) as tab:
        tab.set_viewport_size(SMALL)
        tab.evaluate(DOUBLE)
        tab.evaluate("(at) => overview.goTo(at)", GOAL)
        until(tab, "p.currentEvent?.label.startsWith('4-1')")
        tab.click("#settings")
        tab.click("#watch")
        assert not tab.evaluate("document.getElementById('dialog').open")
        watched(tab)


def test_a_small_screen_shows_the_connection(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        tab.set_viewport_size(SMALL)
        tab.evaluate(DOUBLE)
        until(tab, "p.view && document.documentElement.dataset.fit.length > 3")
        says(tab, "link", "connected to the host")
        box = tab.locator("#link").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= SMALL["width"]
        assert box["width"] > 100
        clips = """() => {
            const found = [];
            for (let one = document.getElementById("link"); one; one = one.parentElement) {
                found.push(getComputedStyle(one).clipPath);
            }
            return found;
        }"""
        assert set(tab.evaluate(clips)) == {"none"}
        assert wrong == []


def test_a_goal_can_be_watched_from_a_little_before(match, springy_file, chromium, tmp_path):
    with with_film(match, springy_file, chromium, tmp_path) as tab:
        tab.mouse.move(*at(tab, 0.6))
        tab.mouse.down()
        tab.mouse.move(*at(tab, GOAL), steps=20)
        until(tab, "document.getElementById('event').textContent.includes('4-1')")
        tab.focus("#slider")
        tab.keyboard.press("v")
        until(tab, "document.getElementById('film').open")
        tab.mouse.up()  # a pointer that holds the disk presses no button
        watched(tab)


def test_what_was_felt_last_is_watched_after_the_finger_is_lifted(
    match, springy_file, chromium, tmp_path
):
    with with_film(match, springy_file, chromium, tmp_path) as tab:
        tab.mouse.move(*at(tab, 0.66))
        tab.mouse.down()
        tab.mouse.move(*at(tab, GOAL), steps=30)
        until(tab, "document.getElementById('event').textContent.includes('4-1')")
        tab.mouse.up()
        until(tab, "p.cursor < 0.001")  # it has run back over all the others
        tab.click("#play")
        watched(tab)


def test_the_place_of_the_finger_is_read_and_watched_after_a_short_drag(
    match, springy_file, chromium, tmp_path
):
    surface = ov.build_surface(MATCH, ov.load_preset(str(springy_file)))
    events = surface.angle_map.events
    goals = [i for i, event in enumerate(MATCH.events) if "goal" in event.kind]
    between = float(events[np.diff(events).argmax()] + np.diff(events).max() / 2)
    with with_film(match, springy_file, chromium, tmp_path) as tab:
        tab.evaluate("overview.served.film.play = async (...told) => { window.watched = told; }")
        for position, event in [*((events[i], MATCH.events[i]) for i in goals), (between, None)]:
            x, y = at(tab, float(position))
            tab.mouse.move(*at(tab, max(float(position) - 0.2, 0.0)))
            tab.mouse.down()
            for step in range(1, 13):  # 0.6 s: the disk trails the finger
                tab.mouse.move(x + (step - 12) * 6.0, y)
                tab.wait_for_timeout(50)
            tab.mouse.up()
            tab.click("#play")
            until(tab, "window.watched")
            moment, title = tab.evaluate("watched")
            tab.evaluate("delete window.watched")
            clock, name = tab.text_content("#clock"), tab.text_content("#event")
            if event is None:
                assert moment == pytest.approx(float(surface.time_at(position)), abs=20.0)
                assert (title, name) == (clock, "")
            else:
                assert moment == event.time_s
                assert event.label in title
                assert title == name
            # finger, number and picture show one moment
            until(tab, "p.cursor < 0.001")
            moved = "getComputedStyle(document.getElementById('at-input')).transform"
            line = tab.evaluate(f"new DOMMatrix({moved}).e")
            assert line == pytest.approx(x - tab.locator("#canvas").bounding_box()["x"], abs=3.0)


def test_a_shared_link_lets_its_receiver_in_if_the_user_says_so(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        until(tab, "p.view")
        tab.evaluate("""() => {
            window.shared = [];
            navigator.share = async (what) => { shared.push(what); };
        }""")
        tab.click("#settings")
        tab.click("#share")
        until(tab, "shared.length === 1")
        tab.check("#share-access input")
        tab.click("#share")
        until(tab, "shared.length === 2")
        without, access = tab.evaluate("shared.map(({ url }) => url)")
        assert server.access.token not in without
        says(tab, "share", "for this computer only")
        for link, opens in ((without, False), (access, True)):
            context = chromium.new_context(viewport=PHONE)
            other = context.new_page()
            other.goto(link)
            if opens:
                until(other, "p.view")
            else:
                other.locator("#fault:not(:empty)").wait_for()
            context.close()


@not_in_firefox
def test_a_tap_on_a_mark_its_button_in_the_list_and_a_key_watch_it(
    match, springy_file, chromium, tmp_path
):
    with with_film(match, springy_file, chromium, tmp_path, has_touch=True) as tab:
        x, y = tab.evaluate("""() => {
            const { picture, view } = overview;
            const goal = view.events.find(({ label }) => label.startsWith("4-1"));
            const { x, lanes } = picture.geometry;
            return [picture.left + x(goal.position), picture.top + lanes[0]];
        }""")
        tab.touchscreen.tap(x, y)
        watched(tab)
        tab.click("#list")
        tab.get_by_role("button", name="Watch 67:30, goal, 4-1 Mbappé").click()
        watched(tab)
        tab.focus("#slider")
        tab.keyboard.press("Home")
        for _ in range(40):
            tab.keyboard.press("]")
            if tab.evaluate("overview.position") > GOAL - 1e-6:
                break
        tab.keyboard.press("Escape")
        until(tab, "p.cursor < 0.001")
        tab.keyboard.press("v")
        watched(tab)


def test_a_removed_film_is_reported_and_plays_once_restored(match, chromium, tmp_path):
    media = open_media(str(film_at(tmp_path)), 12.0 - 4050.0)
    with (
        served(match, plays=False, media=media) as server,
        page_of(server, chromium) as (tab, _),
    ):
        until(tab, "p.view && p.film")
        (tmp_path / "match.wav").rename(tmp_path / "elsewhere.wav")
        tab.evaluate("(position) => overview.navigation.to(position)", GOAL)
        tab.click("#play")
        says(tab, "fault", "the media file was removed: restore it")
        assert not tab.is_visible("#film")
        (tmp_path / "elsewhere.wav").rename(tmp_path / "match.wav")
        tab.click("#play")
        watched(tab)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])
def test_axe_finds_nothing_where_a_film_plays(
    match, springy_file, chromium, tmp_path, axe, scheme, size
):
    with with_film(match, springy_file, chromium, tmp_path, color_scheme=scheme) as tab:
        tab.set_viewport_size(size)
        assert violations(tab, axe) == []
        tab.click("#list")
        assert violations(tab, axe) == []
        tab.get_by_role("button", name="Watch 67:30, goal, 4-1 Mbappé").click()
        until(tab, "document.getElementById('film').open")
        assert violations(tab, axe) == []


def test_a_page_without_a_film_offers_none(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        until(tab, "p.view")
        assert not tab.is_visible("#play")
        tab.focus("#slider")
        tab.keyboard.press("v")
        assert not tab.is_visible("#film")
