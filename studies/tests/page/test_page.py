"""A study's page in a real Chromium: by keyboard and screen reader, by touch, without a network."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pytest

from overview_studies.answers import read_answers
from overview_studies.design import load_design
from overview_studies.replay import replay_trial
from overview_studies.stimuli import stimuli_of
from studies.tests.page.participant import Reader, step, take_part
from studies.tests.page.study_server import built, served_study, trials_of
from tests.web.driving import PHONE
from tests.web.exported import opened_host

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
start = ["consent", "about.html"]
each = ["tlx"]
end = ["comments"]
consent = { version = "1", text = "I take part of my own will." }
"""
ABOUT = """
<label>Age <input type="number" name="age" min="18" max="120" required></label>
<label><input type="checkbox" name="plays" value="guitar"> I play the guitar</label>
<label><input type="checkbox" name="plays" value="drums"> I play the drums</label>
<label>Hand <select name="hand"><option>right</option><option>left</option></select></label>
<script>document.title = "a script of a form ran"</script>
"""


@pytest.fixture(scope="module")
def identify(tmp_path_factory):
    return built(tmp_path_factory.mktemp("identify"), IDENTIFY, about=ABOUT)


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
        assert page.title() == "Friction against static"
        rows = server.rows()
    assert wrong == []
    assert list(rows) == [one["id"] for one in wanted]  # in order, each once
    forms = {one["form"]: rows[one["id"]]["response"] for one in wanted if one["type"] == "form"}
    assert forms["consent"] == {"version": "1", "agreed": True}
    assert forms["about"] == {"age": 33, "plays": ["guitar"], "hand": "right"}
    assert set(forms["tlx"].values()) == {60}
    assert forms["comments"] == {"comments": 'well, "fine"'}
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


OUTSIDE = """() => {
    document.documentElement.style.fontSize = "200%";
    const { left, right } = document.querySelector("#jspsych-content").getBoundingClientRect();
    const cut = [...document.querySelectorAll("header p, h1, p, button, .pad, input")]
        .filter((one) => one.offsetParent !== null)
        .filter((one) => {
            const box = one.getBoundingClientRect();
            return box.width > 1 && (box.left < left || box.right > right + 1 ||
                one.scrollWidth > one.clientWidth + 1);
        });
    return [document.documentElement.scrollWidth - innerWidth, ...cut.map((one) => one.outerHTML)];
}"""


def test_nothing_is_cut_off_on_a_phone_with_text_twice_as_large(chromium, identify, tmp_path):
    phone = {"viewport": {"width": 360, "height": 740}, "color_scheme": "dark"}
    with (
        served_study(identify, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url, **phone) as (page, wrong),
    ):
        reader = Reader(page)
        seen = set()
        while len(seen) < 4:
            before = reader.until(reader.heading, "a heading")
            if page.query_selector("#jspsych-content"):
                assert page.evaluate(OUTSIDE) == [0], before
                seen.add(before)
            if before == "What did you feel?":
                break
            step(reader, feel_and_choose([1]), "What did you feel?")
        assert "What did you feel?" in seen
    assert wrong == []


LOCATE = """
title = "Where was it"
name = "where"
seed = 5
participants = 2
[task]
name = "locate"
[stimuli]
made = { kinds = ["goal"], variants = 2 }
presets = ["football"]
gestures = ["free"]
[phases]
practice = { repeats = 1, feedback = true }
[output]
channel = "visual"
input = "touch"
"""
COUNT = """
title = "How many"
name = "how-many"
seed = 5
participants = 3
[task]
name = "count"
[stimuli]
made = { kinds = ["goal"], counts = [1, 3] }
presets = ["football"]
gestures = ["sweep:0.4"]
[output]
mask = { noise = "pink", level_db = -30.0 }
"""


def drag(page, client, to):
    """A finger goes from the pad's start to a place (0 to 1), and off."""
    box = page.locator(".pad").bounding_box()
    margin = 18
    y = box["y"] + box["height"] / 2
    for i in range(11):
        x = box["x"] + margin + (box["width"] - 2 * margin) * to * i / 10
        kind = "touchStart" if i == 0 else "touchMove"
        client.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
        page.wait_for_timeout(16)
    page.wait_for_timeout(200)  # it rests, so that it is no fling: a tap would only end that
    client.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_timeout(300)


