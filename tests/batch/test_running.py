from __future__ import annotations

import contextlib
import io
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.batch import run_batch, storage, task
from overview_dsp.batch.grid import Keys
from overview_dsp.batch.manifest import PARTS
from overview_dsp.batch.storage import UNFINISHED, Storage
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.installation import install_command
from overview_dsp.measure.perceived_level import event_levels
from tests.batch.grids import CASES, JOBS, grid_in, hashes, jobs_file
from tests.cli.running import end_of_group, environment, overview, refused

pytestmark = pytest.mark.filterwarnings("ignore:preset 'heart' has no")
pytest.importorskip("fsspec", reason="needs the extra batch")
parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra batch")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The study as one process makes it in one go: its folder, and each file's hash."""
    folder = tmp_path_factory.mktemp("done")
    outcome = run_batch(grid_in(folder), workers=1)
    assert (outcome.cases, outcome.cached, outcome.rendered) == (CASES, 0, CASES)
    assert outcome.failed == ()
    return folder / "study", hashes(folder / "study")


def rows(folder):
    return parquet.read_table(folder / "manifest.parquet").to_pylist()


def test_every_case_has_a_sound_file_and_a_row(done, tmp_path):
    folder, files = done
    study = grid_in(tmp_path)
    table = rows(folder)
    assert [row["index"] for row in table] == list(range(CASES))
    assert {row["file"] for row in table} | {"manifest.parquet"} == set(files)
    for row in table[:: CASES // 7]:
        case = study.case(row["index"])
        timeline = study.timelines[row["timeline"]]
        assert list(study.timelines).index(row["timeline"]) == case.timeline
        preset = study.presets[row["preset"]].with_value("tactor.gain_db", row["tactor.gain_db"])
        assert (row["tactor.gain_db"], row["seed"]) == (case.values[0], case.seed)
        gesture = study.gestures[row["gesture"]]
        result = ov.render(timeline, preset, gesture, 8000, row["seed"], tail="none")
        result.save(tmp_path / "alone.wav")
        assert (folder / row["file"]).read_bytes() == (tmp_path / "alone.wav").read_bytes()
        assert row["sha256"] == files[row["file"]]
        assert row["bytes"] == (folder / row["file"]).stat().st_size
        assert row["frames"] == len(result.samples) == soundfile.info(folder / row["file"]).frames
        assert row["duration_s"] == row["frames"] / 8000
        for channel, name in enumerate(("peak_click_dbfs", "peak_tactor_dbfs")):
            peak = np.abs(result.samples[:, channel]).max()
            assert row[name] == (pytest.approx(20 * np.log10(peak)) if peak else None)
        assert row["strikes"] == len(result.strikes)
        levels = event_levels(
            result.engine.surface, result.trace, result.samples[:, 1], result.sample_rate
        )
        felt = np.flatnonzero(np.isfinite(levels))
        assert [event["level_db"] for event in row["felt"]] == levels[felt].tolist()
        assert [event["event"] for event in row["felt"]] == result.engine.surface.event[
            felt
        ].tolist()
        assert row["error"] is None
        for id in PARAMETERS:
            assert row[id] == preset.values[id]
    assert any(row["felt"] for row in table)
    assert all(-70.0 <= row["loudness_lufs"] < 0.0 for row in table)


def test_the_manifest_has_the_complete_presets(done):
    metadata = parquet.read_schema(done[0] / "manifest.parquet").metadata
    about = json.loads(metadata[b"overview_study"])
    assert about["presets"]["football"]["kinds"]["goal"]
    assert about["tail"] == "none"


def test_several_processes_make_the_same_files_and_a_second_run_makes_none(done, tmp_path):
    study = grid_in(tmp_path)
    told = []
    # said once, whichever process saw it
    with pytest.warns(ov.OverviewWarning) as notes:
        outcome = run_batch(study, workers=2, progress=lambda *what: told.append(what))
    assert len({str(note.message) for note in notes}) == len(notes) == 2
    assert outcome.rendered == CASES
    assert hashes(tmp_path / "study") == done[1]
    assert told[0] == (0, CASES)
    assert told[-1] == (CASES, CASES)
    assert told == sorted(told)
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "study" / "sounds").rglob("*.wav")}
    outcome = run_batch(study, workers=2)
    assert (outcome.cached, outcome.rendered) == (CASES, 0)
    assert {p: p.stat().st_mtime_ns for p in before} == before
    assert hashes(tmp_path / "study") == done[1]


