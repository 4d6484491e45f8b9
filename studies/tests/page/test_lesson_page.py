"""The page of a lesson in a real Chromium: every example plays, a reload loses nothing."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys

import pytest

from overview_studies.lesson import label, make_lesson
from studies.tests.page.participant import Reader
from studies.tests.page.test_page import page_at
from tests.cli.running import environment
from tests.web.driving import PHONE, violations

LISTENING = """
self.played = [];
self.announced = [];
addEventListener("DOMContentLoaded", () => {
  const said = document.getElementById("said");
  const record = () => self.announced.push(said.textContent);
  if (said) new MutationObserver(record).observe(said, { childList: true });
});
const start = AudioBufferSourceNode.prototype.start;
AudioBufferSourceNode.prototype.start = function (...given) {
  this.playbackRate.value = FASTER;
  const peak = Math.max(...Array.from({ length: this.buffer.numberOfChannels }, (_, i) =>
    this.buffer.getChannelData(i).reduce((most, x) => Math.max(most, Math.abs(x)), 0)));
  const one = { duration: this.buffer.duration, peak, ended: false };
  self.played.push(one);
  this.addEventListener("ended", () => { one.ended = true; });
  return start.apply(this, given);
};
"""


def served_lesson(preset, scores):
    return served("learn", preset, "--page", "--scores", str(scores))


@contextlib.contextmanager
def served(*arguments, **variables):
    command = [sys.executable, "-m", "overview_dsp", *arguments, "--port", "0", "--json"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env={**environment(), **variables},
    )  # fmt: skip
    try:
        yield json.loads(process.stdout.readline())["address"]
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)


class Robot:
    """A pupil who hears what is played, and has a keyboard and a screen reader."""

    def __init__(self, page, lesson):
        self.page, self.lesson, self.reader = page, lesson, Reader(page)
        self.heard, self.said = [], []

    def hear(self):
        """What has been played since the page was loaded."""
        self.heard += self.page.evaluate("self.played.splice(0)")

    def begin(self, name="Begin"):
        self.reader.until(lambda: self.reader.enabled(name), name)
        self.reader.push(name)

    def wait_for(self, heading, button):
        def ready():
            return self.reader.heading() == heading and self.reader.enabled(button)

        self.reader.until(ready, f"{button} at {heading}")

    def announced(self):
        """All that the live region has said since the page was loaded."""
        return self.page.evaluate("self.announced")

    def follow(self, step):
        self.wait_for(step.text, "Next")
        self.reader.push("Next")

    def choices(self):
        """Wait for the end of the question's example."""
        enabled = '.choice[aria-disabled="false"]'
        self.reader.until(lambda: self.page.query_selector(enabled), "choices")

    def answer(self, number, kind):
        """Answer by a digit, and read how it was."""
        right = self.lesson.questions[number].kind
        self.choices()
        assert not self.reader.enabled("Next")
        self.page.keyboard.press(str(1 + self.lesson.choices.index(kind)))
        self.reader.until(lambda: self.reader.enabled("Next"), "feedback")
        self.said.append(self.page.text_content(".feedback"))
        if kind == right:
            assert self.said[-1] == f"Right: {label(kind)}."
        else:
            assert self.said[-1] == f"It was {label(right)}, not {label(kind)}."
        assert self.said[-1] in self.announced()
        self.reader.press("Enter")
        self.reader.until(lambda: self.page.query_selector(".feedback") is None, "what follows")