def test_a_whole_session_by_touch_at_phone_size(chromium, tmp_path):
    folder = built(tmp_path, LOCATE)
    trials = trials_of(folder)
    with (
        served_study(folder, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url, viewport=PHONE, has_touch=True) as (page, wrong),
    ):
        client = page.context.new_cdp_session(page)
        page.tap("text=Begin")
        page.wait_for_selector("text=Start")
        page.wait_for_timeout(600)  # at the place of Begin, a tap at once is the second of two
        page.tap("text=Start")
        for done, trial in enumerate(trials):
            # until then the pad is the last trial's
            page.wait_for_selector(f"text=/^{done} of {len(trials)}$/")
            page.wait_for_selector(".pad")
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            drag(page, client, 0.7)
            page.tap("text=It is here")
            if trial["feedback"]:
                page.tap("text=Next")
        page.wait_for_selector("text=Thank you")
        rows = server.rows()
    assert wrong == []
    assert list(rows) == [one["id"] for one in trials]
    for row in rows.values():
        assert row["response"] == pytest.approx(0.7, abs=0.01)
        assert row["source"] == "touch"
        assert row["device"]["touch"]
        assert max(angle for _, angle, _, _ in row["take"]["events"]) > 2.0


def answer_count(reader):
    """Play it, wait for its end, and say two."""
    reader.push("Play")
    reader.until(lambda: reader.enabled("Answer"), "the end of it")
    reader.go_to("spinbutton", "How many")
    reader.press("2")
    reader.push("Answer")


def test_a_whole_session_without_a_network(chromium, tmp_path):
    folder = built(tmp_path, COUNT)
    with opened_host(folder) as host, page_at(chromium, f"{host.url}?list=2") as (page, wrong):
        page.wait_for_selector("text=Begin")
        page.wait_for_timeout(1000)
        page.evaluate("navigator.serviceWorker.ready")
        reader = Reader(page)
        kept = "(async () => (await (await caches.open((await caches.keys())[0])).keys()).length)()"
        count = sum(1 for file in folder.rglob("*") if file.is_file())
        reader.until(lambda: page.evaluate(kept) >= count, "all files kept")
        page.context.set_offline(True)
        host.close()
        page.reload()
        with page.expect_download() as download:
            take_part(reader, answer_count, "How many were there?")
            reader.push("Download")
        file = tmp_path / download.value.suggested_filename
        download.value.save_as(file)
    assert wrong == []
    assert file.name == "how-many_p002.csv"
    answers = read_answers([file], folder)
    (session,) = answers.sessions
    assert session.finished_utc is not None
    assert [trial for trial, _, _ in session.trials] == [one["id"] for one in trials_of(folder, 2)]
    assert {row["response"] for row in answers.rows()} == {2}
    assert {row["correct"] for row in answers.rows()} == {0}


FELT = """async ([key, output, events, frames]) => {
    const [{ StimulusPlayer }, { Server }] = await Promise.all([
        import("./stimulus_player.js"),
        import("./client.js")]);
    const file = (path) => new Server(null).file(path);
    const study = await (await file("study.json")).json();
    const felt = new StimulusPlayer(study, file);
    felt.context = new OfflineAudioContext(2, frames, 48000);
    const presentation = await felt.open(key, output, []);
    let done = 0;
    for (const [sample] of events) {
        const quantum = 128 * Math.ceil(sample / 128);
        if (quantum > done && quantum < frames) {
            felt.context.suspend(quantum / 48000).then(async () => {
                try {
                    for (const [at, place, touching] of events) {
                        if (128 * Math.ceil(at / 128) === quantum) {
                            presentation.control(place, touching, -1);
                        }
                    }
                    await presentation.readState();
                } finally {
                    felt.context.resume();  // an error fails the test
                }
            });
            done = quantum;
        }
    }
    const sound = await felt.context.startRendering();
    await presentation.readState();
    const samples = [0, 1].map((channel) => Array.from(sound.getChannelData(channel)));
    return { samples, take: { sample_rate: 48000, samples: frames, events: presentation.events } };
}"""