def test_only_missing_or_truncated_files_are_rendered_again(done, tmp_path, monkeypatch):
    shutil.copytree(done[0], tmp_path / "study")
    names = sorted((tmp_path / "study" / "sounds").rglob("*.wav"))
    names[3].unlink()
    names[7].write_bytes(names[7].read_bytes()[:-1])
    outcome = run_batch(grid_in(tmp_path), workers=1)
    assert (outcome.cached, outcome.rendered) == (CASES - 2, 2)
    assert hashes(tmp_path / "study") == done[1]


def test_a_larger_grid_renders_only_the_new_cases(done, tmp_path):
    shutil.copytree(done[0], tmp_path / "study")
    more = JOBS.replace("seeds = 3", "seeds = 4")
    outcome = run_batch(grid_in(tmp_path, more), workers=1)
    assert (outcome.cached, outcome.rendered) == (CASES, CASES // 3)
    table = rows(tmp_path / "study")
    assert len(table) == CASES // 3 * 4
    assert len({row["file"] for row in table}) == len(table)
    # and back: the rows are those of the study that is asked for
    outcome = run_batch(grid_in(tmp_path), workers=1)
    assert outcome.rendered == 0
    assert len(rows(tmp_path / "study")) == CASES


def test_changed_data_are_rendered_again_and_changed_texts_are_not(tmp_path):
    study = grid_in(tmp_path)
    keys = Keys(study)
    plain = [keys.key(study.case(index)) for index in range(CASES)]
    assert len(set(plain)) == CASES

    def key(**changed):
        other = replace(study, **changed)
        return Keys(other).key(other.case(0))

    name, timeline = next(iter(study.timelines.items()))
    renamed = replace(timeline, title="other", notes=("words",))
    assert key(timelines={"x": renamed}) == plain[0]
    later = replace(timeline, duration_s=timeline.duration_s + 1.0)
    assert key(timelines={name: later}) != plain[0]
    preset = study.presets["football"]
    assert key(presets={"x": replace(preset, title="other")}) == plain[0]
    assert key(presets={"x": preset.with_value("disk.k1", 2e-3)}) != plain[0]
    assert key(settings=replace(study.settings, tail=0.1)) != plain[0]
    assert key(settings=replace(study.settings, sample_rate=16000.0)) != plain[0]
    assert key(gestures={"x": ov.tap(0.4, 0.051)}) != plain[0]


def test_failed_cases_are_listed_and_the_others_are_rendered(tmp_path):
    text = """
out = "study"
timelines = ["world-cup-final-2018"]
gestures = ["tap:0.4:0.02"]
sample_rate = 1000
tail = "none"
[parameters]
"tactor.frequency_hz" = [100.0, 440.0, 480.0, 200.0]
"""
    outcome = run_batch(grid_in(tmp_path, text), workers=1)
    assert (outcome.rendered, [index for index, _ in outcome.failed]) == (3, [2])
    table = rows(tmp_path / "study")
    for row in table:
        failed = row["index"] in dict(outcome.failed)
        assert (row["error"] is not None) == failed
        assert (row["file"] is None) == failed
        # too low for BS.1770
        assert row["loudness_lufs"] is None
    # what failed is tried again, and nothing else
    again = run_batch(grid_in(tmp_path, text), workers=1)
    assert again.failed == outcome.failed
    assert again.rendered == 0


def test_equal_presets_under_two_names_are_rendered_once(tmp_path):
    (tmp_path / "twin.toml").write_text('schema = 2\nextends = "football"\ntitle = "Twin"\n')
    text = JOBS.replace('"football", "heart"', '"football", "twin.toml"')
    outcome = run_batch(grid_in(tmp_path, text), workers=1)
    assert outcome.cases == CASES
    table = rows(tmp_path / "study")
    assert len(table) == CASES
    assert len({row["file"] for row in table}) == CASES // 2


def test_a_folder_in_memory_works_like_any_other(done, tmp_path):
    import fsspec

    study = grid_in(tmp_path, out="memory://bucket/study")
    with pytest.raises(ov.InputError, match="workers = 1"):
        run_batch(study)
    try:
        assert run_batch(study, workers=1).rendered == CASES
        assert run_batch(study, workers=1).rendered == 0
        memory = fsspec.filesystem("memory")
        memory.get("/bucket/study", str(tmp_path / "copy"), recursive=True)
    finally:
        fsspec.filesystem("memory").store.clear()
    assert hashes(tmp_path / "copy") == done[1]


def test_inputs_can_be_urls(done, tmp_path):
    import fsspec

    memory = fsspec.filesystem("memory")
    timeline = ov.Timeline("t", 10.0, (ov.Event(5.0, "goal"),))
    ov.save_timeline(timeline, tmp_path / "a.json")
    ov.save_gesture(ov.tap(0.6, 0.05), tmp_path / "take.csv")
    jobs_file(
        tmp_path,
        'out = "made"\ntimelines = ["*.json"]\npresets = ["p.toml"]\ngestures = ["take.csv"]\n'
        'sample_rate = 8000\ntail = "none"\n',
    )
    (tmp_path / "p.toml").write_text('schema = 2\nextends = "football"\ntitle = "P"\n')
    try:
        for name in ("a.json", "take.csv", "p.toml", "jobs.toml"):
            memory.put_file(str(tmp_path / name), f"/in/{name}")
        study = ov.batch.load_jobs("memory://in/jobs.toml")
        assert study.out == "memory://in/made"
        assert next(iter(study.timelines.values())).events == timeline.events
        assert run_batch(study, workers=1).rendered == 1
        (name,) = (n for n in memory.find("/in/made/sounds"))
        result = ov.render(
            timeline, ov.load_preset(tmp_path / "p.toml"), ov.tap(0.6, 0.05), 8000, tail="none"
        )
        result.save(tmp_path / "alone.wav")
        assert memory.cat_file(name) == (tmp_path / "alone.wav").read_bytes()
    finally:
        memory.store.clear()


def test_a_full_disk_stops_the_study_with_one_line(tmp_path, monkeypatch):
    import errno

    real = Storage.put

    def full(self, name, data):
        if name.endswith(".wav") and len(list((tmp_path / "study").rglob("*.wav"))) >= 5:
            raise ov.OutputError(str(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))))
        real(self, name, data)

    monkeypatch.setattr(Storage, "put", full)
    with pytest.raises(ov.OutputError):
        run_batch(grid_in(tmp_path), workers=1)
    monkeypatch.setattr(Storage, "put", real)
    outcome = run_batch(grid_in(tmp_path), workers=1)
    assert outcome.failed == ()
    assert len(rows(tmp_path / "study")) == CASES


