"""The list of events: all of them, searched by words, and kinds whose marks are hidden."""

from __future__ import annotations

import contextlib

import pytest

import overview_dsp as ov
from tests.web.driving import until, violations
from tests.web.exported import opened_host, opened_page
from tests.web.layouts import events_of

COUNT = 10_000
KINDS = ["storm", "calm"]


@pytest.fixture(scope="module")
def many():
    return events_of(COUNT, KINDS, "", "Ten thousand events", 86_000.0)


@contextlib.contextmanager
def page_of(chromium, timeline, folder):
    with (
        pytest.warns(ov.OverviewWarning, match="storm"),
        opened_page(chromium, timeline, "plain", folder) as page,
    ):
        yield page


def rows(page):
    return page.evaluate(
        "[...document.querySelectorAll('#events-list li')].map((one) => one.ariaPosInSet * 1)"
    )


def test_the_list_has_all_events_and_the_page_only_those_in_sight(chromium, many, tmp_path):
    with page_of(chromium, many, tmp_path / "site") as page:
        page.click("#list")
        until(page, "document.querySelectorAll('#events-list li').length > 0")
        assert page.text_content("#found") == f"{COUNT} events"
        seen = set()
        # the end, and back through the middle: each part is there when it is looked at
        for share in (1.0, 0.5, 0.25, 0.0):
            page.evaluate(f"""() => {{
                const list = document.getElementById("events");
                list.scrollTop = {share} * (list.scrollHeight - list.clientHeight);
            }}""")
            wanted = max(1, round(share * COUNT))
            near = (
                "[...document.querySelectorAll('#events-list li')]"
                f".some((one) => Math.abs(one.ariaPosInSet - {wanted}) < 60)"
            )
            until(page, near)
            seen |= set(rows(page))
            assert len(rows(page)) < 500
        assert {1, COUNT} <= seen
        assert page.get_attribute("#events-list li", "aria-setsize") == str(COUNT)


def test_a_search_finds_words_of_kind_name_and_time(chromium, tmp_path, axe):
    events = (
        ov.Event(10.0, "storm", "Daria"),
        ov.Event(20.0, "storm", "Lothár of Decembër"),
        ov.Event(70.0, "calm", "after Lothar"),
    )
    with page_of(chromium, ov.Timeline("three", 80.0, events), tmp_path / "site") as page:
        page.click("#list")

        def find(words, count, shown=""):
            """Wait for this number of rows, which are drawn in the next frame, all with a text."""
            page.fill("#find", words)
            page.wait_for_function(
                """([count, shown]) => {
                    const rows = [...document.querySelectorAll("#events-list li")];
                    const fits = rows.every((row) => row.textContent.includes(shown));
                    return fits && rows.length === count;
                }""",
                arg=[count, shown],
            )

        find("", 3)
        find("storm", 2, "storm")
        find("lothar", 2, "Loth")
        find("december LOTHAR", 1, "storm, Lothár of Decembër")
        find("1:10", 1, "calm")
        find("nobody", 0)
        assert page.text_content("#found") == "Nothing called that"
        assert violations(page, axe) == []
        page.fill("#find", "after")
        page.click("#events-list .go")
        until(page, "p.currentEvent?.label === 'after Lothar' && p.input.active === 'keys'")


def test_a_hidden_kind_has_no_marks_and_is_still_felt(chromium, tmp_path):
    events = tuple(ov.Event(5.0 + 10 * i, KINDS[i % 2], f"number {i}") for i in range(8))
    with page_of(chromium, ov.Timeline("eight", 80.0, events), tmp_path / "site") as page:
        marks = "document.querySelectorAll('#canvas path').length"
        before = page.evaluate(marks)
        page.get_by_role("button", name="Storm 4").click()
        assert page.text_content("#announcement") == "storm hidden, still felt; 4 events shown"
        assert page.evaluate(marks) < before
        assert page.get_attribute("#legend button[aria-pressed=false]", "class") == "chip"
        page.focus("#slider")
        page.keyboard.press("Home")
        for _ in range(8):
            page.keyboard.press("]")
        assert page.evaluate("overview.currentEvent.label") == "number 7"  # keys go to all
        page.click("#list")
        assert page.text_content("#found") == "4 events"
        page.locator("#kinds").get_by_role("button", name="Storm 4").click()
        assert page.text_content("#found") == "8 events"
        assert page.evaluate(marks) == before


