"""The page of a timeline that grows, in a real Chromium."""

from __future__ import annotations

import contextlib
import functools
import threading
import time
import wave
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

import overview_dsp as ov
from overview_dsp.web.media import open_media
from overview_dsp.web.static_publisher import StaticPublisher
from tests.live.stepped_session import event
from tests.web.driving import at, until
from tests.web.serving import served
from tests.web.test_served_page import page_of, says


@pytest.fixture
def live():
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(events=[event(0, "period"), event(300, "foul", "a")], clock_s=800.0)
    return live


def kinds(word):
    return f"p.view.events.some(({{ kind }}) => kind === '{word}')"


def test_what_is_new_comes_when_no_hand_holds_the_disk(live, chromium):
    with (
        served(live.padded_snapshot(), plays=False, live=live) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, f"p.view && {kinds('foul')}")
        live.append(events=[event(900, "goal", "1-0 Parris")], clock_s=905.0)
        until(tab, kinds("goal"))
        says(tab, "live", "data until 15:05.0")
        says(tab, "live", "new: ")
        tab.mouse.move(*at(tab, 0.1))
        tab.mouse.down()
        until(tab, "p.input.active !== null")
        live.append(events=[event(1000, "red_card", "x")], clock_s=1000.0)
        says(tab, "live", "data until 16:40.0")
        time.sleep(1.0)
        assert not tab.evaluate("overview.view.events.some(({ kind }) => kind === 'red_card')")
        tab.mouse.up()
        until(tab, kinds("red_card"))
        live.layout = "so far"
        until(tab, "p.view.end_s === 1030")
        live.retract(event(900, "goal", "1-0 Parris"))
        until(tab, f"!{kinds('goal')}")
        says(tab, "live", "withdrawn goal Parris")
        # the kernel has the surface that was drawn: a tap at its end meets the newest
        tab.mouse.click(*at(tab, 0.999))
        until(tab, "p.cursor > 0.9")
        assert wrong == []


def test_a_button_visits_what_was_missed_since_the_release(live, chromium):
    with (
        served(live.padded_snapshot(), plays=False, live=live) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, f"p.view && p.live && {kinds('foul')}")
        assert tab.evaluate("overview.live.missed.button.hidden")
        gone = event(1100, "goal", "2-0")
        for one in (event(1000, "red_card", "x"), event(900, "goal", "1-0 Parris"), gone):
            live.append(events=[one], clock_s=1200.0)
        until(tab, kinds("red_card"))
        live.retract(gone)
        until(tab, "p.live.missed.events.some(({ kind }) => kind === 'withdrawn_goal')")
        tab.get_by_role("button", name="Feel what you missed: 3 events").click()
        place = "p.view.events.find(({ kind }) => kind === 'goal').position + 0.012"
        until(tab, f"Math.abs(p.input.position - ({place})) < 1e-6 && p.input.active === 'play'")
        says(tab, "announcement", "Parris")
        until(tab, "p.view.events.some(({ kind, position }) => kind === 'red_card' "
              "&& Math.abs(p.input.position - position - 0.012) < 1e-6)")  # fmt: skip
        says(tab, "announcement", "ed card")
        says(tab, "announcement", "ithdrawn goal")
        until(tab, "p.input.active === null")
        assert tab.evaluate("overview.live.missed.button.hidden")
        # a hand that was here has missed nothing, and takes the disk from a visit
        live.append(events=[event(1300, "goal", "2-0")], clock_s=1300.0)
        until(tab, "p.live.missed.events.length === 1")
        tab.mouse.click(*at(tab, 0.5))
        until(tab, "p.live.missed.button.hidden")
        live.append(events=[event(1400, "foul", "y"), event(1450, "foul", "z")], clock_s=1500.0)
        until(tab, "p.live.missed.events.length === 2")
        until(tab, "p.view.events.filter(({ kind }) => kind === 'foul').length === 3")
        tab.get_by_role("button", name="Feel what you missed").click()
        until(tab, "p.input.active === 'play'")
        tab.mouse.move(*at(tab, 0.6))
        tab.mouse.down()
        until(tab, "p.input.active === 'touch' && !p.live.missed.visiting")
        tab.mouse.up()
        until(tab, "p.input.active === null")
        assert wrong == []


