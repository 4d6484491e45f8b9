"""A study's page in a real Chromium: by keyboard and screen reader, by touch, without a network."""

from __future__ import annotations

import contextlib
import json

import pytest

from overview_dsp.studies.answers import read_answers
from tests.web.driving import PHONE, violations
from tests.web.exported import opened_host
from tests.web.participant import Reader, step, take_part
from tests.web.studied import built, served_study, trials_of

IDENTIFY = """
title = "Friction against static"
name = "identify"
seed = 7
participants = 4
[factors]
mapping = { within = ["friction", "static"], order = "williams" }
[task]
name = "identify"
question = "What did you feel?"
[stimuli]
made = { kinds = ["goal", "foul"] }
presets = ["football"]
gestures = ["free"]
[phases]
practice = { repeats = 1, feedback = true }
main = { repeats = 1 }
catch = 0.3
[questionnaires]
start = ["consent"]
each = ["tlx"]
end = ["comments"]
consent = { version = "1", text = "I take part of my own will." }
"""
TASKS = {
    "locate": 'made = { kinds = ["goal"], variants = 2 }\ngestures = ["free"]',
    "count": 'made = { kinds = ["goal"], counts = [1, 3] }\ngestures = ["sweep:0.4"]',
}


@pytest.fixture(scope="module")
def identify(tmp_path_factory):
    return built(tmp_path_factory.mktemp("identify"), IDENTIFY)


@contextlib.contextmanager
def page_at(chromium, url, **given):
    """A tab, and what went wrong in it."""
    context = chromium.new_context(**given)
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: said.type == "error" and wrong.append(said.text))
    page.goto(url)
    try:
        yield page, wrong
    finally:
        context.close()


def feel_and_choose(choices):
    """Answer by a digit, after a few steps along the pad."""

    def answer(reader):
        reader.press("ArrowRight", 3)
        reader.press("PageUp", 3)
        reader.press("9")  # no such choice
        reader.until(lambda: reader.enabled("nothing"), "choices")
        reader.press(str(choices.pop(0)))

    return answer


def test_a_whole_session_by_keyboard_and_screen_reader_alone(chromium, identify, tmp_path):
    wanted = trials_of(identify)
    trials = [one for one in wanted if one["type"] == "trial"]
    choices = [1 + i % 3 for i in range(len(trials))]
    with (
        served_study(identify, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url) as (page, wrong),
    ):
        reader = Reader(page)
        take_part(reader, feel_and_choose(list(choices)), "What did you feel?")
        assert "stored" in page.text_content("main")
        rows = server.rows()
    assert wrong == []
    assert list(rows) == [one["id"] for one in wanted]  # in order, each once
    told = json.loads((identify / "study.json").read_text())["task"]["choices"]
    for trial, choice in zip(trials, choices, strict=True):
        row = rows[trial["id"]]
        assert row["response"] == told[choice - 1]
        assert row["correct"] == (row["response"] == trial["correct"])
        assert row["source"] == "keys"
        assert row["take"]["events"][0][2] == 1
        assert row["take"]["events"][-1][2] == 0
        assert row["take"]["samples"] >= row["take"]["events"][-1][0]
    answers = read_answers([tmp_path / "answers.sqlite"])
    assert answers.sessions[0].finished_utc is not None