@pytest.mark.parametrize("preset", ["plain", pytest.param("football", marks=pytest.mark.soak)])
def test_a_whole_lesson_with_reloads_by_keyboard_alone(chromium, axe, preset, tmp_path):
    scores = tmp_path / "scores.json"
    lesson = make_lesson(preset)
    middle = len(lesson.steps) // 2
    answers = [one.kind for one in lesson.questions]
    for number in (2, 7):
        answers[number] = next(kind for kind in lesson.choices if kind != answers[number])
    wanted = [example for step in lesson.steps for example in step.examples]
    with served_lesson(preset, scores) as url, page_at(chromium, url) as (page, wrong):
        page.add_init_script(LISTENING.replace("FASTER", "12"))
        page.reload()
        robot = Robot(page, lesson)
        robot.reader.until(lambda: robot.reader.enabled("Begin"), "Begin")
        assert violations(page, axe) == []
        robot.begin()
        for number, step in enumerate(lesson.steps):
            robot.follow(step)
            if number == middle - 1:  # in the middle of the examples
                robot.wait_for(lesson.steps[middle].text, "Next")
                robot.hear()
                del robot.heard[-len(lesson.steps[middle].examples) :]
                assert violations(page, axe) == []
                page.reload()
                robot.begin("Continue")
        for number, kind in enumerate(answers):
            robot.answer(number, kind)
            if number in (4, 9):
                robot.hear()
                if number == 4:
                    robot.choices()
                    page.evaluate("self.played.splice(0)")
                    assert violations(page, axe) == []
                    page.reload()
                    robot.begin("Continue")
        robot.reader.until(lambda: robot.reader.heading() == "Your score", "the score")
        assert "8 of 10 right" in page.text_content("main")
        assert violations(page, axe) == []
        stored = json.loads(scores.read_text())[preset]
        # questions alone, at once, if one wants them
        robot.reader.push("Ask ten questions")
        robot.begin()
        robot.reader.until(lambda: page.query_selector(".choice"), "a question")
        assert page.text_content("#count") == "0 of 10"
    assert wrong == []
    assert "progress" not in stored
    (score,) = stored["scores"]
    assert (score["right"], score["of"]) == (8, 10)
    assert score["confused"] == [[lesson.questions[n].kind, answers[n]] for n in (2, 7)]
    # each example once, to its end; what the reloads cut off has been played again
    wanted += [one for step in lesson.questions for one in step.examples]
    assert all(one["peak"] > 0.01 for one in robot.heard)
    found = sorted(round(one["duration"], 2) for one in robot.heard)
    corrections = [lesson.references[lesson.questions[n].kind] for n in (2, 7)]
    expected = sorted(round(one.duration_s, 2) for one in (*wanted, *corrections))
    assert len(found) == len(expected)
    assert found == pytest.approx(expected, abs=0.02)


def test_the_page_fits_a_phone_in_both_appearances(chromium, axe, tmp_path):
    with (
        served_lesson("plain", tmp_path / "scores.json") as url,
        page_at(chromium, url, viewport=PHONE, has_touch=True) as (page, wrong),
    ):
        page.wait_for_selector("button.done")
        page.tap("button.done")
        page.wait_for_selector('button.done[aria-disabled="false"]')
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            assert violations(page, axe) == []
            assert not page.evaluate("document.documentElement.scrollWidth > innerWidth")
            heights = page.evaluate(
                "[...document.querySelectorAll('button')].map((one) => one.offsetHeight)"
            )
            assert min(heights) >= 44
        assert wrong == []


def test_the_page_of_a_timeline_has_the_lesson_under_more(chromium, tmp_path):
    data = {"XDG_DATA_HOME": str(tmp_path)}
    with (
        served("serve", "world-cup-final-2018", **data) as url,
        page_at(chromium, url) as (page, wrong),
    ):
        # until then its buttons do nothing
        page.wait_for_selector("#learn:not([hidden])", state="attached")
        page.click("#settings")
        page.click("#learn")
        reader = Reader(page)
        reader.until(lambda: reader.heading() == "Learn what it feels like", "the lesson")
        assert page.url.endswith("/learn/")
        page.add_init_script(LISTENING.replace("FASTER", "12"))
        page.reload()
        robot = Robot(page, make_lesson("football"))
        robot.begin()
        robot.follow(robot.lesson.steps[0])
        robot.wait_for(robot.lesson.steps[1].text, "Next")
        robot.hear()
        assert len(robot.heard) == 2
        assert all(one["peak"] > 0.01 for one in robot.heard)
        # the page of the timeline is there as before
        page.go_back()
        page.wait_for_selector("#settings")
    assert wrong == []
    stored = json.loads((tmp_path / "overview-dsp" / "lessons.json").read_text())
    assert stored["football"]["progress"]["done"] == 1
