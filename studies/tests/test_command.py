"""From a TOML file to a report, by the command line."""

from __future__ import annotations

import csv
import json
import re
import shutil

import pytest

from studies.tests.files import IDENTIFY, detecting, written
from tests.cli.running import overview, refused


def said(*arguments):
    outcome = overview("study", *arguments)
    assert outcome.code == 0, outcome.err
    return outcome.out


NAMED_BY_THE_FORMAT = {
    "dataset_description.json", "README.md", "CHANGES.md", "participants.tsv", "participants.json",
    "task-identify_beh.json",
}  # fmt: skip


def rows_of(path, delimiter=","):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter=delimiter))


def test_check_says_what_a_study_makes_and_whether_it_is_balanced(tmp_path):
    toml = written(tmp_path, IDENTIFY)
    found = json.loads(said("check", toml, "--measure-levels", "--json"))
    assert (found["lists"], found["round"], found["balanced"]) == (4, 4, True)
    assert found["trials"] == {"practice": 8, "main": 24, "catch": 8, "attention": 2}
    for one in found["felt_db"]:
        if one["friction"] is not None:
            assert abs(one["friction"] - one["static"]) < 0.5
    odd = written(tmp_path, IDENTIFY.replace("participants = 4", "participants = 5"), "odd.toml")
    assert "participants = 5: not balanced, each round has 4 lists" in said("check", odd)


def test_lists_are_a_csv_each(tmp_path):
    toml = written(tmp_path, IDENTIFY)
    said("lists", toml, "-o", tmp_path / "lists")
    names = sorted(path.name for path in (tmp_path / "lists").iterdir())
    assert names == [f"list-00{i}.csv" for i in (1, 2, 3, 4)]
    rows = rows_of(tmp_path / "lists" / "list-002.csv")
    assert {row["input"] for row in rows if row["type"] == "trial"} == {"twist"}


def test_a_folder_has_all_that_its_lists_play_and_the_same_bytes_again(built, tmp_path):
    study = json.loads((built.folder / "study.json").read_text())
    assert study["design_sha256"]
    for stimulus in study["stimuli"].values():
        names = [stimulus["image"], stimulus["drawn"], *stimulus["patches"].values(),
                 *stimulus["static"].values()]  # fmt: skip
        assert all((built.folder / name).is_file() for name in names)
        assert re.fullmatch("[0-9a-f]{64}", stimulus["sha256"])
    for number in range(1, 13):
        content = json.loads((built.folder / "lists" / f"{number:03d}.json").read_text())
        for step in content["steps"]:
            assert set(step.get("stimuli", ())) <= set(study["stimuli"])
    again = tmp_path / "again"
    said("build", built.toml, "-o", again)
    assert (again / "files.js").read_text() == (built.folder / "files.js").read_text()


def test_a_report_says_what_was_simulated_and_that_it_was(built, tmp_path):
    outcome = overview("study", "analyse", built.answers, "-o", tmp_path / "report")
    assert outcome.code == 0, outcome.err
    assert "d_prime, mapping static - friction: -" in outcome.out
    names = {path.name for path in (tmp_path / "report").iterdir()}
    made = {"results.json", "methods.txt", "responses.csv", "forms.csv", "analysis.R",
            "confusion.png", "d_prime.svg", "tlx.png", "rt.png"}  # fmt: skip
    assert {f"SIMULATED-{name}" for name in made} <= names
    text = (tmp_path / "report" / "SIMULATED-methods.txt").read_text()
    assert text.startswith("SIMULATED DATA: no person took part")
    for words in ("12 simulated observers", "Williams square", "seed 7", "static condition",
                  "Hautus", "SHA-256", "above chance",
                  "difference mapping static - friction"):  # fmt: skip
        assert words in text, words
    results = json.loads((tmp_path / "report" / "SIMULATED-results.json").read_text())
    changes = {(one["measure"], *one["condition"].items()): one for one in results["differences"]}
    # two d' less of three: as each choice is told from the others
    assert changes["d_prime", ("mapping", "static - friction")]["high"] < -0.5
    rows = rows_of(tmp_path / "report" / "SIMULATED-responses.csv")
    assert len(rows) == 12 * (24 + 8 + 8 + 2)
    assert all(len(row["stimulus_sha256"]) == 64 for row in rows)


