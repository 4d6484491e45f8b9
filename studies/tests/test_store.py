"""What was acknowledged is there, once, whatever happens to servers, tabs and disks."""

from __future__ import annotations

import contextlib
import json
import sqlite3
import subprocess
import sys
import threading

import pytest

from overview_dsp.errors import InputError, OutputError
from overview_studies.forms import TLX
from overview_studies.store import NoListLeftError, Store
from studies.tests.client import Page, serving
from studies.tests.files import IDENTIFY, detecting, study_of
from tests.cli.running import ROOT, environment


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A study of four lists and its lists."""
    return study_of(tmp_path_factory.mktemp("small"), IDENTIFY)


@pytest.fixture
def store(tmp_path, small):
    study, lists = small
    found = Store(tmp_path / "responses.sqlite", study, list(lists.values()))
    yield found
    found.close()


@pytest.fixture
def page_of(tmp_path, small):
    """A page of a participant."""
    with serving(tmp_path, *small) as port, contextlib.ExitStack() as pages:
        yield lambda participant=None: pages.enter_context(
            contextlib.closing(Page(port, participant))
        )


def test_lists_are_handed_out_once_each_to_many_at_the_same_time(store):
    found, refused = [], []

    def take(i):
        try:
            found.append(store.begin(f"request-{i:020d}", None)[0].number)
        except NoListLeftError:
            refused.append(i)

    threads = [threading.Thread(target=take, args=(i,)) for i in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == [1, 2, 3, 4]
    assert len(refused) == 8


def test_the_same_request_is_the_same_session_and_a_code_has_one(store):
    first, new = store.begin("a" * 20, "anna")
    again, newer = store.begin("a" * 20, "anna")
    assert (new, newer, first.id) == (True, False, again.id)
    with pytest.raises(NoListLeftError, match="anna already has a session"):
        store.begin("b" * 20, "anna")
    assert store.begin("c" * 20, None)[0].number == 2


def test_an_abandoned_list_is_handed_out_again_only_when_told_to(store):
    first, _ = store.begin("a" * 20, "anna")
    assert store.begin("b" * 20, None)[0].number == 2
    assert store.abandon(1) == "anna"
    assert store.begin("c" * 20, "anna")[0].number == 1
    assert [one.abandoned for one in store.sessions()] == [True, False, False]
    with pytest.raises(InputError, match="list 4 is not in use"):
        store.abandon(4)
    assert store.list_number(first.id, "wrong") is None
    assert store.list_number(first.id, first.secret) == 1


def test_what_came_first_stays(store):
    session, _ = store.begin("a" * 20, None)
    assert store.put(session.id, "b1-001", '{"response": "goal"}')
    assert not store.put(session.id, "b1-001", '{"response": "foul"}')
    ((trial, _, row),) = store.session(session.id).trials
    assert (trial, row) == ("b1-001", {"response": "goal"})


def test_another_study_or_no_study_is_refused(tmp_path, small):
    study, lists = small
    path = tmp_path / "one.sqlite"
    Store(path, study, list(lists.values())).close()
    with pytest.raises(InputError, match="another version"):
        Store(path, {**study, "design_sha256": "0"}, list(lists.values()))
    with pytest.raises(InputError, match="no such file"):
        Store(tmp_path / "none.sqlite")
    (tmp_path / "text.sqlite").write_text("not a database, but long enough to be looked at")
    with pytest.raises(InputError, match="not a file of answers"):
        Store(tmp_path / "text.sqlite")


def test_a_database_that_is_locked_says_that_nothing_was_stored(store, monkeypatch):
    session, _ = store.begin("a" * 20, None)
    store._db.execute("PRAGMA busy_timeout = 50")
    other = sqlite3.connect(store.path, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    with pytest.raises(OutputError, match="nothing was stored"):
        store.put(session.id, "b1-001", '{"response": 1}')
    other.execute("ROLLBACK")
    other.close()
    assert store.put(session.id, "b1-001", '{"response": 1}')


def test_a_page_takes_a_list_stores_resumes_and_finishes(page_of, small):
    _, lists = small
    page = page_of("p-7")
    status, told = page.begin()
    assert (status, told["list"], told["participant"], told["answers"]) == (201, 1, "p-7", {})
    assert page.begin()[0] == 200
    steps = [s for s in lists[1]["steps"] if s["type"] in ("trial", "form")]
    trials = [s["id"] for s in steps if s.get("phase") != "practice"]
    assert page.finish() == (409, {"missing": trials})
    forms = {
        "consent": {"version": "1", "agreed": True},
        "tlx": dict.fromkeys(TLX, 50),
        "comments": {"comments": "none"},
    }
    for step in steps:
        if step["id"] in trials:
            response = forms[step["form"]] if step["type"] == "form" else "goal"
            row = {"response": response, "take": {"events": []}}
            assert page.put(step["id"], row)[0] == 201
    assert page.put(trials[1], {"response": "foul"})[0] == 200
    # practice that was repeated
    assert page.put("b1-p001-2", {"response": "goal"})[0] == 201
    status, seen = page.look()
    assert (status, list(seen["answers"])) == (200, [*trials, "b1-p001-2"])
    assert seen["answers"][trials[1]] == {
        "response": "goal", "correct": None, "stimulus": None, "level": None,
    }  # fmt: skip
    assert page.finish() == (200, {"complete": True})
    assert page.look()[1]["complete"]


def test_what_is_wrong_is_refused_with_one_line(page_of):
    page = page_of()
    assert page.ask("POST", "/study/sessions", {"request": "short"})[0] == 400
    assert page.ask("POST", "/study/sessions", {"request": "a" * 20}, token="wrong")[0] == 401
    assert page.ask("POST", "/study/sessions", {"request": "a" * 20, "x": 1})[0] == 400
    assert page.ask("POST", "/study/sessions", {"request": "simulated-" + "a" * 20})[0] == 400
    assert page.ask("POST", "/study/sessions",
                    {"request": "a" * 20, "participant": "Ann Smith"})[0] == 400  # fmt: skip
    page.begin()
    assert page.put("b9-001", {"response": 1})[0] == 404
    assert page.put("b1-p001-4", {"response": 1})[0] == 404
    assert page.put("b1-001", {"answer": 1})[0] == 400
    assert page.put("b1-001", [1])[0] == 400
    assert page.put("b1-001", {"response": float("nan")})[0] == 400
    impossible = [
        ("b1-001", {"response": "gaol"}, "one of the choices"),
        ("b1-001", {"response": "goal", "rt_ms": -5}, "rt_ms is -5"),
        ("b1-001", {"response": "goal", "source": "mouse"}, "touch, twist or keys"),
        ("b1-001", {"response": "goal", "source": "simulated observer"}, "simulated"),
        ("b0-form-1-consent", {"response": {"version": "1", "agreed": False}}, "consent"),
        ("b0-form-1-consent", {"response": {"version": "2", "agreed": True}}, "version"),
        ("b1-form-1-tlx", {"response": {**dict.fromkeys(TLX, 50), "effort": 999}}, "effort is 999"),
    ]
    assert page.put("b1-002", {"response": "goal", "source": "touch+keys"})[0] == 201
    for trial, row, reason in impossible:
        status, told = page.put(trial, row)
        assert status == 422, (trial, row, told)
        assert reason in str(told)
    assert list(page.look()[1]["answers"]) == ["b1-002"]
    other = page_of()
    other.told = {**page.told, "secret": "guessed"}
    assert other.put("b1-001", {"response": 1})[0] == 403
    assert page.ask("GET", "/study.json")[0] == 200
    assert page.ask("GET", "/../../etc/passwd")[0] == 404
    assert page.ask("GET", "/responses.sqlite")[0] == 404
    assert page.ask("GET", "/study.json", token="")[0] == 401


@pytest.mark.parametrize("kills", [6, pytest.param(1000, marks=pytest.mark.soak)])
def test_no_acknowledged_trial_is_lost_or_repeated_by_random_kills(tmp_path, kills):
    study, lists = study_of(tmp_path, detecting(participants=999, repeats=6))
    (tmp_path / "lists.json").write_text(json.dumps(lists))
    Store(tmp_path / "responses.sqlite", study, list(lists.values())).close()
    done = subprocess.run(
        [sys.executable, "-m", "studies.tests.killing", str(tmp_path), str(kills), "1"],
        cwd=ROOT, env=environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    store = Store(tmp_path / "responses.sqlite")
    kept = {
        (session.id, trial): row for session in store.sessions() for trial, _, row in session.trials
    }
    store.close()
    print(f"{found['kills']} kills, {len(kept)} trials, {len(found['acknowledged'])} acknowledged")
    assert found["kills"] >= kills
    assert len(set(found["lists"])) == len(found["lists"])
    for session, trial, row in found["acknowledged"]:
        assert kept[session, trial] == row
    # what was stored before a kill and acknowledged after it was asked for again
    assert {row["rt_ms"] for row in kept.values()} & {-1.0} == set()
