"""What other tools read, by the rules that they publish."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_studies.design import load_design
from overview_studies.observers import Observers, simulate_answers, store_simulated
from overview_studies.replay import replay_trial, take_gesture
from overview_studies.stimuli import stimuli_of
from overview_studies.store import Store
from studies.tests.files import study_of, varying, written
from tests.cli.running import overview, refused

PSYCH_DS_FILE = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")


def exported(to, *arguments, out):
    outcome = overview("study", "export", *arguments, "--to", to, "-o", out)
    assert outcome.code == 0, outcome.err
    return out


def table(path, delimiter=","):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file, delimiter=delimiter))
    assert {len(row) for row in rows} == {len(rows[0])}
    assert "" not in rows[0]
    assert len(set(rows[0])) == len(rows[0])
    return rows


def test_psych_ds_has_its_description_and_every_column_is_in_it(built, tmp_path):
    out = exported("psych-ds", built.answers, out=tmp_path / "d")
    described = json.loads((out / "dataset_description.json").read_text())
    assert described["@context"] == "https://schema.org/"
    assert described["@type"] == "Dataset"
    assert {"name", "description", "variableMeasured"} <= described.keys()
    known = {one["name"] for one in described["variableMeasured"]}
    files = sorted((out / "data").rglob("*.csv"))
    assert len(files) == 12
    for path in files:
        assert PSYCH_DS_FILE.fullmatch(path.name)
        rows = table(path)
        assert set(rows[0]) <= known
        assert all(one["description"] for one in described["variableMeasured"])


def test_bids_has_participants_and_a_table_each_with_described_columns(built, tmp_path):
    out = exported("bids", built.answers, out=tmp_path / "d")
    described = json.loads((out / "dataset_description.json").read_text())
    assert described["BIDSVersion"]
    assert described["DatasetType"] == "raw"
    people = table(out / "participants.tsv", "\t")
    assert people[0][0] == "participant_id"
    about = json.loads((out / "task-identify_beh.json").read_text())
    for label, *_ in people[1:]:
        assert re.fullmatch(r"sub-[A-Za-z0-9]+", label)
        rows = table(out / label / "beh" / f"{label}_task-identify_beh.tsv", "\t")
        assert rows[0][:4] == ["trial_type", "response_time", "response", "stim_file"]
        assert rows[0][4] == "simulated"
        assert set(rows[0]) <= about.keys()
        times = [float(row[1]) for row in rows[1:]]
        assert 0.1 < np.median(times) < 10.0  # s, not ms
        assert all(cell for row in rows for cell in row)


def test_psychopy_gets_a_conditions_file_a_list_with_its_sounds(tmp_path):
    toml = written(tmp_path, varying("compare"))
    out = exported("psychopy", "--study", toml, out=tmp_path / "d")
    for number in (1, 2):
        rows = table(out / f"list-0{number}.csv")
        # as its reader wants them: letters, digits, underscores, a letter first
        assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) for name in rows[0])
        columns = dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))
        for name in {*columns["sound_file"], *columns["sound_file_2"]}:
            samples, rate = soundfile.read(out / name, dtype="float32")
            assert (samples.shape[1], rate) == (2, 48_000)
            assert samples.any()


def test_psignifit_gets_levels_right_answers_and_trials(tmp_path):
    study, lists = study_of(tmp_path, varying("compare"))
    path = tmp_path / "r.sqlite"
    store = Store(path, study, list(lists.values()), simulated=True)
    store_simulated(store, simulate_answers(study, lists, Observers(), 2, 0))
    store.close()
    rows = table(exported("psignifit", path, out=tmp_path / "d") / "SIMULATED-psignifit.csv")
    assert rows[0] == ["simulated", "participant", "level", "right", "trials"]
    everybody = np.array([row[2:] for row in rows[1:] if row[1] == "all"], dtype=float)
    assert everybody[:, 0].tolist() == [2.0, 4.0, 16.0, 32.0]
    assert everybody[:, 2].tolist() == [8.0] * 4
    assert (everybody[:, 1] <= everybody[:, 2]).all()
    # the weaker ones are seldom taken for the stronger
    assert everybody[0, 1] < everybody[-1, 1]


def hand(seed):
    """A take as a page keeps it."""
    rng = np.random.default_rng(seed)
    samples = np.cumsum(rng.integers(300, 900, 60))
    theta2 = np.clip(np.cumsum(rng.normal(0.04, 0.05, 60)), 0.0, np.pi)
    events = [[int(s), float(a), 1, "touch"] for s, a in zip(samples, theta2, strict=True)]
    events[-1][2] = 0
    return {"sample_rate": 48_000, "samples": int(samples[-1]) + 4_800, "events": events}


@pytest.mark.parametrize("mapping", ["friction", "static"])
def test_a_trial_is_felt_again_bit_for_bit(built, tmp_path, mapping):
    study = json.loads((built.folder / "study.json").read_text())
    lists = [json.loads(path.read_text()) for path in sorted((built.folder / "lists").iterdir())]
    path = tmp_path / "r.sqlite"
    store = Store(path, study, lists)
    session, _ = store.begin("a" * 20, "anna")
    step = next(s for s in lists[0]["steps"] if s["type"] == "trial" and s["phase"] == "main"
                and s["output"]["mapping"] == mapping)  # fmt: skip
    take = hand(3)
    row = {"response": "goal", "take": take}
    store.put(session.id, step["id"], json.dumps(row))
    # who answers without a movement has no take to be felt again
    after = next(s["id"] for s in lists[0]["steps"] if s["type"] == "trial" and s is not step)
    still = {"response": "goal", "take": {**take, "events": []}}
    store.put(session.id, after, json.dumps(still))
    store.close()
    out = exported("wav", path, "--study", built.toml, out=tmp_path / "w")
    index = table(out / "takes.csv")
    assert len(index) == 2
    samples, rate = soundfile.read(out / index[1][-1], dtype="float32")
    assert (rate, len(samples)) == (48_000, take["samples"])
    item = next(i for i in stimuli_of(load_design(built.toml)) if i.key == step["stimuli"][0])
    assert np.array_equal(samples, replay_trial(item, take, step["output"]))
    assert samples[:, 1].any()
    # the take is one of any: the command line plays it to the same samples
    kept = ov.load_gesture(out / index[1][-2])
    hand_again = take_gesture(take)
    assert hand_again.stamps(48_000).tolist() == [sample for sample, *_ in take["events"]]
    assert hand_again.theta2.tolist() == [angle for _, angle, *_ in take["events"]]
    # a last line says when it was over
    assert np.array_equal(kept.stamps(48_000)[:-1], take_gesture(take).stamps(48_000))
    if mapping == "friction":
        again = ov.render(item.timeline, item.preset, kept, 48_000, item.seed, tail="none")
        assert np.array_equal(again.samples[: len(samples)], samples)


def test_takes_of_another_version_of_the_study_are_refused(built, tmp_path):
    changed = written(tmp_path, built.toml.read_text().replace("seed = 7", "seed = 8"))
    refused(
        overview("study", "export", built.answers, "--to", "takes", "--study", changed,
                 "-o", tmp_path / "x"),
        "another version",
    )  # fmt: skip