def test_all_that_is_made_of_simulated_answers_says_so(built, tmp_path):
    assert said("analyse", built.answers, "-o", tmp_path / "report").startswith("SIMULATED")
    for to in ("psych-ds", "bids", "csv", "r"):
        said("export", built.answers, "--to", to, "-o", tmp_path / to)
    title = "SIMULATED: Touch against twist"
    assert json.loads((tmp_path / "psych-ds/dataset_description.json").read_text())["name"] == title
    assert json.loads((tmp_path / "bids/dataset_description.json").read_text())["Name"] == title
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) > 40
    for path in files:
        if path.suffix in (".csv", ".tsv"):
            rows = rows_of(path, "\t" if path.suffix == ".tsv" else ",")
            assert {row["simulated"] for row in rows} == {"SIMULATED"}, path
        if path.suffix in (".txt", ".md", ".R", ".svg") and path.name != "CHANGES.md":
            assert "SIMULATED" in path.read_text(), path  # pictures, too, have it as text
        if path.name not in NAMED_BY_THE_FORMAT:
            assert "SIMULATED" in path.name, path


def test_simulated_answers_are_neither_served_nor_mixed(built, tmp_path):
    from overview_studies.folder import read_study
    from overview_studies.store import Store

    refused(overview("study", "serve", built.folder, "--db", built.answers), "simulated answers")
    people = tmp_path / "people.sqlite"
    study, lists = read_study(built.folder)
    Store(people, study, lists).close()  # as a server leaves it that nobody has come to
    refused(overview("study", "simulate", built.folder, "-o", people), "the answers of people")
    store = Store(people)
    session, _ = store.begin("a" * 20, "anna")
    store.put(session.id, lists[0]["steps"][1]["id"], '{"response": "goal"}')
    store.close()
    for command in ("analyse", "export"):
        out = ("-o", tmp_path / command)
        outcome = overview("study", command, people, built.answers, *out)
        refused(outcome, "people.sqlite", "simulated.sqlite", "apart")
        assert not (tmp_path / command).exists()
    said("export", people, "--to", "csv", "-o", tmp_path / "csv")
    assert "SIMULATED" not in (tmp_path / "csv" / "responses.csv").read_text()
    # a file of an earlier version, which has no field that says what it is
    old = tmp_path / "old.sqlite"
    shutil.copy(built.answers, old)
    store = Store(old)
    with store._transaction():
        store._db.execute("DELETE FROM study WHERE key = 'simulated'")
    store.close()
    refused(overview("study", "serve", built.folder, "--db", old), "simulated answers")


