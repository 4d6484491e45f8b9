"""A study in trouble: wrong keys, double clicks, reloads, killed tabs, a killed server."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import time
from pathlib import Path

import pytest

from studies.tests.page.study_server import built, served_study, trials_of
from tests.web.exported import opened_host

MANY = int(os.environ.get("OVERVIEW_STUDY_TROUBLES", "200"))
PATIENCE_S = 60.0
STUDY = """
title = "In trouble"
name = "trouble"
seed = 11
participants = 40
[task]
name = "identify"
question = "What did you feel?"
[stimuli]
made = { kinds = ["goal", "foul"] }
presets = ["football"]
gestures = ["free"]
[phases]
main = { repeats = 3 }
catch = 0.2
"""
WRONG = ("Enter", "Escape", "0", "9", "a", "Backspace", "F2", "Tab")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return built(tmp_path_factory.mktemp("trouble"), STUDY)


class Person:
    """One who goes on, whatever happens; `given` are the answers that the page went on from."""

    def __init__(self, context, server, seed):
        self.context, self.server = context, server
        self.chance = random.Random(seed)
        self.given: list[str] = []
        self.troubles = 0
        self.choices = json.loads((server.folder / "study.json").read_text())["task"]["choices"]
        self.open()

    def open(self):
        """A tab of the study; the token is kept, as is all else."""
        self.page = self.context.new_page()
        self.page.on("dialog", lambda dialog: dialog.accept())
        self.page.goto(self.server.url)

    def until(self, condition):
        end = time.monotonic() + PATIENCE_S
        while not (found := condition()):
            assert time.monotonic() < end, self.page.inner_text("body")
            self.page.wait_for_timeout(20)
        return found

    def shown(self):
        """What is shown: start, again, text, trial or end; None meanwhile."""
        found = self.page.query_selector("h1")
        words = found.inner_text() if found is not None else ""
        names = {"In trouble": "start", "Welcome back": "again", "What to do": "text",
                 "What did you feel?": "trial", "Thank you": "end"}  # fmt: skip
        return names.get(words)

    def heading(self):
        return self.page.evaluate_handle("document.querySelector('h1')")

    def leave(self, heading):
        """Wait until the page shows something else."""
        self.until(lambda: self.page.evaluate("(h) => !h.isConnected", heading))

    def done(self):
        return int(self.page.inner_text("#count").split()[0])

    def go_on(self):
        """Press what leads to the next trial, or to the end."""
        buttons = {"start": "Begin", "again": "Continue", "text": "Start"}
        while (now := self.until(self.shown)) not in ("trial", "end"):
            if now == "start" and self.given:
                return "end"  # the session was over, and the page is ready for somebody else
            before = self.heading()
            self.page.click(f'button:text-is("{buttons[now]}")')
            self.leave(before)
        return now

    def answer(self, trouble):
        """Feel one trial and answer it, with slips; `trouble` comes before the page has gone on."""
        assert self.done() == len(self.given), "an answer was lost, or is asked for again"
        for key in self.chance.choices(WRONG, k=2):
            self.page.keyboard.press(key)
        self.page.focus(".pad")
        self.page.keyboard.press("PageUp")
        self.page.wait_for_selector(".choice:not([disabled])")
        number = self.chance.randrange(len(self.choices))
        heading = self.heading()
        if self.chance.random() < 0.4:
            self.page.locator(".choice").nth(number).dblclick(no_wait_after=True)
            self.troubles += 1
        else:
            self.page.keyboard.press(str(number + 1))
            self.page.keyboard.press(str((number + 1) % len(self.choices) + 1))
        if trouble is not None:
            self.page.wait_for_timeout(self.chance.uniform(0.0, 80.0))
            self.suffer(trouble)
            if self.go_on() != "end" and self.done() == len(self.given):
                return  # it didn't count, and is asked for again
        else:
            self.leave(heading)
            self.until(self.shown)
        self.given.append(self.choices[number])

    def suffer(self, what):
        """Something happens."""
        self.troubles += 1
        if what == "server":
            self.server.kill()
            self.server.start()
        elif what == "reload":
            self.page.reload()
        else:
            old = self.page
            with contextlib.suppress(Exception):  # nobody is left to answer
                old.goto("chrome://crash")
            self.open()
            old.close()

    def trouble(self):
        """What is to happen, or nothing."""
        if self.chance.random() < 0.4:
            return None
        return self.chance.choice(["reload", "reload", "tab", "tab", "server"])


def take_part(chromium, folder, answers, seed):
    """A session in trouble; how often there was some."""
    context = chromium.new_context()
    with served_study(folder, answers) as server:
        person = Person(context, server, seed)
        while person.go_on() != "end":
            trouble = person.trouble()
            if trouble is not None and person.chance.random() < 0.5:
                person.suffer(trouble)
            else:
                person.answer(trouble)
        rows = server.rows()
    context.close()
    wanted = trials_of(folder)
    assert list(rows) == [one["id"] for one in wanted]  # each once, in its order
    assert [row["response"] for row in rows.values()] == person.given
    return person.troubles


def test_no_answer_is_lost_or_asked_for_twice(chromium, folder, tmp_path):
    assert take_part(chromium, folder, tmp_path / "answers.sqlite", seed=1) > 3


@pytest.mark.soak
def test_no_answer_is_lost_in_many_troubles(chromium, folder, tmp_path):
    troubles = seed = 0
    while troubles < MANY:
        seed += 1
        troubles += take_part(chromium, folder, tmp_path / f"{seed}.sqlite", seed)
        print(f"\n{troubles} troubles")


def kill_browser(profile):
    """Every process of the browser with this profile, at once."""
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str(profile).encode() in (process / "cmdline").read_bytes():
                os.kill(int(process.name), signal.SIGKILL)


@pytest.mark.soak
def test_a_killed_browser_goes_on_where_it_was_without_a_server(driver, folder, tmp_path):
    profile = tmp_path / "profile"

    def opened():
        context = driver.chromium.launch_persistent_context(
            str(profile), executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = context.new_page()
        page.goto(host.url)
        return context, page

    def answer(page):
        count = page.inner_text("#count")
        page.focus(".pad")
        page.keyboard.press("PageUp")
        page.wait_for_selector(".choice:not([disabled])")
        page.keyboard.press("1")
        page.locator("#count", has_not_text=count).wait_for()

    with opened_host(folder) as host:
        context, page = opened()
        page.click("text=Begin")
        page.click("text=Start")
        for answers in range(1, 4):
            page.wait_for_selector(".pad")
            answer(page)
            kill_browser(profile)
            with contextlib.suppress(Exception):
                context.close()
            context, page = opened()
            page.click("text=Continue")
            page.click("text=Start")
            page.wait_for_selector(".pad")
            assert page.inner_text("#count").startswith(f"{answers} of ")
        context.close()
