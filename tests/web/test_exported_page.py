"""The exported page in a real Chromium: a finger, a wrist, keys, a screen reader, no network."""

from __future__ import annotations

import base64
import hashlib
import itertools
import json
import math
import shutil
import zlib
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

import overview_dsp as ov
from overview_dsp.live.output.stream import connect, run_block
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.units import HALF_TURN
from overview_dsp.web.sound_data import make_patch, pack, window_bytes
from tests.web.driving import DESKTOP, PHONE, at, not_in_firefox, until, violations, watch
from tests.web.exported import HELD, opened_host
from tests.web.layouts import FAULTS, settled
from tests.web.null_sink import null_sink

RATE = 48_000
BLOCK = 128


@pytest.fixture
def opened(chromium, site):
    """A page on a phone, ready, and its faults, of which there may be none."""
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE, has_touch=True)
        page = context.new_page()
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: said.type == "error" and faults.append(said.text))
        page.goto(host.url)
        until(page, "p.view")
        yield page
        told = page.text_content("#fault")
        context.close()
    assert faults == []
    assert told == ""


@pytest.fixture(scope="session")
def starts(match, springy_football):
    """Where each event of the page starts."""
    return build_surface(match, springy_football).edges[:, 0].tolist()


def test_a_drag_sounds_a_release_recoils_and_a_tap_steps(opened, starts):
    page = opened
    page.evaluate("""() => {
        window.loudest = [0, 0];
        const take = overview.update.bind(overview);
        overview.update = (told) => {
            loudest[0] = Math.max(loudest[0], told.peakClick);
            loudest[1] = Math.max(loudest[1], told.peakTactor);
            take(told);
        };
    }""")
    page.mouse.move(*at(page, 0.02))
    page.mouse.down()
    page.mouse.move(*at(page, 0.9), steps=60)
    until(page, "Math.abs(p.cursor - 0.9) < 0.01")
    assert page.evaluate("loudest[0] > 0.01 && loudest[1] > 0.01")
    strikes = page.evaluate("overview.meters.strikes")
    assert strikes > 15
    page.mouse.up()
    until(page, "p.cursor < 0.001 && p.meters.touching === 0")
    assert page.evaluate("overview.meters.strikes") > strikes
    # every event up to a tap is behind the disk before it recoils
    half_time = page.evaluate(
        "overview.view.events.find(({ label }) => label === 'half-time').position"
    )
    watch(page, half_time, starts)
    page.mouse.click(*at(page, half_time))
    until(page, "nearest < 0.005")
    until(page, "p.cursor < 0.001")
    assert page.evaluate("furthest") < half_time + 0.005


def test_an_event_that_keys_go_to_is_felt_and_the_disk_is_at_it(opened):
    page = opened
    page.evaluate("""() => {
        window.felt = [];
        const take = overview.update.bind(overview);
        overview.update = (told) => {
            felt.push(...told.newStrikes.map(({ event }) => event));
            take(told);
        };
    }""")
    page.keyboard.press("Tab")
    # fouls, a near miss, and the first goal: narrower than the backlash, which a move has
    for number in range(1, 7):
        page.keyboard.press("]")
        until(page, f"felt.includes({number})")
        assert page.evaluate(f"overview.view.events[{number}].position === overview.position")
        until(page, "Math.abs(p.cursor - p.position) < 0.001")
    page.keyboard.press("+")
    until(page, "p.view.zoom === 1 && p.meters.changesWaiting === 0")
    until(page, "Math.abs(p.cursor - p.position) < 0.001")