def test_a_page_that_was_hidden_has_what_came_meanwhile(live, chromium):
    with (
        served(live.padded_snapshot(), plays=False, live=live) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, f"p.view && p.live && {kinds('foul')}")
        live.append(events=[event(900, "goal", "1-0")], clock_s=905.0)
        until(tab, f"{kinds('goal')} && p.live.pushed")
        hide = (
            "(state) => { Object.defineProperty(document, 'hidden', "
            "{ value: state, configurable: true }); "
            "document.dispatchEvent(new Event('visibilitychange')); }"
        )
        tab.evaluate(hide, True)
        live.append(events=[event(1000, "red_card", "x")], clock_s=1000.0)
        says(tab, "live", "data until 16:40.0")
        assert not tab.evaluate("overview.live.pushed")
        assert not tab.evaluate("overview.view.events.some(({ kind }) => kind === 'red_card')")
        tab.evaluate(hide, False)
        until(tab, kinds("red_card"))
        assert wrong == []


def test_values_and_now_of_a_series_that_grows_are_shown(chromium):
    live = ov.LiveTimeline("load", expected_duration_s=3600.0, unit="kW")
    with (
        served(live.padded_snapshot(), plays=False, live=live, preset="series") as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, "p.view && p.live")
        values = [(10.0 * n, 20.0 + n) for n in range(121)]
        live.append(intensity=values, clock_s=1200.0)
        until(tab, "Math.abs(p.view.now - 1 / 3) < 1e-6 && p.view.points?.value.length === 121")
        assert tab.evaluate("overview.view.points.value.at(-1)") == 140.0
        texts = "[...document.querySelectorAll('#canvas text')].map((one) => one.textContent)"
        until(tab, f"{texts}.includes('now')")
        tab.mouse.click(*at(tab, 1 / 6))
        until(tab, "Math.abs(p.position - 1 / 6) < 0.01")
        until(tab, "document.getElementById('slider').ariaValueText.includes('kW')")
        assert wrong == []


def test_a_page_of_a_hosts_disk_is_told_too(live, chromium):
    with (
        served(live.padded_snapshot(), live=live) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, "p.view")
        live.append(events=[event(900, "goal", "1-0 Parris")], clock_s=905.0)
        until(tab, kinds("goal"))
        assert wrong == []


def test_a_folder_that_is_replaced_is_followed_by_asking_for_it(live, chromium, tmp_path):
    folder = tmp_path / "site"
    published = StaticPublisher(live, ov.load_preset("football"), folder, print, interval_s=0.2)
    with hosted(folder) as address:
        tab = chromium.new_page()
        tab.goto(address)
        until(tab, f"p.view && p.live && {kinds('foul')}")
        live.append(events=[event(900, "goal", "1-0 Parris")], clock_s=905.0)
        until(tab, kinds("goal"))
        says(tab, "live", "data until 15:05.0")
        tab.mouse.click(*at(tab, 0.5))
        until(tab, "p.cursor > 0.4")
        tab.close()
    published.close()


def test_a_film_that_is_still_recorded_is_watched_where_it_has_come_to(live, chromium, tmp_path):
    film = tmp_path / "match.wav"

    def record(seconds):
        with wave.open(str(film), "wb") as file:
            file.setparams((1, 2, 8000, 0, "NONE", ""))
            file.writeframes(bytes(2 * 8000 * seconds))

    record(8)
    media = open_media(str(film), -295.0)
    with (
        served(live.padded_snapshot(), plays=False, live=live, media=media) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        until(tab, "p.view && p.film")
        tab.evaluate("overview.film.play(301, 'the foul').catch(() => {})")
        until(tab, "p.film.video.currentTime > 0.9")
        tab.evaluate("document.getElementById('film').close()")
        record(60)
        tab.evaluate("overview.film.play(340, 'later').catch(() => {})")
        until(tab, "p.film.video.currentTime > 39.9")
        assert wrong == []


@contextlib.contextmanager
def hosted(folder):
    """A web host of a folder."""
    handler = functools.partial(SimpleHTTPRequestHandler, directory=folder)
    handler.log_message = lambda *arguments: None
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()
