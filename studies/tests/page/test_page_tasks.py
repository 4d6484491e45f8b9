"""Each task of a study's page: a short session by keyboard, every screen of it accessible."""

from __future__ import annotations

import pytest

from studies.tests.page.participant import Reader, step
from studies.tests.page.study_server import built, trials_of
from studies.tests.page.test_page import page_at
from tests.web.driving import violations
from tests.web.exported import opened_host

GAINS = 'parameters = { "tactor.gain_db" = [-18.0, -12.0, -6.0] }'
VARY = 'vary = "tactor.gain_db"\nstandard = -12.0'


def study(name, more="", kinds='kinds = ["goal"]', hand="free", stimuli="", phases="", output=""):
    return f"""
title = "A study"
name = "{name}"
seed = 5
participants = 1
[task]
name = "{name}"
question = "What?"
{more}
[stimuli]
made = {{ {kinds} }}
presets = ["football"]
gestures = ["{hand}"]
{stimuli}
[phases]
{phases}
[output]
{output}
"""


def feel(reader):
    reader.go_to("slider", "Field")
    reader.press("PageUp", 4)


def feel_both(reader):
    feel(reader)
    reader.push("second")
    feel(reader)


def play(reader):
    reader.push("Play")


def play_each(reader):
    for name in ("first", "second"):
        reader.push(f"Play the {name}")
        reader.until(lambda: reader.page.query_selector("[aria-disabled]") is None, "its end")


def answered(name):
    def press(reader):
        reader.until(lambda: reader.enabled(name), name)
        reader.push(name)

    return press


def digit(number):
    def press(reader):
        reader.until(lambda: reader.page.query_selector(".choice:not([disabled])"), "choices")
        reader.press(number)

    return press


def drawn(reader):
    reader.go_to("slider", "Height at 0 ")
    reader.press("ArrowUp", 4)
    answered("This is")(reader)


def on_scale(reader):
    reader.go_to("slider", "Where")
    reader.press("End")
    answered("It is here")(reader)


def more_of_it(reader):
    reader.push("More")
    answered("They are equal")(reader)


# of each: the study, how it is felt, how it is answered, what the answer is
TASKS = {
    "locate": (study("locate", phases="practice = { repeats = 1 }"), feel, answered("It is here"),
               lambda found: found == pytest.approx(0.4)),
    "search": (study("search", 'target = "goal"', output='channel = "all"'), feel,
               answered("It is here"), lambda found: found == pytest.approx(0.4)),
    "locate nothing": (study("locate", hand="sweep:0.3", output='input = "keys"'), play,
                       answered("Nothing there"), lambda found: found is None),
    "locate on a scale": (study("locate", hand="sweep:0.3", output='channel = "visual"'), play,
                          on_scale, lambda found: found == 1),
    "compare": (study("compare", VARY, stimuli=GAINS, output='channel = "tactor"'), feel_both,
                digit("2"), lambda found: found == 1),
    "adjust": (study("adjust", VARY, hand="sweep:0.3", stimuli=GAINS), play_each, more_of_it,
               lambda found: found == -12.0),
    "draw": (study("draw", kinds='curves = ["peak"]', output='channel = "visual"'), feel, drawn,
             lambda found: found[0] == 0.2 and len(found) == 64),
    "staircase": (study("staircase", f"{VARY}\nmax_trials = 3", hand="sweep:0.3", stimuli=GAINS),
                  play, digit("1"), lambda found: found == 0),
    "quest": (study("quest", 'vary = "tactor.gain_db"\nmethod = "yesno"\nmax_trials = 3',
                    stimuli=GAINS, phases="catch = 0.3"), feel, answered("I felt it"),
              lambda found: found == 1),
}  # fmt: skip


ALWAYS = ("locate", "search", "draw")
EACH = [name if name in ALWAYS else pytest.param(name, marks=pytest.mark.soak) for name in TASKS]


@pytest.mark.parametrize("name", EACH)
def test_a_task_by_keyboard_and_every_screen_of_it(chromium, axe, name, tmp_path):
    text, felt, answer, wanted = TASKS[name]
    folder = built(tmp_path, text)
    seen = []
    with opened_host(folder) as host, page_at(chromium, host.url) as (page, wrong):
        reader = Reader(page)

        def take(reader):
            felt(reader)
            if reader.heading() not in seen:
                seen.append(reader.heading())
                assert violations(page, axe) == []
            answer(reader)

        while (heading := reader.until(reader.heading, "a heading")) != "Thank you":
            if heading not in seen and heading != "What?":
                seen.append(heading)
                assert violations(page, axe) == []
            step(reader, take, "What?")
        assert violations(page, axe) == []
        kept = page.evaluate(KEPT)
    assert wrong == []
    rows = {key.partition("/")[2]: entry["row"] for key, entry in kept}
    first = trials_of(folder)[0]
    ids = [f"{first['id']}-{i:03d}" for i in (1, 2, 3)] if first["type"] == "adaptive" else None
    assert list(rows) == (ids or [one["id"] for one in trials_of(folder)])
    for row in rows.values():
        assert wanted(row["response"]), row["response"]
        assert row["presentations"] >= 1
    if first["type"] == "adaptive":
        levels = [row["level"] for row in rows.values() if row["level"] is not None]
        assert set(levels) <= set(first["levels"])


KEPT = """() => new Promise((resolve) => {
    const opening = indexedDB.open("overview-study");
    opening.onsuccess = () => {
        const store = opening.result.transaction("kept").objectStore("kept");
        const range = IDBKeyRange.bound("row ", "row \\uffff");
        const [keys, values] = [store.getAllKeys(range), store.getAll(range)];
        values.onsuccess = () => resolve(keys.result.map((key, i) => [key, values.result[i]])
            .sort(([, a], [, b]) => a.number - b.number));
    };
})"""