def test_the_key_stays_as_it_fits_and_keeps_the_focus(chromium, tmp_path):
    kinds = [f"storm_of_class_{i}" for i in range(9)]
    timeline = events_of(18, kinds, "", "Eighteen events")
    with page_of(chromium, timeline, tmp_path / "site") as page:
        shown = "[...document.querySelectorAll('#legend li')].map((one) => !one.hidden)"
        before = page.evaluate(shown)
        assert {True, False} <= set(before)
        page.focus("#legend button")
        focused = "document.activeElement.textContent"
        chip = page.evaluate(focused)
        for change in ("apply()", "showAbout()"):
            page.evaluate(f"overview.{change}")
            assert page.evaluate(shown) == before
            assert page.evaluate(focused) == chip


def test_a_zoomed_page_lists_all_events_and_goes_to_any(chromium, match, tmp_path):
    with opened_page(chromium, match, "football", tmp_path / "site", levels=1) as page:
        page.evaluate("overview.viewState.zoom(1, 0.05)")
        until(page, "p.view.zoom === 1")
        page.click("#list")
        texts = "[...document.querySelectorAll('#events-list .go')].map((one) => one.textContent)"
        until(page, f"{texts}.length > 0")
        labels = page.evaluate("overview.list.rows.map(({ event }) => event.label)")
        assert {event.label for event in match.events} <= set(labels)
        goals = [label for label in labels if label[:3] in ("1-0", "4-2")]
        assert len(goals) == 2
        page.fill("#find", "4-2")
        until(page, f"{texts}.length === 1")
        page.click("#events-list .go")
        until(page, "p.view.zoom === 1 && p.currentEvent?.label.startsWith('4-2')")
        assert page.evaluate("document.activeElement.id") == "slider"


def test_a_wide_window_has_the_list_beside_the_picture(chromium, site, axe):
    with opened_host(site) as host:
        context = chromium.new_context(viewport={"width": 1440, "height": 900})
        page = context.new_page()
        page.goto(host.url)
        until(page, "p.list?.found.length === 32")
        assert not page.is_visible("#list")
        assert page.evaluate("document.activeElement === document.body")  # it takes no focus
        stage, panel = (page.locator(one).bounding_box() for one in ("#stage", "#events"))
        assert panel["width"] == 336
        assert stage["x"] + stage["width"] <= panel["x"]
        assert violations(page, axe) == []
        page.fill("#find", "mbap")
        until(page, "document.querySelectorAll('#events-list li').length === 1")
        page.click("#events-list .go")
        until(page, "p.currentEvent?.label.includes('Mbapp')")
        assert page.is_visible("#find")
        page.fill("#find", "")
        page.evaluate("overview.goToEvent(overview.view.events.at(-2))")
        marked = page.locator("#events-list [aria-current]")
        until(page, "document.querySelector('[aria-current]')?.textContent.includes('yellow card')")
        box = marked.bounding_box()
        assert 0 <= box["y"] <= box["y"] + box["height"] <= 901
        page.set_viewport_size({"width": 1200, "height": 900})
        until(page, "!document.getElementById('events').open")
        page.click("#list")
        assert page.evaluate("document.getElementById('events').matches(':modal')")
        page.set_viewport_size({"width": 1440, "height": 900})
        until(page, "document.querySelector('dialog:modal') === null && p.list.wasBeside")
        assert page.is_visible("#find")
        context.close()