def test_offline_csvs_give_the_same_as_the_server(built, tmp_path):
    from overview_studies.store import Store

    store = Store(built.answers)
    columns = ["session", "participant", "list", "trial", "received_utc", "response", "row"]
    paths = []
    for session in store.sessions():
        path = tmp_path / f"{session.participant}.csv"
        with open(path, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            for trial, utc, row in session.trials:
                writer.writerow(
                    [session.id, session.participant, session.number, trial, utc,
                     json.dumps(row["response"]), json.dumps(row)]
                )  # fmt: skip
        paths.append(path)
    store.close()
    server = json.loads(said("analyse", built.answers, "--json"))
    offline = json.loads(said("analyse", *paths, "--study", built.folder, "--json"))
    assert offline == server


def test_who_did_not_finish_or_attend_is_left_out_as_the_file_said(built, tmp_path):
    from overview_studies.store import Store

    copy = tmp_path / "some.sqlite"
    shutil.copy(built.answers, copy)
    store = Store(copy)
    with store._transaction():
        store._db.execute("UPDATE session SET finished_utc = NULL WHERE list = 3")
    store.close()
    outcome = overview("study", "analyse", copy)
    assert "excluded: sim003: the session is not complete" in outcome.err


def test_impossible_answers_are_named_and_left_out(built, tmp_path):
    from overview_studies.store import Store

    copy = tmp_path / "some.sqlite"
    shutil.copy(built.answers, copy)
    store = Store(copy)
    with store._transaction():
        for number, value in ((2, "-3.0"), (5, "1e12")):
            store._db.execute(
                "UPDATE trial SET row = json_set(row, '$.rt_ms', ?) WHERE trial = 'b1-004' AND "
                "session = (SELECT id FROM session WHERE list = ?)", (float(value), number),
            )  # fmt: skip
    store.close()
    outcome = overview("study", "analyse", copy)
    for code in ("sim002", "sim005"):
        assert f"excluded: {code}: impossible answer b1-004: rt_ms is" in outcome.err


def test_power_counts_how_often_an_effect_is_found(tmp_path):
    text = detecting(8, 8, 'mapping = { within = ["friction", "static"], order = "williams" }')
    said("build", written(tmp_path, text), "-o", tmp_path / "f")
    large = json.loads(
        said("simulate", tmp_path / "f", "--effect", "mapping.static=-2.5", "--d-prime", "3",
             "--power-runs", "6", "--json")
    )  # fmt: skip
    none = json.loads(said("simulate", tmp_path / "f", "--power-runs", "6", "--json"))
    assert large["found"]["mapping static - friction"] == 6
    assert none["found"]["mapping static - friction"] <= 2


def test_mistakes_are_one_line(built, tmp_path):
    refused(overview("study", "check", tmp_path / "none.toml"), "none.toml", "can't be read")
    refused(overview("study", "serve", tmp_path), "no study", "overview study build")
    refused(overview("study", "analyse", tmp_path / "none.sqlite"), "no such file")
    refused(overview("study", "export", "-o", tmp_path / "x"), "requires answers")
    refused(overview("study", "export", "--to", "psychopy", "-o", "x"), "--study study.toml")
    refused(
        overview("study", "export", built.answers, "--to", "psignifit", "-o", tmp_path / "x"),
        "compare, staircase and quest",
    )
    refused(
        overview("study", "simulate", built.folder, "--effect", "mapping.statik=1"),
        "mapping.static",
    )
    refused(overview("study", "simulate", built.folder, "--effect", "1"), "FACTOR.LEVEL=NUMBER")


def test_a_server_that_is_started_anew_has_the_same_address(built, tmp_path):
    database, elsewhere = tmp_path / "kept.sqlite", tmp_path / "elsewhere"
    command = ("study", "serve", built.folder, "--db", database, "--port", "0", "--seconds", "0.1")
    addresses = []
    for more in ((), (), ("--token-file", elsewhere)):
        outcome = overview(*command, "--json", *more)
        assert outcome.code == 0, outcome.err
        addresses.append(json.loads(outcome.out)["address"].partition("#token=")[2])
    kept = tmp_path / "kept.sqlite.token"
    assert addresses[0] == addresses[1] == kept.read_text().strip()
    assert addresses[2] == elsewhere.read_text().strip() != addresses[0]
    assert kept.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("seconds", ["0.2"])
def test_serve_prints_its_address_and_an_abandoned_list_can_be_given_again(
    built, tmp_path, seconds
):
    database = tmp_path / "served.sqlite"
    outcome = overview("study", "serve", built.folder, "--db", database, "--port", "0",
                       "--seconds", seconds, "--json")  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["address"].startswith("http://127.0.0.1:")
    assert "0 of 12 lists are in use" in outcome.err
    refused(overview("study", "serve", built.folder, "--db", database, "--reissue", "2"),
            "list 2 is not in use")  # fmt: skip