def test_a_damaged_manifest_part_is_named(tmp_path):
    (tmp_path / "study" / "parts").mkdir(parents=True)
    (tmp_path / "study" / "parts" / "x.jsonl").write_bytes(b"garbage")
    with pytest.raises(ov.InputError, match=r"parts/x\.jsonl"):
        run_batch(grid_in(tmp_path), workers=1)


def test_a_folder_that_cannot_be_written_is_an_error_of_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ov.InputError, match="file"):
        run_batch(grid_in(tmp_path, out=str(tmp_path / "file" / "study")), workers=1)


def test_parts_of_the_manifest_are_written_during_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(task, "PART_S", 0.0)
    written = []
    real = Storage.put

    def noted(self, name, data):
        written.append(name)
        real(self, name, data)

    monkeypatch.setattr(Storage, "put", noted)
    run_batch(grid_in(tmp_path), workers=1)
    sounds = [n for n, name in enumerate(written) if name.endswith(".wav")]
    parts = [n for n, name in enumerate(written) if name.startswith("parts/")]
    assert len(sounds) == len(parts) == CASES
    # a part never comes before the sounds it lists
    assert all(sound < part for sound, part in zip(sounds, parts, strict=True))


class Killed(BaseException):
    """The end of a process: nothing is tidied up after it."""


