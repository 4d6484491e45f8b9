"""The page plays by itself: by its button, and as an address asks."""

from __future__ import annotations

import contextlib

import pytest

from tests.web.driving import PHONE, at, until
from tests.web.exported import opened_host


@contextlib.contextmanager
def cold(chromium, site, fragment="", **given):
    """A page that nobody has touched."""
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE, has_touch=True, **given)
        page = context.new_page()
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(f"{host.url}#{fragment}")
        until(page, "p.view")
        # how far the disk came: it turns back as soon as it has arrived
        page.evaluate("""() => {
            window.furthest = 0;
            const take = overview.update.bind(overview);
            overview.update = (told) => {
                furthest = Math.max(furthest, told.cursor);
                take(told);
            };
        }""")
        yield page
        context.close()
        assert faults == []


def test_play_sweeps_by_itself_pauses_and_goes_on(chromium, site):
    with cold(chromium, site) as page:
        page.evaluate("overview.settings.sweep = 5")
        page.click("#run")
        until(page, "p.input.active === 'play' && p.cursor > 0.2 && p.meters.strikes > 3")
        page.click("#run")
        paused = page.evaluate("overview.playback.player.done")
        assert page.text_content("#run") == "Play"
        until(page, "p.cursor < 0.05")
        page.click("#run")
        until(page, f"p.input.active === 'play' && p.position > {paused} / 5")
        until(page, "furthest > 0.97")
        until(page, "p.input.active === null && p.cursor < 0.01")
        assert page.text_content("#fault") == ""


def test_a_page_without_a_sound_output_says_so_and_its_disk_moves(chromium, site):
    with cold(chromium, site) as page:
        page.evaluate("""async () => {
            const { context } = overview.sound;
            await context.suspend(); // it may run before a touch
            const resume = context.resume.bind(context);
            const output = new Promise((there) => { window.plug = there; });
            context.resume = () => output.then(resume);
        }""")
        page.click("#run")
        until(page, "document.getElementById('fault').textContent.includes('no sound output')")
        until(page, "p.input.active === 'play' && p.cursor > 0.05")
        page.click("#run")
        until(page, "p.input.active === null && p.cursor < 0.01")
        page.mouse.move(*at(page, 0.5))
        page.mouse.down()  # it follows a finger, too
        until(page, "Math.abs(p.cursor - 0.5) < 0.01")
        page.evaluate("plug()")
        until(page, "document.getElementById('fault').textContent === ''")
        until(page, "p.meters?.clock > 0 && Math.abs(p.cursor - 0.5) < 0.01")


def test_a_finger_takes_the_disk_from_play(chromium, site):
    with cold(chromium, site) as page:
        page.click("#run")
        until(page, "p.input.active === 'play' && p.cursor > 0.05")
        page.mouse.move(*at(page, 0.5))
        page.mouse.down()
        until(page, "!p.playback.player.playing && p.input.active === 'touch'")
        page.mouse.up()
        until(page, "p.cursor < 0.01")


def test_a_link_plays_what_it_says_after_play_is_pressed_and_after_no_other_touch(chromium, site):
    with cold(chromium, site, "play=sweep:4:0.2:0.8") as page:
        until(page, "document.getElementById('run').classList.contains('offered')")
        page.touchscreen.tap(30, 500)
        page.locator("#title").click()
        until(page, "p.meters?.clock > 0 && p.input.active === null")
        page.wait_for_timeout(500)
        assert page.evaluate("[overview.playback.player.playing, overview.input.active]") == [
            False, None,
        ]  # fmt: skip
        assert page.evaluate("document.getElementById('run').classList.contains('offered')")
        page.evaluate("window.furthest = 0")
        page.click("#run")
        until(page, "p.input.active === 'play' && p.meters?.touching === 1")
        assert page.evaluate("overview.playback.player.gesture") == {
            "name": "sweep", "seconds": 4, "from": 0.2, "to": 0.8,
        }  # fmt: skip
        assert not page.evaluate("document.getElementById('run').classList.contains('offered')")
        until(page, "furthest > 0.78")
        until(page, "p.input.active === null")


@pytest.mark.parametrize(
    ("fragment", "says"),
    [
        ("at=goal:2", "37:30, goal, 2-1 Griezmann"),
        ("at=own_goal", "17:30, 1-0 own goal"),
        ("at=67:30", "67:30, goal, 4-1"),
        ("window=3000:4500&at=goal:4", "67:30, goal, 4-1"),
        ("at=goal:4&window=3000:4500&play=sweep:4&preset=football", "67:30, goal, 4-1"),
    ],
)
def test_a_link_goes_to_a_position(chromium, site, fragment, says):
    with cold(chromium, site, fragment) as page:
        until(page, "p.input.active === 'keys'")
        until(page, f"document.getElementById('slider').ariaValueText.includes('{says}')")


