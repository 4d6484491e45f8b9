"""The preset bench of a served page: felt at once, compared, kept as a file."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels.layout import CELLS
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.web.preset_data import parse_preset
from tests.web.driving import DESKTOP, PHONE, at, until, violations
from tests.web.layouts import FAULTS, settled
from tests.web.serving import served
from tests.web.test_served_page import page_of, says, wait_for


@pytest.fixture
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path / "own"))
    return tmp_path / "own"


def opened(tab):
    until(tab, "p.view")
    tab.click("#settings")
    tab.click("#tune")
    until(tab, "p.editor.sides && !document.getElementById('editor').hidden")
    assert not tab.is_visible("#dialog")


def slide(tab, section, name, part):
    """Put a parameter's slider at a part of its range."""
    details = tab.locator("#editor-rows details", has=tab.locator(f"summary:text-is('{section}')"))
    if details.get_attribute("open") is None:
        details.locator("summary").click()
    details.locator(f"input[name='{name}']").evaluate(
        """(range, part) => {
            range.value = part * range.max;
            range.dispatchEvent(new Event("input"));
        }""",
        part,
    )
    until(tab, "!p.editor.busy")


def test_a_slider_is_felt_at_once_and_a_and_b_compare(match, rigid_football, chromium, tmp_path):
    """More friction holds the disk back: where it comes to with a hand that moves on."""
    # stiff springs, so that it is back soon, and no shaft that slips where friction holds
    quick = rigid_football.with_changes({"disk.k1": 0.0036, "disk.k2": 0.0149})
    ov.presets.save(quick, tmp_path / "quick.toml")
    with (
        served(match, plays=False, preset=str(tmp_path / "quick.toml")) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        opened(tab)
        tab.mouse.click(*at(tab, 0.01))  # it sounds
        until(tab, "p.meters")
        tab.evaluate("window.firstView = overview.view")

        def lag():
            tab.mouse.move(*at(tab, 0.05))
            tab.mouse.down()
            tab.mouse.move(*at(tab, 0.9), steps=30)
            behind = tab.evaluate("0.9 - overview.cursor")
            tab.mouse.up()
            until(tab, "p.cursor < 0.01")
            return behind

        light = lag()
        slide(tab, "surface", "surface.friction", 0.75)
        until(tab, "p.view !== firstView")  # drawn, too
        heavy = lag()
        tab.click("#editor-a")
        until(tab, "!p.editor.busy && p.meters.changesWaiting === 0")
        tab.wait_for_timeout(200)
        again = lag()
        print(f"\nbehind by {light:.3f}, with more friction {heavy:.3f}, with A {again:.3f}")
        assert heavy > 2 * light
        assert again < heavy / 2
        tab.click("#editor-b")
        until(tab, "p.editor.playing.values['surface.friction'] > 1e-3")
        # what is zoomed to is felt by it as well
        tab.focus("#slider")
        tab.keyboard.press("+")
        until(tab, "p.view.zoom === 1 && p.meters.changesWaiting === 0")
        tab.keyboard.press("Escape")
        until(tab, "p.cursor < 0.01")
        assert lag() > 2 * light
        assert wrong == []


def test_events_move_apart_only_once_the_disk_is_released(match, chromium):
    """Another angle map moves every position, and so also that under a finger."""
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        before = tab.evaluate("overview.view.events.map(({ position }) => position)")
        tab.click("summary:text-is('surface')")
        until(tab, "document.querySelector('details[open] input')")
        tab.mouse.move(*at(tab, 0.4))
        tab.mouse.down()
        until(tab, "p.input.active === 'touch'")
        slide(tab, "surface", "surface.angle_map", 1.0)
        slide(tab, "surface", "surface.friction", 0.75)
        friction = "p.editor.preset.values['surface.friction']"
        until(tab, f"p.editor.playing.values['surface.friction'] === {friction}")
        assert tab.evaluate("overview.editor.playing.values['surface.angle_map']") < 1
        tab.mouse.up()
        until(tab, "p.editor.playing.values['surface.angle_map'] === 1")
        until(tab, f"p.view.events.some(({{ position }}, i) => position !== {before}[i])")
        assert wrong == []


def test_an_events_height_and_a_choice_can_be_set_by_keys_alone(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        assert tab.evaluate("document.activeElement.id") == "editor-title"
        section = tab.locator("summary:text-is('event: goal')")
        section.focus()
        tab.keyboard.press("Enter")
        until(tab, "document.querySelector('details[open] input')")
        tab.keyboard.press("Tab")
        assert tab.evaluate("document.activeElement.name") == "kinds.NAME.height"
        tab.keyboard.press("Home")
        until(
            tab, "p.editor.preset.kinds.goal.height === p.editor.table.get('kinds.NAME.height').low"
        )
        assert tab.evaluate("document.activeElement.getAttribute('aria-valuetext')")
        until(tab, "!p.editor.busy && p.editor.playing.kinds.goal.height < 1")
        assert wrong == []


def test_a_preset_that_cant_sound_is_refused_in_a_line_and_the_last_one_stays(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        tab.evaluate("overview.editor.preset.values['disk.k1'] = 1e9; overview.editor.changed()")
        says(tab, "editor-message", "disk.k1")
        assert tab.evaluate("overview.editor.playing.values['disk.k1']") < 1
        assert [line for line in wrong if "400" not in line] == []


def test_a_preset_is_kept_in_the_own_folder_and_never_over_a_bundled_one(
    match, chromium, own_folder
):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        opened(tab)
        slide(tab, "tactor", "tactor.gain_db", 0.25)
        gain = tab.evaluate("overview.editor.preset.values['tactor.gain_db']")
        tab.fill("#editor-name", "football")
        tab.click("#editor-save")
        says(tab, "editor-message", "bundled")
        tab.fill("#editor-name", "bus")
        tab.click("#editor-save")
        says(tab, "editor-message", "saved as bus")
        assert ov.load_preset("bus").values["tactor.gain_db"] == gain
        assert [path.name for path in own_folder.iterdir()] == ["bus.toml"]
        slide(tab, "tactor", "tactor.gain_db", 0.5)
        tab.click("#editor-save")
        says(tab, "editor-message", "preset bus already exists: replace it, or enter another name")
        assert ov.load_preset("bus").values["tactor.gain_db"] == gain
        assert tab.text_content("#editor-save") == "Replace it"
        tab.click("#editor-save")
        says(tab, "editor-message", "saved as bus")
        assert ov.load_preset("bus").values["tactor.gain_db"] != gain
        tab.fill("#editor-name", "tram")
        tab.evaluate(
            "() => { for (const _ of 'ab') document.getElementById('editor-save').click(); }"
        )
        says(tab, "editor-message", "saved as tram")
        tab.wait_for_timeout(300)
        assert tab.text_content("#editor-message") == "saved as tram"  # pressed twice is saved once
        for name in ("", "..", "a/b", "caf\u00e9"):
            tab.fill("#editor-name", name)
            tab.click("#editor-save")
            line = f"name is {name or 'empty'}; must be letters, digits, - and _"
            says(tab, "editor-message", line)
        assert sorted(path.name for path in own_folder.iterdir()) == ["bus.toml", "tram.toml"]


def test_a_preset_is_downloaded_as_a_file_that_loads(match, football, chromium, tmp_path):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        slide(tab, "click", "click.gain_db", 0.5)
        tab.fill("#editor-name", "bus")
        with tab.expect_download() as waiting:
            tab.click("#editor-download")
        assert waiting.value.suggested_filename == "bus.toml"
        path = tmp_path / "bus.toml"
        waiting.value.save_as(path)
        assert tomllib.loads(path.read_text())["click"]["gain_db"]
        kept = ov.load_preset(path)
        assert kept.values["click.gain_db"] != football.values["click.gain_db"]
        assert kept.kinds == football.kinds
        assert wrong == []


def test_at_the_host_the_bench_changes_what_the_host_plays(match, chromium):
    with served(match) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        slide(tab, "tactor", "tactor.gain_db", 0.25)
        gain = tab.evaluate("overview.editor.preset.values['tactor.gain_db']")
        wait_for(lambda: server.player.engine.preset.values["tactor.gain_db"] == gain)
        tab.select_option("#editor-preset", "crowd")
        wait_for(lambda: server.player.engine.preset.name == "crowd")
        tab.click("#editor-a")
        wait_for(lambda: server.player.engine.preset.name == "football")
        assert wrong == []


def test_a_folder_offers_no_bench(match, football, chromium, tmp_path):
    from overview_dsp.web.static_site import write_site
    from tests.web.exported import opened_host

    write_site(match, football, tmp_path / "site", levels=0)
    with opened_host(tmp_path / "site") as host:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(host.url)
        until(page, "p.view")
        page.click("#settings")
        assert not page.is_visible("#tune")
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [PHONE, DESKTOP], ids=["phone", "desktop"])
def test_axe_finds_nothing_on_the_bench_and_at_the_host(match, chromium, axe, scheme, size):
    with (
        served(match) as server,
        page_of(server, chromium, color_scheme=scheme) as (tab, _),
    ):
        tab.set_viewport_size(size)
        opened(tab)
        for section in ("disk", "surface", "tactor", "event: goal"):
            tab.locator(f"summary:text-is('{section}')").click()
        assert violations(tab, axe) == []


def stroke(tab, *positions):
    """A pointer that draws through positions (0 to 1, from the left and from below)."""
    pad = tab.locator("details[open] .drawing")
    pad.scroll_into_view_if_needed()
    box = pad.bounding_box()
    (first, *rest) = [
        (box["x"] + x * box["width"], box["y"] + (1.0 - y) * box["height"]) for x, y in positions
    ]
    tab.mouse.move(*first)
    tab.mouse.down()
    for position in rest:
        tab.mouse.move(*position, steps=8)
    tab.mouse.up()


def test_a_drawn_map_of_the_curve_is_felt_at_once_undone_and_kept(chromium, own_folder, tmp_path):
    ramp = ov.Intensity(np.array([0.0, 60.0]), np.array([0.0, 1.0]))
    timeline = ov.Timeline("a ramp", 60.0, (), ramp)
    series = ov.load_preset("series").with_changes({"surface.intensity_gain": 9.0})
    path = ov.presets.save(series, tmp_path / "steep.toml")
    with (
        served(timeline, plays=False, preset=str(path)) as server,
        page_of(server, chromium) as (tab, wrong),
    ):
        opened(tab)
        tab.click("summary:text-is('surface')")

        def ratio():
            preset = parse_preset(tab.evaluate("overview.editor.playing"))
            resistance = build_surface(timeline, preset).resistance
            return resistance[round(0.98 * CELLS)] / resistance[round(0.02 * CELLS)]

        straight = ratio()
        stroke(tab, (0.004, 0.9), (0.996, 0.1))
        until(tab, "!p.editor.busy && p.editor.playing.points.length === 33")
        falling = tab.evaluate("overview.editor.preset.points")
        assert falling == sorted(falling, reverse=True)
        assert falling[0] > 0.85
        assert falling[-1] < 0.15
        # nine times more at the top than at the bottom, by 0.8 of the way, and upside down
        assert ratio() == pytest.approx(straight ** (falling[-1] - falling[0]), rel=0.1)
        tab.mouse.click(*at(tab, 0.01))  # and it sounds
        until(tab, "p.meters?.clock > 0")
        tab.click("details[open] .drawn button:text-is('Undo')")
        until(tab, "!p.editor.busy && p.editor.playing.points.length === 0")
        stroke(tab, (0.5, 0.004), (0.996, 0.004))  # what is louder than half is felt no more
        upper = tab.evaluate("overview.editor.preset.points")
        assert upper[:16] == pytest.approx([k / 32 for k in range(16)], abs=1e-3)
        assert max(upper[16:]) < 0.02
        until(tab, "!p.editor.busy")
        tab.fill("#editor-name", "mapped")
        tab.click("#editor-save")
        says(tab, "editor-message", "saved as mapped")
        assert list(ov.load_preset("mapped").points) == upper
        tab.click("details[open] .drawn button:text-is('Use a straight line')")
        until(tab, "!p.editor.busy && p.editor.playing.points.length === 0")
        assert wrong == []


def test_a_drawn_course_is_felt_at_once_undone_and_kept(match, chromium, own_folder):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        tab.click("summary:text-is('event: goal')")
        stroke(tab, (0.004, 0.1), (0.996, 0.9))
        until(tab, "!p.editor.busy && p.editor.playing.kinds.goal.points.length === 33")
        rising = tab.evaluate("overview.editor.preset.kinds.goal.points")
        assert rising == sorted(rising)
        assert 0.0 < rising[0] < 0.2 < 0.8 < rising[-1] <= 1.0
        stroke(tab, (0.5, 0.02), (0.6, 0.02))
        assert min(tab.evaluate("overview.editor.preset.kinds.goal.points")[16:20]) < 0.05
        tab.click("details[open] .drawn button:text-is('Undo')")
        assert tab.evaluate("overview.editor.preset.kinds.goal.points") == rising
        until(tab, "!p.editor.busy")
        tab.fill("#editor-name", "drawn")
        tab.click("#editor-save")
        says(tab, "editor-message", "saved as drawn")
        kept = ov.load_preset(own_folder / "drawn.toml").kinds["goal"].points
        assert list(kept) == rising
        tab.click("details[open] .drawn button:text-is('Use the shape')")
        until(tab, "!p.editor.busy && p.editor.playing.kinds.goal.points.length === 0")
        assert wrong == []


def test_controls_are_found_by_words_with_their_section(match, chromium, axe):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        everything = tab.locator("#editor-rows details").count()
        tab.click("summary:text-is('tactor')")
        tab.fill("#editor-find", "goal height")
        sections = tab.locator("#editor-rows details[open]")
        assert 0 < sections.count() < everything
        names = sections.locator("summary").all_text_contents()
        assert "event: goal" in names
        assert tab.locator("#editor-rows input[name='kinds.NAME.height']").count() >= 1
        assert violations(tab, axe) == []
        tab.fill("#editor-find", "no such parameter")
        assert tab.text_content("#editor-rows") == "Nothing called that"
        tab.fill("#editor-find", "")
        assert tab.locator("#editor-rows details").count() == everything
        assert sections.locator("summary").all_text_contents() == ["tactor"]
        assert wrong == []


def test_a_section_begins_with_the_shape_as_it_is(match, chromium):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, _):
        opened(tab)
        tab.click("summary:text-is('event: goal')")
        until(tab, "document.querySelector('details[open] input')")
        rows = "[...document.querySelector('#editor-rows details[open]').children]"
        classes = tab.evaluate(f"{rows}.map((one) => one.className)")
        assert classes[:3] == ["", "parameter drawn", "parameter"]  # after the summary


def test_changes_are_undone_and_the_difference_of_a_and_b_is_listed(match, chromium):
    friction = "p.editor.preset.values['surface.friction']"
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        opened(tab)
        until(tab, "!p.editor.busy")
        assert tab.text_content("#editor-difference") == "A and B are equal"
        assert tab.is_disabled("#editor-undo")
        before = tab.evaluate(friction.replace("p.", "overview.", 1))
        slide(tab, "surface", "surface.friction", 0.75)
        tab.wait_for_timeout(800)  # changes within 700 ms are one
        slide(tab, "tactor", "tactor.gain_db", 0.25)
        assert tab.text_content("#editor-difference") == "A and B differ in 2"
        lines = tab.locator("#editor-difference-list li").all_text_contents()
        assert any(line.startswith("surface.friction: A ") and ", B " in line for line in lines)
        assert any(line.startswith("tactor.gain db: A ") and line.endswith(" dB") for line in lines)
        tab.click("#editor-undo")
        until(tab, "!p.editor.busy")
        assert tab.text_content("#editor-difference") == "A and B differ in 1"
        tab.click("#editor-undo")
        until(tab, f"!p.editor.busy && {friction} === {before}")
        until(tab, f"p.editor.playing.values['surface.friction'] === {before}")  # and is felt
        assert tab.text_content("#editor-difference") == "A and B are equal"
        assert tab.is_disabled("#editor-undo")
        assert wrong == []


@pytest.mark.parametrize("size", [(1280, 800), (1024, 500), (900, 700)])
def test_the_dock_beside_the_editor_can_be_touched(match, chromium, size):
    with served(match, plays=False) as server, page_of(server, chromium) as (tab, wrong):
        tab.set_viewport_size({"width": size[0], "height": size[1]})
        opened(tab)
        settled(tab)
        assert tab.is_visible("nav")
        assert [one for one in tab.evaluate(FAULTS) if not one.startswith("picture")] == []
        assert wrong == []