def killed_after(monkeypatch, steps):
    """Let this many steps be done to files, half of a write as the last; none after it."""
    left = [steps]

    def last_one():
        left[0] -= 1
        if left[0] < 0:
            raise Killed
        return left[0] == 0

    def counted(real):
        def step(*args, **options):
            if last_one():
                raise Killed
            return real(*args, **options)

        return step

    class HalfWritten(io.FileIO):
        def write(self, data):
            if last_one():
                super().write(data[: len(data) // 2])
                raise Killed
            return super().write(data)

    for name in ("replace", "unlink", "mkdir", "rmdir"):
        monkeypatch.setattr(os, name, counted(getattr(os, name)))
    monkeypatch.setattr(storage, "open", HalfWritten, raising=False)
    return left


def test_a_run_killed_at_any_step_and_resumed_leaves_the_same_files(tmp_path, monkeypatch):
    text = 'out = "study"\ntimelines = ["world-cup-final-2018"]\ngestures = ["tap:0.4:0.02"]\n'
    text += 'sample_rate = 2000\ntail = "none"\nseeds = 3\n'
    monkeypatch.setattr(task, "PART_S", 0.0)
    with monkeypatch.context() as patched:
        left = killed_after(patched, 10**6)
        run_batch(grid_in(tmp_path, text), workers=1)
        steps = 10**6 - left[0]
    expected = hashes(tmp_path / "study")
    assert steps > 4 * len(expected)
    unfinished = []
    for step in range(1, steps + 1):
        out = tmp_path / str(step)
        with monkeypatch.context() as patched, contextlib.suppress(Killed):
            killed_after(patched, step)
            run_batch(grid_in(tmp_path, text, str(out)), workers=1)
            raise AssertionError("it wasn't killed")
        unfinished += (out / UNFINISHED).glob("*")
        # what is there under its name is whole
        for name, digest in hashes(out).items():
            assert name.startswith((UNFINISHED, PARTS)) or digest == expected[name]
        sounds = len(list(out.rglob("*.wav")))
        outcome = run_batch(grid_in(tmp_path, text, str(out)), workers=1)
        # a sound is done again only if its part wasn't there yet
        assert outcome.cached >= sounds - 1
        assert hashes(out) == expected
    assert len(unfinished) > len(expected)


@pytest.mark.skipif(os.name != "posix", reason="sends SIGKILL")
@pytest.mark.parametrize(
    ("seeds", "workers_of_runs"), [(12, "212"), pytest.param(40, "21121", marks=pytest.mark.soak)]
)
def test_a_run_killed_at_random_and_resumed_leaves_the_same_files(tmp_path, seeds, workers_of_runs):
    # a low rate: no loudness, whose library takes longest to load
    text = JOBS.replace("seeds = 3", f"seeds = {seeds}")
    text = text.replace("0.05", "2.0").replace("8000", "2000")
    cases = CASES // 3 * seeds
    (tmp_path / "pieces").mkdir()
    jobs_file(tmp_path / "pieces", text)
    folder = tmp_path / "pieces" / "study"
    chance = random.Random(5)
    kept = 0
    for workers in workers_of_runs:
        process = subprocess.Popen(
            [sys.executable, "-m", "overview_dsp", "batch", "jobs.toml", "--workers", workers],
            cwd=tmp_path / "pieces",
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            more = kept + chance.randrange(1, cases // 6)
            while process.poll() is None and len(list(folder.rglob("*.wav"))) < more:
                time.sleep(0.002)
            time.sleep(chance.uniform(0.0, 0.01))
        finally:
            process.send_signal(signal.SIGKILL)
        # it hit while there was work to do, and the workers end with it
        assert process.wait() == -signal.SIGKILL
        assert end_of_group(process.pid)
        assert len(list(folder.rglob("*.wav"))) >= more
        kept = len(list(folder.rglob("*.wav")))
    assert kept < cases
    outcome = run_batch(grid_in(tmp_path / "pieces", text), workers=1)
    assert outcome.cases == cases == outcome.cached + outcome.rendered
    assert outcome.cached > 0
    assert outcome.rendered > 0
    assert run_batch(grid_in(tmp_path, text), workers=1).cached == 0
    assert hashes(folder) == hashes(tmp_path / "study")
    assert not (folder / UNFINISHED).exists()


def test_a_worker_that_dies_is_replaced(done, tmp_path, monkeypatch):
    from overview_dsp.batch import workers

    study = grid_in(tmp_path)
    real = workers._run_once
    rounds = []

    def killed(study, left, processes):
        rounds.append(len(left))
        results = real(study, left, processes)
        yield next(results)
        if len(rounds) == 1:
            results.close()
            raise workers.BrokenProcessPool
        yield from results

    monkeypatch.setattr(workers, "_run_once", killed)
    outcome = run_batch(study, workers=2)
    assert outcome.failed == ()
    assert rounds[1] == rounds[0] - 1
    assert hashes(tmp_path / "study") == done[1]


def test_workers_that_die_repeatedly_end_the_run_with_one_line(tmp_path, monkeypatch):
    from overview_dsp.batch import workers

    def dead(study, left, processes):
        raise workers.BrokenProcessPool
        yield

    monkeypatch.setattr(workers, "_run_once", dead)
    with pytest.raises(ov.OverviewError, match="died 3 times"):
        run_batch(grid_in(tmp_path), workers=2)


def test_the_command_reports_its_renders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = JOBS.replace("seeds = 3", "seeds = 1")
    jobs_file(tmp_path, text)
    outcome = overview("batch", "jobs.toml", "--dry-run")
    assert outcome.out == f"study: {CASES // 3} renders\n"
    assert not (tmp_path / "study").exists()
    outcome = overview("batch", "jobs.toml", "--workers", 1)
    assert outcome.code == 0
    assert f"{CASES // 3} rendered" in outcome.out
    report = json.loads(overview("batch", "jobs.toml", "--workers", 1, "--json").out)
    assert (report["cached"], report["rendered"], report["failed"]) == (CASES // 3, 0, [])
    assert os.path.samefile(report["manifest"], tmp_path / "study" / "manifest.parquet")
    refused(overview("batch", "none.toml"), "none.toml")
    refused(overview("batch", "jobs.toml", "--workers", 2, "--scheduler", "x"), "--scheduler")


def test_the_command_ends_with_1_when_renders_failed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = 'out = "o"\ntimelines = ["world-cup-final-2018"]\ngestures = ["tap:1:0.01"]\n'
    text += 'sample_rate = 1000\ntail = "none"\n[parameters]\n"tactor.frequency_hz" = [250, 460]\n'
    jobs_file(tmp_path, text)
    outcome = overview("batch", "jobs.toml", "--workers", 1)
    assert outcome.code == 1
    assert "1 rendered" in outcome.out
    lines = outcome.errors
    assert lines[0].startswith("failed: render 1: ")
    assert lines[1].startswith("error: 1 of 2 renders failed")


def test_without_the_extra_the_error_has_the_install_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    jobs_file(tmp_path)
    refused(overview("batch", "jobs.toml", "--workers", 1), "pyarrow", install_command("batch"))
