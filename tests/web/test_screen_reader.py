"""What a screen reader hears of the page: the slider's value text and the polite live region."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from tests.web.driving import not_in_firefox, until, violations
from tests.web.exported import opened_page

HEARD = """() => {
    window.heard = [];
    const region = document.getElementById("announcement");
    const slider = document.getElementById("slider");
    new MutationObserver(() => heard.push(region.textContent.trim()))
        .observe(region, { childList: true, characterData: true, subtree: true });
    new MutationObserver(() => {
        if (document.activeElement === slider) heard.push(slider.getAttribute("aria-valuetext"));
    }).observe(slider, { attributes: true, attributeFilter: ["aria-valuetext"] });
}"""


def series():
    """Return a series with gaps, a spike, equal values and events of its own."""
    value = np.round(np.cumsum(np.random.default_rng(4).standard_normal(40)), 1)
    value[10:14] = value[20] = np.nan
    value[30] = 55.5
    builder = CurveBuilder()
    builder.append(value, np.arange(40) * 3600.0)
    curve = builder.finish()
    events = tuple(
        ov.Event(hour * 3600.0, "note", f"note {i} of mine")
        for i, hour in enumerate((0.0, 5.0, 5.25, 12.0, 30.0, 38.6))
    )
    end = 39 * 3600.0
    intensity = ov.Intensity(curve.time_s, curve.value, "°C")
    return ov.Timeline("hours", end, events, intensity, gaps=builder.gaps(end))


def known_values(timeline):
    curve = timeline.intensity
    return curve.value[timeline.has_data(np.asarray(curve.time_s))]


@contextlib.contextmanager
def page_of(chromium, timeline, preset, folder):
    with opened_page(chromium, timeline, preset, folder, levels=1) as page:
        page.evaluate(HEARD)
        yield page


def first_text(page):
    """Move the slider to the start, and return its text, which may come some frames later."""
    page.focus("#slider")
    page.keyboard.press("Home")
    page.wait_for_timeout(600)
    return page.get_attribute("#slider", "aria-valuetext")


def walk(page, act):
    """Repeat an act until nothing is left, and return what was heard; one text for each act."""
    heard = []
    for _ in range(400):
        page.evaluate("heard.length = 0")
        act()
        until(page, "heard.length > 0")
        page.wait_for_timeout(120)  # a repeat would be heard by then
        texts = page.evaluate("heard")
        assert len(texts) == 1, texts
        if texts[0] == "Nothing after this":
            return heard
        heard += texts
    raise AssertionError("the walk has no end")


@pytest.mark.parametrize("way", ["keys", "buttons"])
def test_a_walk_reads_each_value_and_each_event_exactly_once(chromium, tmp_path, way):
    timeline = series()
    with page_of(chromium, timeline, "series", tmp_path / "site") as page:
        first = first_text(page)
        if way == "keys":
            heard = [first, *walk(page, lambda: page.keyboard.press("ArrowRight"))]
            values = events = heard
        else:
            page.evaluate("document.getElementById('next').focus()")
            events = [first, *walk(page, lambda: page.click("#next"))]
            page.click("#settings")
            page.get_by_role("radio", name="Values").check()
            page.get_by_text("Done").click()
            assert page.get_attribute("#next", "aria-label") == "Next value"
            page.evaluate("overview.navigation.to(0)")
            values = [first, *walk(page, lambda: page.click("#next"))]
        numbers = [text.split(" °C")[0] for text in values if " °C" in text]
        expected = [f"{value:.1f}".replace("-", "\u2212") for value in known_values(timeline)]
        assert numbers == expected
        for event in timeline.events:
            assert sum(event.label in text for text in events) == 1, event.label
        assert any("no data" in text for text in events)  # the note in the gap


def test_arrows_read_each_event_of_a_match_once(chromium, tmp_path):
    match = ov.load_timeline("world-cup-final-2018")
    with page_of(chromium, match, "football", tmp_path / "site") as page:
        heard = [first_text(page)]
        heard += walk(page, lambda: page.keyboard.press("ArrowRight"))
        for label in {event.label for event in match.events}:
            count = sum(event.label == label for event in match.events)
            assert sum(text.count(label) for text in heard) == count, label
        assert len(heard) == len(set(heard))


def test_each_button_says_what_it_has_done(chromium, tmp_path):
    match = ov.load_timeline("world-cup-final-2018")
    with page_of(chromium, match, "football", tmp_path / "site") as page:

        def says(selector, *words):
            page.evaluate("heard.length = 0")
            page.click(selector)
            until(page, f"heard.length >= {len(words)}")
            texts = page.evaluate("heard")
            assert all(word in text for word, text in zip(words, texts, strict=False)), texts

        says("#next", "foul")
        says("#next", "foul")
        says("#in", "events")
        says("#out", "events", "foul")  # it disappears, and the slider has the focus
        says("#in", "events")
        says("#whole", "events", "foul")
        says("#run", "Playing, 10 seconds")
        says("#run", "Paused")
        page.click("#list")
        says("#events button:text-is('Last')", "full time")
        tree = page.locator("#slider").aria_snapshot()
        assert tree.startswith('- slider "Timeline"')


def test_a_screen_reader_gesture_moves_to_the_next_value(chromium, tmp_path):
    with page_of(chromium, series(), "series", tmp_path / "site") as page:
        page.focus("#slider")
        page.keyboard.press("Home")
        before = page.evaluate("overview.position")
        # TalkBack and VoiceOver increment a native range: the browser changes it and reports it
        page.evaluate("""() => {
            const slider = document.getElementById("slider");
            slider.stepUp();
            slider.dispatchEvent(new Event("input", { bubbles: true }));
        }""")
        until(page, f"p.position > {before}")
        assert page.evaluate("overview.position") == pytest.approx(1 / 39)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_in_the_table(chromium, tmp_path, axe, scheme):
    with page_of(chromium, series(), "series", tmp_path / "site") as page:
        page.emulate_media(color_scheme=scheme)
        page.click("#settings")
        page.click("#all-values")
        page.locator("#values tbody tr").first.wait_for()
        assert violations(page, axe) == []


@not_in_firefox
def test_all_values_are_in_a_table_that_sorts_and_downloads(chromium, tmp_path):
    timeline = series()
    with page_of(chromium, timeline, "series", tmp_path / "site") as page:
        page.click("#settings")
        page.click("#all-values")
        rows = page.locator("#values tbody tr")
        rows.first.wait_for()  # the table is loaded when it is first opened
        alone = 3  # notes between two values, or in the gap
        assert rows.count() == len(known_values(timeline)) + alone
        page.click("#values th button:text-is('Value')")
        page.click("#values th button:text-is('Value')")
        assert rows.first.locator("td").nth(1).text_content() == "55.5 °C"
        assert page.locator("#values th[aria-sort=descending]").text_content() == "Value"
        with page.expect_download() as download:
            page.click("#values-download")
        text = download.value.path().read_text()
        assert text.splitlines()[0] == "time_s,value (°C),events"
        assert len(text.splitlines()) == rows.count() + 1
        page.click("#values .done")