@pytest.mark.parametrize("mapping", ["friction", "static"])
def test_what_was_felt_is_felt_again_bit_for_bit(chromium, identify, mapping):
    """A take of free exploration, replayed in Python, has the samples of the page."""
    study = json.loads((identify / "study.json").read_text())
    key = next(key for key, one in study["stimuli"].items() if one["answer"] == "goal")
    output = {"mapping": mapping, "click_db": -6.0, "tactor_db": None}
    hand = [[1_000 + 300 * i, i / 60, True] for i in range(60)] + [[20_000, 1.0, False]]
    frames = 48_000
    with opened_host(identify) as host, page_at(chromium, host.url) as (page, wrong):
        found = page.evaluate(FELT, [key, output, hand, frames])
    assert wrong == []
    item = {one.key: one for one in stimuli_of(load_design(identify.parent / "study.toml"))}[key]
    assert len(found["take"]["events"]) == len(hand)
    again = replay_trial(item, found["take"], output)
    presented_stimuli = np.array(found["samples"], np.float32).T
    assert np.array_equal(presented_stimuli, again)
    assert np.abs(again[:, 0]).max() > 0.01
    assert not again[:, 1].any()


LATE = """async ([key, output, late_ms]) => {
    const [{ StimulusPlayer }, { Server }] = await Promise.all([
        import("./stimulus_player.js"),
        import("./client.js")]);
    const file = (path) => new Server(null).file(path);
    const felt = new StimulusPlayer(await (await file("study.json")).json(), file);
    await felt.context.suspend();
    const presentation = await felt.open(key, output, []);
    for (const i of [1, 2, 3]) presentation.control(i / 10, true, -1);
    presentation.control(0.3, false, -1);
    if (late_ms !== null) setTimeout(() => felt.context.resume(), late_ms);
    const take = await presentation.take();
    await felt.context.close();
    return take;
}"""


@pytest.mark.parametrize("mapping", ["friction", "static"])
def test_a_take_has_each_event_however_late_the_sound_begins(chromium, identify, mapping):
    study = json.loads((identify / "study.json").read_text())
    key = next(key for key, one in study["stimuli"].items() if one["answer"] == "goal")
    output = {"mapping": mapping, "click_db": -6.0, "tactor_db": None}
    with opened_host(identify) as host, page_at(chromium, host.url) as (page, wrong):
        late = page.evaluate(LATE, [key, output, 1200])
        never = page.evaluate(LATE, [key, output, None])
    assert wrong == []
    assert [touching for _, _, touching, _ in late["events"]] == [1, 1, 1, 0]
    assert "pending" not in late
    assert never["events"] == []
    assert never["pending"] == 4


MASKED = """async () => {
    const [{ StimulusPlayer }, { Server }] = await Promise.all([import("./stimulus_player.js"),
        import("./client.js")]);
    const file = (path) => new Server(null).file(path);
    const felt = new StimulusPlayer(await (await file("study.json")).json(), file);
    felt.context = new OfflineAudioContext(2, 48000, 48000);
    await felt.mask(true);
    const sound = await felt.context.startRendering();
    return [0, 1].map((channel) => Array.from(sound.getChannelData(channel)));
}"""


def test_the_mask_is_for_the_ears_alone_and_as_loud_as_asked(chromium, tmp_path):
    folder = built(tmp_path, COUNT)
    with opened_host(folder) as host, page_at(chromium, host.url) as (page, wrong):
        click, tactor = np.array(page.evaluate(MASKED))
    assert wrong == []
    assert 20 * np.log10(np.sqrt(np.mean(click**2))) == pytest.approx(-30.0, abs=1.0)
    assert not tactor.any()


def test_who_does_not_agree_leaves_nothing(chromium, identify, tmp_path):
    with (
        served_study(identify, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url) as (page, wrong),
    ):
        page.click("text=Begin")
        page.click("text=I do not agree")
        page.wait_for_selector("text=nothing was stored")
        page.reload()
        page.wait_for_selector("text=Begin")  # ready for somebody else
        assert server.rows() == {}
    assert wrong == []


def test_a_session_is_open_in_one_tab(chromium, identify, tmp_path):
    with (
        served_study(identify, tmp_path / "answers.sqlite") as server,
        page_at(chromium, server.url) as (page, wrong),
    ):
        page.click("text=Begin")
        page.wait_for_selector("text=Consent")
        other = page.context.new_page()
        other.goto(server.url)
        other.click("text=Continue")
        other.wait_for_selector("text=open in another tab")
        page.close()
        other.reload()
        other.click("text=Continue")
        other.wait_for_selector("text=Consent")
    assert wrong == []