@pytest.mark.parametrize(
    ("fragment", "named"),
    [
        ("at=goal:99", ["goal:99"]),
        ("at=nothing", ["nothing"]),
        ("at=99:00", ["99:00", "after the end"]),
        ("play=sweep:0", ["sweep:0"]),
        ("play=dance", ["dance"]),
        ("window=5:2", ["5:2", "START:END"]),
        ("window=60", ["60", "START:END"]),
        ("window=0:9999", ["0:9999", "5880"]),
        ("preset=crowd", ["crowd", "football"]),
        ("window=3000:4500&at=goal:1", ["goal:1", "27:30", "outside of the window"]),
        ("preset=crowd&window=x&at=corner&play=dance", ["crowd", "x", "corner", "dance"]),
    ],
)
def test_what_a_link_gets_wrong_is_named_and_the_page_works(chromium, site, fragment, named):
    with cold(chromium, site, fragment) as page:
        until(page, "document.getElementById('fault').textContent !== ''")
        until(
            page,
            f"{named!r}.every((one) => document.getElementById('fault').textContent.includes(one))",
        )
        page.mouse.move(*at(page, 0.3))
        page.mouse.down()
        until(page, "Math.abs(p.cursor - 0.3) < 0.01")


def test_share_gives_this_place_as_a_link(chromium, site):
    with cold(chromium, site, permissions=["clipboard-read", "clipboard-write"]) as page:
        page.evaluate("""() => {
            window.shared = [];
            navigator.share = async (what) => { shared.push(what); };
        }""")
        page.focus("#slider")
        for _ in range(5):
            page.keyboard.press("]")
        named = page.evaluate("[overview.currentEvent.kind, overview.currentEvent.time_s]")
        page.click("#settings")
        page.click("#share")
        until(page, "shared.length === 1")
        assert "play=" not in page.evaluate("shared[0].url")
        assert "token" not in page.evaluate("shared[0].url")
        assert not page.is_visible("#share-access")  # a static folder needs none
        # its words, which push the rows below, have gone
        until(page, "document.getElementById('share').textContent === 'Share'")
        page.check("#share-play")
        page.click("#share")
        until(page, "shared.length === 2")
        link = page.evaluate("shared[1].url")
        page.goto("about:blank")
        page.goto(link)
        until(page, "p.view && p.input.active === 'keys'")
        assert page.evaluate("[overview.currentEvent.kind, overview.currentEvent.time_s]") == named
        until(page, "document.getElementById('run').classList.contains('offered')")  # and it plays


def test_a_shared_place_between_events_and_a_window_are_where_they_were(chromium, site):
    with cold(chromium, site) as page:
        page.evaluate("""() => {
            window.shared = [];
            navigator.share = async (what) => { shared.push(what); };
        }""")
        page.evaluate("overview.viewState.zoom(1, 0.5)")
        until(page, "p.view.zoom === 1")
        page.mouse.move(*at(page, 0.42))
        page.mouse.down()
        page.mouse.move(*at(page, 0.47), steps=5)
        page.mouse.up()
        moment, start, end = page.evaluate(
            "[overview.moment, overview.view.start_s, overview.view.end_s]"
        )
        page.click("#settings")
        page.click("#share")
        until(page, "shared.length === 1")
        link = page.evaluate("shared[0].url")
        page.goto("about:blank")
        page.goto(link)
        until(page, "p.view && p.view.zoom === 1 && p.input.active === 'keys'")
        assert page.evaluate("[overview.view.start_s, overview.view.end_s]") == [start, end]
        assert page.evaluate("overview.moment") == pytest.approx(moment, abs=0.5)  # whole seconds


def test_a_link_opened_in_the_same_page_is_followed(chromium, site):
    with cold(chromium, site, "window=0:1960") as page:
        until(page, "p.view.zoom === 1")
        page.evaluate(
            "location.hash = 'at=goal:4'"
        )  # outside of the window, which it does not name
        until(page, "p.view.zoom === 0 && p.input.active === 'keys'")
        until(page, "document.getElementById('slider').ariaValueText.includes('4-1')")
        page.evaluate("location.hash = 'at=corner'")
        until(page, "document.getElementById('fault').textContent.includes('corner')")
        page.evaluate("location.hash = 'at=goal:2'")
        until(page, "document.getElementById('fault').textContent === ''")


def test_picture_and_words_are_there_before_the_sound(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        held: list = []
        page.route("**/kernel.deflated", lambda route: held.append(route))
        page.goto(host.url)
        until(page, "p.view && document.querySelectorAll('#canvas path').length > 30")
        until(page, "document.getElementById('hint').textContent.includes('Loading')")
        assert page.text_content("#window") == "World Cup final, Moscow, 15 July 2018"
        page.mouse.move(*at(page, 0.4))
        page.mouse.down()  # a finger that is already exists is felt once the sound is
        while not held:
            page.wait_for_timeout(20)
        assert page.evaluate("overview.sound.node") is None
        held[0].continue_()
        until(page, "p.meters?.touching === 1 && Math.abs(p.cursor - 0.4) < 0.01")
        context.close()


def test_buttons_wait_for_the_data_and_a_failed_start_offers_another(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        held: list = []
        page.route("**/data/timeline.json", lambda route: held.append(route))
        page.goto(host.url)
        while not held:
            page.wait_for_timeout(20)
        buttons = page.locator("nav button")
        assert all(buttons.nth(i).is_disabled() for i in range(buttons.count()))
        assert "Loading" in page.text_content("#hint")
        page.route("**/data/timeline.json", lambda route: route.abort())
        held[0].abort()
        again = page.get_by_role("button", name="Try again")
        again.wait_for()
        page.unroute("**/data/timeline.json")
        again.click()
        until(page, "p.view && p.isStarted === false")
        assert all(buttons.nth(i).is_enabled() for i in range(buttons.count()))
        context.close()