@not_in_firefox
def test_sound_comes_with_the_first_touch_alone(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        page.add_init_script("""addEventListener("pointerdown", () => {
            window.began = performance.now();
            window.before = [overview.sound.context.state, overview.meters];
        }, { capture: true, once: true });""")
        page.goto(host.url)
        # to be asked anything counts as a touch, so it is left alone until one comes
        page.wait_for_load_state("networkidle")
        page.wait_for_timeout(1500)
        page.mouse.move(200, 300)
        page.mouse.down()
        until(page, "p.meters?.clock > 0 && p.meters.touching === 1")
        assert page.evaluate("before") == ["suspended", None]
        took = page.evaluate("performance.now() - began")
        print(f"\nfirst sound {took:.0f} ms after the first touch")
        page.mouse.up()
        context.close()


def test_keys_alone_reach_everything(opened, starts):
    page = opened
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "slider"

    def says():
        return page.get_attribute("#slider", "aria-valuetext")

    for _ in range(3):
        page.keyboard.press("]")
    until(page, "document.getElementById('slider').ariaValueText.includes('near miss')")
    page.keyboard.press("End")
    until(page, "document.getElementById('slider').ariaValueText.includes('full time')")
    until(page, "p.cursor > 0.99")
    assert float(page.input_value("#slider")) == 100
    for _ in range(8):
        page.keyboard.press("[")
    until(page, "document.getElementById('slider').ariaValueText.includes('4-1 Mbapp')")
    assert says().startswith("67:30, goal")
    goal = page.evaluate("overview.position")
    page.keyboard.press("Shift+ArrowLeft")
    until(page, f"Math.abs(p.position - {goal - 0.01}) < 0.002")
    page.keyboard.press("PageDown")
    until(page, f"Math.abs(p.position - {goal - 0.11}) < 0.002")
    page.keyboard.press("Escape")
    until(page, "p.meters.touching === 0 && p.cursor < 0.001")
    watch(page, goal - 0.11, starts)
    page.keyboard.press(" ")
    until(page, "nearest < 0.005")
    until(page, "p.cursor < 0.001")
    assert page.evaluate("furthest") < goal - 0.105
    page.keyboard.press("+")
    until(page, "p.view.zoom === 1")
    reached = set()
    for _ in range(6):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id"))
    assert {"out", "list", "run"} <= reached
    page.focus("#settings")
    page.keyboard.press("Enter")
    assert page.evaluate("document.getElementById('dialog').open")
    page.keyboard.press("Escape")
    assert not page.evaluate("document.getElementById('dialog').open")


@pytest.mark.parametrize("way", ["t", "button"])
def test_a_tap_and_a_release_have_a_key_and_a_button(opened, starts, way):
    page = opened
    page.focus("#slider")
    for _ in range(3):
        page.keyboard.press("PageUp")
    until(page, "p.meters?.touching === 1 && p.cursor > 0.29")

    def do(key, name):
        if way == "t":
            page.focus("#slider")
            page.keyboard.press(key)
            return
        page.click("#settings")
        page.get_by_role("button", name=name, exact=True).click()
        assert not page.evaluate("document.getElementById('dialog').open")

    do("Escape", "Release")
    until(page, "p.meters.touching === 0 && p.cursor < 0.001")
    watch(page, 0.3, starts)
    do("t", "Tap")
    until(page, "nearest < 0.01")
    until(page, "p.input.active === null && p.cursor < 0.001")
    assert page.text_content("#announcement").startswith("Tap at ")


def test_the_focus_stays_on_a_button_or_the_slider_when_zooming(opened):
    page = opened
    focused = "document.activeElement.id"
    page.focus("#in")
    page.keyboard.press("Enter")
    until(page, "p.view.zoom === 1")
    page.keyboard.press("Enter")
    until(page, "document.getElementById('announcement').textContent === 'No more detail'")
    assert page.evaluate(focused) == "in"
    for button in ("whole", "out"):
        page.focus(f"#{button}")
        page.keyboard.press("Enter")
        until(page, "p.view.zoom === 0")
        assert page.evaluate(focused) == "slider"
        page.keyboard.press("+")
        until(page, "p.view.zoom === 1")


@not_in_firefox
def test_a_wrist_sweeps_the_whole_timeline_face_up_to_face_down(opened):
    page = opened
    client = page.context.new_cdp_session(page)

    def turn(degrees):
        # beyond upright the platform tells the roll from the back: beta turns over
        beta, gamma = (0, degrees) if degrees < 90 else (-180, degrees - 180)
        client.send(
            "DeviceOrientation.setDeviceOrientationOverride",
            {"alpha": 0, "beta": beta, "gamma": gamma},
        )

    turn(0)
    page.click("#settings")
    page.click("#twist")
    until(page, "p.input.active === 'twist'")
    seen = []
    for degrees in range(0, 181, 6):
        turn(degrees)
        page.wait_for_timeout(25)
        seen.append(page.evaluate("overview.position"))
    until(page, "p.cursor > 0.995")
    assert seen[0] < 0.01
    assert np.all(np.diff(seen) >= -1e-9)
    assert np.max(np.diff(seen)) < 0.1
    page.click("#settings")
    page.click("#twist")
    until(page, "p.input.active === null && p.cursor < 0.001")


def roll(page, beta, gamma):
    return page.evaluate(
        "async ([b, g]) => (await import('./modules/twist.js')).rollOf(b, g)", [beta, gamma]
    )


@pytest.mark.parametrize("pitch", [-60, 0, 40])
def test_the_roll_is_the_turn_about_the_long_axis(opened, pitch):
    """Against the rotation matrices of the W3C's definition, at any pitch."""

    def axes(beta, gamma):
        b, g = math.radians(beta), math.radians(gamma)
        x = np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
        y = np.array([[math.cos(g), 0, math.sin(g)], [0, 1, 0], [-math.sin(g), 0, math.cos(g)]])
        return x @ y

    for gamma in (-80, -20, 0, 35, 89):
        up = axes(pitch, gamma)[2]  # the world's up along the phone's axes
        assert roll(opened, pitch, gamma) == pytest.approx(math.atan2(-up[0], up[2]), abs=1e-9)
    assert abs(roll(opened, 180, 0)) == pytest.approx(math.pi)
    assert math.isnan(roll(opened, 90, 0))


def test_the_start_can_be_calibrated_and_either_side_will_do(opened):
    position = "async ([r, s]) => (await import('./modules/twist.js')).positionOfRoll(r, s)"
    for start in (0.0, 0.5, -3.0):
        for turn in (0.0, 1.0, 3.0):
            for side in (1, -1):
                away = opened.evaluate(position, [start + side * turn, start])
                assert away == pytest.approx(turn / math.pi)


HANDS = """async (scene) => {
    const { CombinedInput } = await import("./modules/combined_input.js");
    const { Strokes } = await import("./modules/strokes.js");
    const events = [];
    const now = performance.now.bind(performance);
    let time = 0;
    performance.now = () => time;
    const clock = {
        rate: 48000,
        sampleAt: (at) => Math.round(at * 48 + 1440),
        rendering: (at) => Math.round(at * 48),
    };
    const send = (position, touching, sample) =>
        events.push([sample < 0 ? Math.round(time * 48) : sample, position, touching]);
    const input = new CombinedInput(new Strokes(clock, send));
    for (const [at, method, ...given] of scene) {
        time = at;
        input[method](...given, at);
    }
    performance.now = now;
    return events;
}"""


def heard(events, timeline, preset, frames=2 * RATE):
    """What the native engine makes of a hand's events."""
    engine = ov.Engine(preset, timeline, seed=1)
    engine.prepare(RATE, BLOCK)
    connect(engine, None)
    for sample, position, touching in events:
        engine.control(position * HALF_TURN, touching, sample)
    out = np.zeros((frames // BLOCK * BLOCK, 2), np.float32)
    for start in range(0, len(out), BLOCK):
        run_block(engine, out[start : start + BLOCK])
    return out


def beyond(out, low_hz):
    """The loudest of what lies above a frequency, dB of full scale."""
    spectrum = np.fft.rfft(out, axis=0)
    spectrum[np.fft.rfftfreq(len(out), 1 / RATE) < low_hz] = 0
    return 20 * np.log10(max(np.abs(np.fft.irfft(spectrum, axis=0)).max(), 1e-9))


@pytest.fixture(scope="module")
def bare():
    """Nothing to strike: whatever clicks is a fault."""
    curve = ov.Intensity(np.array([0.0, 60.0]), np.array([0.3, 0.3]))
    return ov.Timeline("bare", 60.0, intensity=curve)


def test_a_finger_that_comes_down_while_a_wrist_holds_still_is_not_heard(
    opened, bare, rigid_football
):
    twist = [[10 + 16 * i, "moveTo", "twist", 0.3 + 1e-7 * (i % 2)] for i in range(110)]
    touch = [[700, "moveTo", "touch", 0.8], [1100, "release", "touch"]]
    alone = heard(opened.evaluate(HANDS, twist), bare, rigid_football)
    both = heard(
        opened.evaluate(HANDS, sorted(twist + touch, key=lambda e: e[0])), bare, rigid_football
    )
    difference = np.abs(both - alone).max()
    print(f"\ntouch down and up in a still twist: {20 * np.log10(max(difference, 1e-9)):.0f} dB")
    assert difference < 1e-3  # -60 dB
    step = heard([*opened.evaluate(HANDS, twist[:40]), (33_600, 0.8, True)], bare, rigid_football)
    assert np.abs(step - alone).max() > 0.03  # what a jump would be


def test_hands_change_without_a_click_in_the_middle_of_a_movement(opened, bare, football):
    silent = football.with_value("texture.gain_db", -90.0)  # else the grain is all there is
    moving = [[10 + 16 * i, "moveTo", "twist", 0.1 + 0.004 * i] for i in range(120)]
    fingers = [[700 + 16 * i, "moveTo", "touch", 0.85 + 0.002 * i] for i in range(30)]
    scene = sorted([*moving, *fingers, [1200, "release", "touch"]], key=lambda e: e[0])
    events = opened.evaluate(HANDS, scene)
    positions = np.array([position for _, position, _ in events])
    assert np.all(np.diff([sample for sample, *_ in events]) >= 0)
    assert np.abs(np.diff(positions)).max() < 0.002  # in steps of 2 ms
    assert np.all(np.diff(positions) >= -1e-12)
    out = heard(events, bare, silent)
    twisted = opened.evaluate(HANDS, moving)
    jumping = [(at, position + 0.35 * (at > 35_000), held) for at, position, held in twisted]
    click, none, jump = (
        beyond(samples[RATE // 2 :], 2000)
        for samples in (out, heard(twisted, bare, silent), heard(jumping, bare, silent))
    )
    print(f"\nabove 2 kHz: {click:.0f} dB, without a change {none:.0f}, with a jump {jump:.0f}")
    assert click < -60
    assert click < none + 2.0 < jump


def test_the_wrist_takes_up_where_the_finger_was(opened):
    scene = [
        [0, "moveTo", "twist", 0.2],
        [100, "moveTo", "touch", 0.6],
        *[[100 + 10 * i, "moveTo", "touch", 0.6 + 0.005 * i] for i in range(1, 61)],
        [800, "release", "touch"],
        *[[800 + 10 * i, "moveTo", "twist", 0.2 + 0.01 * i] for i in range(1, 71)],
        *[[1500 + 10 * i, "moveTo", "twist", 0.9 - 0.01 * i] for i in range(1, 41)],
        [2000, "release", "twist"],
    ]
    events = opened.evaluate(HANDS, scene)
    assert [touching for *_, touching in events].count(False) == 1
    assert events[0][1] == 0.2
    touched = [position for sample, position, _ in events if sample < 40_000]
    assert max(touched) == pytest.approx(0.65, abs=0.01)  # 0.2 + 0.3 + half as much made up
    assert events[-2][1] == pytest.approx(0.5, abs=1e-9)  # caught up


def test_the_disk_is_released_when_the_page_is_left(opened):
    page = opened
    page.mouse.move(*at(page, 0.4))
    page.mouse.down()
    until(page, "p.meters?.touching === 1")
    page.evaluate("window.dispatchEvent(new Event('pagehide'))")
    until(page, "p.meters.touching === 0 && p.cursor < 0.001")
    page.mouse.up()


def hide(page):
    """As a phone does that goes dark or to another page."""
    page.evaluate("""() => {
        Object.defineProperty(document, "hidden", { value: true, configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
    }""")


def test_hiding_the_page_lets_the_disk_go(opened):
    page = opened
    page.mouse.move(*at(page, 0.4))
    page.mouse.down()
    until(page, "p.meters?.touching === 1")
    hide(page)
    until(page, "(await p.sound.readState()).touching === 0")
    page.mouse.up()


def test_a_phone_call_releases_the_disk_is_reported_once_and_a_touch_resumes(opened):
    page = opened
    page.evaluate("""() => {
        window.said = [];
        const fault = document.getElementById("fault");
        new MutationObserver(() => said.push(fault.textContent)).observe(fault, {
            childList: true, characterData: true, subtree: true,
        });
    }""")
    page.mouse.move(*at(page, 0.4))
    page.mouse.down()
    until(page, "Math.abs(p.cursor - 0.4) < 0.01")
    page.evaluate("overview.sound.context.suspend()")  # as the system does
    until(page, "p.input.active === null && said.length > 0")
    page.mouse.move(*at(page, 0.6), steps=5)
    page.mouse.up()
    page.wait_for_timeout(200)
    assert page.evaluate("said") == ["the sound was interrupted: touch to continue"]
    page.mouse.move(*at(page, 0.2))
    page.mouse.down()
    until(page, "p.sound.running && Math.abs(p.cursor - 0.2) < 0.01 && p.meters.touching === 1")
    page.mouse.up()
    until(page, "p.meters.touching === 0 && p.cursor < 0.001")
    assert page.evaluate("said.at(-1)") == ""
    # one that ended while the page was away needs no touch
    page.evaluate("overview.sound.context.suspend()")
    until(page, "said.at(-1) !== ''")
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    until(page, "p.sound.running && said.at(-1) === ''")


def test_a_phone_that_is_turned_under_a_finger_goes_on(opened):
    page = opened
    page.mouse.move(*at(page, 0.4))
    page.mouse.down()
    until(page, "Math.abs(p.cursor - 0.4) < 0.01")
    for width, height in ((844, 390), (390, 844), (844, 390)):
        page.set_viewport_size({"width": width, "height": height})
        drawn = "document.getElementById('canvas').getBoundingClientRect().width"
        until(page, f"innerWidth === {width} && p.picture.geometry.width === {drawn}")
        settled(page)
        assert page.evaluate(FAULTS) == []
    page.mouse.move(*at(page, 0.7), steps=10)
    until(page, "Math.abs(p.cursor - 0.7) < 0.01")
    x, drawn = page.evaluate("""() => {
        const { x } = document.getElementById("cursor").getBoundingClientRect();
        return [x, overview.picture.left + overview.picture.geometry.x(overview.reading)];
    }""")
    assert x == pytest.approx(drawn, abs=1.5)  # the line is the finger's, the disk trails it
    page.mouse.up()
    until(page, "p.meters.touching === 0 && p.cursor < 0.001")


def test_a_twist_holds_on_where_nobody_looks_and_keeps_the_screen_from_locking(opened):
    page = opened
    page.evaluate("""() => {
        window.locks = 0;
        const request = async () => {
            window.locks += 1;
            return { release: () => { window.locks -= 1; } };
        };
        Object.defineProperty(navigator, "wakeLock", { value: { request } });
    }""")
    page.click("#settings")
    page.click("#twist")
    # a phone reports its orientation all the time
    page.evaluate("""() => setInterval(() => dispatchEvent(
        new DeviceOrientationEvent("deviceorientation", { alpha: 0, beta: 0, gamma: 60 })
    ), 50)""")
    until(page, "p.input.active === 'twist' && Math.abs(p.cursor - 1 / 3) < 0.02")
    until(page, "window.locks === 1")
    hide(page)
    page.wait_for_timeout(200)
    assert page.evaluate("overview.sound.readState().then(({touching}) => touching)") == 1
    page.evaluate("overview.toggleTwist()")
    until(page, "(await p.sound.readState()).touching === 0 && window.locks === 0")


def test_zooming_shows_the_windows_and_comes_back_to_the_whole(opened):
    page = opened
    page.focus("#slider")
    for _ in range(20):
        page.keyboard.press("]")
    here = page.evaluate("overview.moment")
    page.keyboard.press("+")
    until(page, "p.view.zoom === 1")
    assert page.evaluate("overview.moment") == pytest.approx(here, abs=1)
    start, end = page.evaluate("[overview.view.start_s, overview.view.end_s]")
    assert start < here < end
    until(page, "p.meters.changesWaiting === 0 && Math.abs(p.cursor - p.position) < 0.003")
    page.keyboard.press("Home")
    page.keyboard.press("ArrowLeft")  # beyond the window
    until(page, f"p.view.start_s < {start - 100}")
    page.click("#out")
    until(page, "p.view.number === 0")
    until(page, "p.meters.changesWaiting === 0")


def test_moments_and_places_of_a_page_are_those_of_the_surface(opened, match, springy_football):
    page = opened
    for zoom in (0, 1):
        if zoom:
            page.evaluate("overview.viewState.zoom(1, 0.4)")
            until(page, "p.view.zoom === 1")
        start, end = page.evaluate("[overview.view.start_s, overview.view.end_s]")
        part = match.window(start, end) if zoom else match
        surface = build_surface(part, springy_football)
        assert not surface.angle_map.is_linear
        even = np.linspace(0.0, 1.0, 41)
        times = start + even * (end - start)
        found = page.evaluate("all => all.map((at) => overview.positionAt(at))", times.tolist())
        assert found == pytest.approx(surface.position_of(times - start), abs=1e-9)
        there = page.evaluate(
            "async (all) => {"
            " const { secondsAt } = await import('./modules/angle_map.js');"
            " return all.map((position) => secondsAt(overview.view, position)); }",
            even.tolist(),
        )
        assert there == pytest.approx(start + surface.time_at(even), abs=1e-6)
        # what is read out where the hand is
        marks = np.concatenate(([0.0], surface.angle_map.events, [1.0]))
        widest = int(np.diff(marks).argmax())  # near an event its own moment counts
        position = float(marks[widest : widest + 2].mean())
        page.evaluate("overview.view.tolerance = 1e-6")
        page.evaluate("(position) => overview.navigation.to(position)", position)
        minutes, seconds = divmod(round(start + float(surface.time_at(position))), 60)
        assert page.evaluate("overview.moment") == pytest.approx(start + surface.time_at(position))
        said = "document.getElementById('slider').ariaValueText"
        until(page, f"{said}.startsWith('{minutes}:{seconds:02d}')")
        # the marks lie where the events are felt
        positions = page.evaluate("overview.view.events.map(({ position }) => position)")
        assert positions == surface.angle_map.events.tolist()
    page.click("#settings")
    assert "time is stretched" in page.text_content("#about")


def test_the_names_of_a_match_stand_beside_the_marks_of_their_goals(opened):
    page = opened
    assert page.text_content("#title") == "France 4–2 Croatia"
    assert page.text_content("#window") == "World Cup final, Moscow, 15 July 2018"
    parts = "[...document.getElementById('title').childNodes].map((one) => one.textContent)"
    assert [one.strip() for one in page.evaluate(parts)[:4]] == ["", "France", "4–2", ""]
    colour = "getComputedStyle(document.querySelectorAll('#title svg')[{}].firstChild).fill"
    assert page.evaluate(colour.format(0)) != page.evaluate(colour.format(1))


@pytest.mark.parametrize(("width", "are_named"), [(390, False), (768, True), (1440, True)])
def test_goals_have_their_scores_and_in_wide_pictures_their_names(opened, match, width, are_named):
    opened.set_viewport_size({"width": width, "height": 900})
    drawn_width = "document.getElementById('canvas').getBoundingClientRect().width"
    until(opened, f"p.picture.geometry.width === {drawn_width}")
    boxes = opened.evaluate("""[...document.querySelectorAll("#canvas text")].map((one) => {
        const { left, right, top, bottom } = one.getBoundingClientRect();
        return [one.textContent, left, right, top, bottom];
    })""")
    goals = [event.label.split(" ", 1) for event in match.events if "goal" in event.kind]
    drawn = {box[0]: box for box in boxes}
    full = {f"{score} {name}".replace("-", "\u2013", 1) for score, name in goals}
    scores = {score.replace("-", "\u2013") for score, _ in goals}
    shown = {text.split()[0] for text in drawn if "\u2013" in text}
    assert shown == scores if are_named else shown < scores  # a narrow one has no room for all
    assert bool(full & drawn.keys()) == are_named
    labels = [box for text, box in drawn.items() if "\u2013" in text]
    for (_, left, right, top, bottom), other in itertools.combinations(labels, 2):
        apart = right <= other[1] or other[2] <= left
        assert apart or bottom <= other[3] or other[4] <= top


def test_the_page_says_where_you_released_it_and_not_where_play_ended(opened):
    def is_told():
        return opened.evaluate("getComputedStyle(document.getElementById('let-go')).visibility")

    assert is_told() == "hidden"
    opened.mouse.move(*at(opened, 0.4))
    opened.mouse.down()
    until(opened, "p.input.active === 'touch' && p.cursor > 0.3")
    assert is_told() == "hidden"
    opened.mouse.up()
    until(opened, "document.getElementById('let-go').style.visibility === 'visible'")
    assert is_told() == "visible"
    assert opened.text_content("#when").endswith(", where you released it")
    opened.evaluate("overview.settings.sweep = 2")
    opened.click("#run")
    until(opened, "p.lastInput === 'play'")  # as drawn
    assert is_told() == "hidden"
    until(opened, "p.input.active === null && p.cursor < 0.01")
    assert is_told() == "hidden"


def test_a_phone_that_cannot_vibrate_says_so(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE, has_touch=True)
        page = context.new_page()
        page.add_init_script("delete Navigator.prototype.vibrate")
        page.goto(host.url)
        until(page, "p.view")
        page.click("#settings")
        motor = page.get_by_role("radio", name="motor")
        assert motor.is_disabled()
        assert "cannot vibrate" in page.text_content("#motor")
        context.close()


def test_a_right_click_releases_nothing(opened):
    page = opened
    page.focus("#slider")
    page.keyboard.press("]")
    until(page, "p.meters?.touching === 1")
    page.mouse.click(*at(page, 0.5), button="right")
    page.wait_for_timeout(200)
    assert page.evaluate("[overview.input.active, overview.meters.touching]") == ["keys", 1]
    page.mouse.move(*at(page, 0.4))
    page.mouse.down()
    page.mouse.down(button="right")
    page.mouse.up(button="right")
    page.wait_for_timeout(200)
    assert page.evaluate("[overview.input.active, overview.meters.touching]") == ["touch", 1]
    page.mouse.up()
    until(page, "p.input.active === null")


def test_keys_work_after_a_drag_with_a_mouse(opened):
    page = opened
    page.mouse.move(*at(page, 0.2))
    page.mouse.down()
    page.mouse.move(*at(page, 0.5), steps=5)
    page.mouse.up()
    assert page.evaluate("document.activeElement.id") == "slider"
    frame = "getComputedStyle(document.getElementById('stage')).boxShadow"
    assert page.evaluate(frame) == "none"
    page.keyboard.press("+")
    until(page, "p.view.zoom === 1")
    assert page.evaluate(frame) != "none"  # keys show where the focus is


def test_settings_are_remembered_and_speech_and_clicks_are_apart(opened):
    page = opened
    page.evaluate("""() => {
        window.said = [];
        speechSynthesis.speak = (one) => said.push(one.text);
    }""")
    page.click("#settings")
    page.get_by_role("checkbox", name="Speech").check()
    page.get_by_role("checkbox", name="Clicks").uncheck()
    page.get_by_text("Done").click()
    page.focus("#slider")
    for _ in range(6):
        page.keyboard.press("]")
    until(page, "said.some((text) => text.includes('own goal, Mand'))")
    page.reload()
    until(page, "p.view")
    kept = page.evaluate("overview.settings")
    assert (kept["speech"], kept["clicks"], kept["vibration"]) == (True, False, True)


def test_it_works_without_a_network_once_loaded(chromium, site):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        page.goto(host.url)
        until(page, "p.view")
        page.evaluate("navigator.serviceWorker.ready.then(() => null)")
        page.evaluate("overview.sound.context.resume()")  # as it is where a page may sound at once
        page.mouse.click(*at(page, 0.5))
        listed = json.loads((site / "files.js").read_text()[13:-2])
        count = 2 + len(listed["page"]) + len(listed["more"])
        kept = "(await (await caches.open((await caches.keys())[0])).keys()).length"
        until(page, f"{kept} >= {count}")
    # the host is gone
    page.reload()
    until(page, "p.view")
    page.mouse.move(*at(page, 0.1))
    page.mouse.down()
    page.mouse.move(*at(page, 0.6), steps=30)
    until(page, "Math.abs(p.cursor - 0.6) < 0.01 && p.meters.strikes > 5")
    page.mouse.up()
    page.click("#in")
    until(page, "p.view.zoom === 1")
    context.close()


SMALL = {"width": 320, "height": 480}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [SMALL, PHONE, DESKTOP], ids=["small", "phone", "desktop"])
def test_axe_finds_nothing(chromium, site, axe, scheme, size):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=size, color_scheme=scheme)
        page = context.new_page()
        page.goto(f"{host.url}#play=sweep:5")
        until(page, "p.view && document.getElementById('run').classList.contains('offered')")
        assert violations(page, axe) == []
        page.click("#run")
        until(page, "p.playback.player.playing && p.cursor > 0.05")
        assert violations(page, axe) == []
        page.click("#run")
        goal = page.evaluate(
            "overview.view.events.find(({ label }) => label.startsWith('4-1')).position"
        )
        page.mouse.click(*at(page, goal))
        until(page, "document.getElementById('event').textContent !== ''")
        page.click("#in")
        until(page, "p.view.zoom === 1 && !document.getElementById('zooming').hidden")
        assert violations(page, axe) == []
        page.evaluate("overview.fault('the sound was interrupted: touch to continue')")
        assert violations(page, axe) == []
        page.click("#out")
        for contrast in (False, True):
            page.evaluate(
                f"document.documentElement.classList.toggle('contrast', {str(contrast).lower()})"
            )
            assert violations(page, axe) == []
            for dialog in ("settings", "list", "h"):
                if dialog == "h":
                    page.focus("#slider")
                    page.keyboard.press("h")
                else:
                    page.click(f"#{dialog}")
                assert violations(page, axe) == []
                page.keyboard.press("Escape")
        context.close()


@pytest.mark.parametrize("way", ["keys", "buttons"])
def test_every_goal_is_walked_to_by_keys_alone_and_by_buttons_alone(opened, match, way):
    page = opened
    page.evaluate("""() => {
        window.walked = [];
        const report = overview.navigation.reportPosition.bind(overview.navigation);
        overview.navigation.reportPosition = (withValue) => {
            report(withValue);
            walked.push(overview.currentEvent?.label);
        };
    }""")
    page.focus("#slider")
    for _ in match.events:
        if way == "keys":
            page.keyboard.press("]")
        else:
            page.click("#next")
    goals = [one.label for one in match.events if one.kind in ("goal", "own_goal")]
    assert [label for label in page.evaluate("walked") if label in goals] == goals
    page.mouse.click(*at(page, 0.5))  # a tap on the curve lets go, without a key
    until(page, "p.input.active === null")


def test_no_time_before_zero_is_ever_shown(opened):
    page = opened
    page.evaluate("""() => {
        window.shown = new Set();
        const clock = document.getElementById("clock");
        new MutationObserver(() => shown.add(clock.textContent)).observe(clock, {
            childList: true, characterData: true, subtree: true,
        });
    }""")
    page.mouse.move(*at(page, 0.1))
    page.mouse.down()
    until(page, "p.cursor > 0.09")
    right, y = at(page, 0.1)
    for step in range(20):  # one by one: Firefox gets all `steps` within a frame
        page.mouse.move(right * (1.0 - step / 19.0), y)
        page.wait_for_timeout(20)
    until(page, "document.getElementById('clock').textContent === '0:00'")
    page.mouse.up()
    until(page, "p.cursor < 0.0005")
    page.evaluate(
        """() => overview.update({ ...overview.meters, cursor: -0.02, newStrikes: [] })"""
    )
    page.wait_for_timeout(300)
    told = page.evaluate("[...shown]")
    assert len(told) > 2
    assert not [text for text in told if "-" in text]


def test_a_patch_makes_the_other_rates_bytes(opened, match, football):
    surface = build_surface(match, football)
    base, wanted = (window_bytes(surface, football, rate) for rate in (48_000, 44_100))
    patch = make_patch(base, wanted)
    assert len(patch) < len(wanted) / 20
    for given, expected in (
        (patch, wanted),
        (make_patch(base, base), base),
        (make_patch(b"", base), base),
    ):
        # as text: a list of millions of numbers takes the driver half a minute
        made = opened.evaluate(
            """async (texts) => {
                const { patched } = await import("./modules/data.js");
                const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
                const [base, patch] = texts.map((text) => bytes(text).buffer);
                const hash = await crypto.subtle.digest("SHA-256", patched(base, patch));
                return Array.from(new Uint8Array(hash));
            }""",
            [base64.b64encode(one).decode() for one in (base, given)],
        )
        assert bytes(made) == hashlib.sha256(expected).digest()


UNPACK = """async (packed) => {
    const { unpacked } = await import("./modules/unpack.js");
    const bytes = await unpacked(Uint8Array.from(packed).buffer);
    return Array.from(new Uint8Array(bytes));
}"""


def test_the_page_unpacks_every_bit_of_what_was_packed(opened):
    random = np.random.default_rng(3)
    smooth = np.exp(np.sin(np.linspace(0.0, 9.0, 2000)))
    ends = np.array([-(2**63), 2**63 - 1, -1, 0, 1] * 7).view(float)
    columns = [smooth, random.bytes(800), ends, np.zeros(50), -smooth, np.full(3, np.nan)]
    everything = b"".join(bytes(one) for one in columns)
    ranked = smooth * np.exp(1e-5 * random.integers(-30, 30, 2000))
    for raw in (everything, bytes(smooth), bytes(ranked), random.bytes(4000), bytes(8), b""):
        for step in (0.0, 1e-5, 3e-3):
            packed_bytes = pack(raw, step)
            assert bytes(opened.evaluate(UNPACK, list(packed_bytes))) == raw
    assert len(pack(bytes(smooth))) < smooth.nbytes / 3
    assert zlib.decompress(pack(bytes(ranked), 1e-5))[0] == 8


@pytest.mark.soak
def test_firefox_shows_it_to_keys_zooms_and_plays_it_too(firefox, site, tmp_path):
    folder = shutil.copytree(site, tmp_path / "site")
    shutil.copy(Path(__file__).parent / "page" / "without_driver.js", folder)
    start = folder / "index.html"
    own = '<script type="module" src="main.js"></script>'
    assert own in start.read_text()
    held = f'<img src="{HELD}" alt="" hidden>'
    page = start.read_text().replace(own, own + own.replace("main", "without_driver"))
    start.write_text(page.replace("</main>", f"{held}</main>"))
    picture = tmp_path / "firefox.png"
    with opened_host(folder) as host, null_sink(tmp_path) as environment:
        told = firefox.visit(
            host.url, host.server.told, picture, host.server.released.set, environment
        )
    assert "error" not in told, told
    assert told["event"] == "9:50, near miss (synthetic)"
    drawn = np.round(255 * imread(picture)[:, :, :3]).astype(int)
    for colour, least in (
        ((235, 233, 228), 5_000),  # the curve's area
        ((121, 133, 145), 100),  # its line ahead of the disk
        ((22, 32, 43), 1_000),  # the disk
        ((23, 86, 196), 100),  # marks of the first team
        ((154, 27, 115), 100),  # and of the second
    ):
        assert (np.abs(drawn - colour).max(axis=2) <= 2).sum() > least
    assert 0.2 < told["swept"] < 1
    assert told["meters"]["clock"] > 0
    assert told["meters"]["strikes"] > 3
    assert told["meters"]["resets"] + told["meters"]["dropped"] == 0
    assert told["fault"] == ""
