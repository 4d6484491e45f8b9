"""Links with every combination of their parameters, right or wrong: each is followed or named."""

from __future__ import annotations

import itertools
import time

import pytest

from tests.web.driving import PHONE
from tests.web.exported import opened_host
from tests.web.serving import served

WINDOWS = {None: None, "3000:4500": (2940, 4900), "5:2": None}
"""Windows of links, and the part of a folder with one zoom level that shows them."""

MOMENTS = {None: None, "goal:4": 67.5 * 60, "goal:1": 27.5 * 60, "corner:9": None}
PLAYS = {None: False, "sweep:4:0.2:0.8": True, "dance": False}
PRESETS = [None, "football", "no_such_preset"]
COMBINATIONS = list(itertools.product(WINDOWS, MOMENTS, PLAYS, PRESETS))
WRONG = {"5:2", "corner:9", "dance", "no_such_preset"}
SECONDS = 20.0

STATE = """() => {
    const p = window.overview;
    return p?.view ? {
        fault: document.getElementById("fault").textContent,
        shown: [p.view.start_s, p.view.end_s],
        moment: p.input.active === "keys" ? p.moment : null,
        offered: document.getElementById("run").classList.contains("offered"),
    } : null;
}"""


def fragment_of(combination):
    names = ("window", "at", "play", "preset")
    fields = zip(names, combination, strict=True)
    return "&".join(f"{name}={value}" for name, value in fields if value is not None)


def problem(state, combination, served_window=None):
    """Return what a page does that its link does not say; "" where it follows the link."""
    window, at, play, _ = combination
    shown = served_window if window == "3000:4500" and served_window else WINDOWS[window]
    moment = MOMENTS[at]
    named = [one for one in combination if one in WRONG]
    if shown and moment is not None and not shown[0] <= moment <= shown[1]:
        named, moment = [*named, f"position {at}", "outside of the window"], None
    if not all(one in state["fault"] for one in named) or bool(named) != bool(state["fault"]):
        return f"{state['fault']!r} does not name {named}"
    wanted = {
        "shown": pytest.approx(shown or (0.0, 5880.0), abs=0.01),
        "moment": None if moment is None else pytest.approx(moment, abs=0.5),
        "offered": PLAYS[play],
    }
    found = [f"{key}: {state[key]}" for key, value in wanted.items() if state[key] != value]
    return ", ".join(found)


def failures(page, url, combinations, **given):
    """Open each link in a new document, and return what was wrong with it once it came to rest."""
    found = []
    for combination in combinations:
        page.goto("about:blank")
        page.goto(f"{url}{fragment_of(combination)}")
        end, wrong = time.monotonic() + SECONDS, "no page"
        while wrong and time.monotonic() < end:
            page.wait_for_timeout(50)
            state = page.evaluate(STATE)
            wrong = problem(state, combination, **given) if state else "no page"
        page.wait_for_timeout(100)
        wrong = wrong or problem(page.evaluate(STATE), combination, **given)
        found += [f"{fragment_of(combination)}: {wrong}"] if wrong else []
    return found


def followed(chromium, site, combinations):
    with opened_host(site) as host:
        context = chromium.new_context(viewport=PHONE, service_workers="block")
        found = failures(context.new_page(), f"{host.url}#", combinations)
        context.close()
    return found


def test_a_sample_of_links_is_followed_or_named(chromium, site):
    assert followed(chromium, site, COMBINATIONS[::9]) == []


@pytest.mark.soak
def test_every_combination_of_a_link_is_followed_or_named(chromium, site):
    found = followed(chromium, site, COMBINATIONS)
    print(f"\n{len(COMBINATIONS)} links, {len(found)} failures")
    assert found == []


def test_links_of_a_server_have_its_token_in_any_combination(chromium, match):
    combinations = COMBINATIONS[::13]
    with served(match, plays=False) as server:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        page.goto(f"{server.origin}/#window=5:2&token=wrong&at=goal:1")
        page.wait_for_timeout(200)
        assert "did not load" in page.text_content("#fault")
        url = f"{server.origin}/#token={server.access.token}&"
        assert failures(page, url, combinations, served_window=(3000, 4500)) == []
        context.close()
