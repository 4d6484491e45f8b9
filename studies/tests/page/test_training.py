"""The training of a study in a real Chromium: examples, questions with a criterion, a reload."""

from __future__ import annotations

from studies.tests.page.participant import Reader
from studies.tests.page.study_server import built, served_study, trials_of
from studies.tests.page.test_page import page_at
from tests.web.driving import violations

TRAINED = """
title = "Trained"
seed = 4
participants = 1
[task]
name = "identify"
question = "Which was it?"
[stimuli]
made = { kinds = ["goal", "foul"] }
gestures = ["sweep:0.5"]
[training]
criterion = 8
most_rounds = 2
"""


def test_a_training_of_examples_and_two_rounds_of_questions(chromium, axe, tmp_path):
    import json

    folder = built(tmp_path, TRAINED)
    content = json.loads((folder / "lists" / "001.json").read_text())
    examples = [step for step in content["steps"] if step["type"] == "example"]
    questions = [step for step in trials_of(folder) if step["phase"] == "practice"]
    choices = json.loads((folder / "study.json").read_text())["task"]["choices"]

    def answer(reader, number, kind):
        reader.push("Play")
        reader.until(
            lambda: reader.page.query_selector(".choice:not([disabled])"), f"choices of {number}"
        )
        reader.press(str(1 + choices.index(kind)))
        reader.until(lambda: reader.page.query_selector(".feedback"), "feedback")
        reader.press("Enter")
        reader.until(lambda: not reader.page.query_selector(".feedback"), "what follows")

    with (
        served_study(folder, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url) as (page, wrong),
    ):
        reader = Reader(page)
        reader.until(lambda: reader.enabled("Begin"), "the start")
        reader.push("Begin")
        for step in examples:
            reader.until(lambda text=step["text"]: reader.heading() == text, step["text"])
            assert not reader.enabled("Next")
            if step is examples[0]:
                assert violations(page, axe) == []
            reader.push("Play")
            reader.until(lambda: reader.enabled("Next"), "the end of the example")
            reader.push("Next")
        # seven right answers are too few
        wrong_at = {0, 3, 6}
        for number, step in enumerate(questions):
            reader.until(lambda: reader.heading() == "Which was it?", "a question")
            other = next(kind for kind in choices if kind != step["correct"])
            answer(reader, number, other if number in wrong_at else step["correct"])
            if number == 4:  # no example is shown again
                page.reload()
                reader.until(lambda: reader.enabled("Continue"), "Continue")
                reader.push("Continue")
        reader.until(lambda: reader.heading() == "Once more", "the second round")
        reader.push("Start")
        for number, step in enumerate(questions[:2]):
            reader.until(lambda: reader.heading() == "Which was it?", "a question")
            answer(reader, number, step["correct"])
        rows = server.rows()
    assert wrong == []
    first = [rows[step["id"]]["correct"] for step in questions]
    assert first == [number not in wrong_at for number in range(len(questions))]
    assert list(rows)[len(questions) :] == [f"{step['id']}-2" for step in questions[:2]]
