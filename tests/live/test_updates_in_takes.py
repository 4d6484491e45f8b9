"""A take on disk while it is played: whole at any moment, wherever there is room."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.live.takes import recovery, takes
from overview_dsp.live.takes.takes import Recorder
from tests.cli.running import MATCH, environment, overview

RATE = 8000


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """A state folder of the test's own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "overview-dsp" / "takes"


@pytest.fixture
def engine(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(RATE, 8000)
    return engine


def play(engine, *moves):
    """Each move (theta2, touching, source) and a tenth of a second; what sounded."""
    parts = []
    for theta2, touching, source in moves:
        engine.control(theta2, touching, source=source)
        parts.append(np.empty((RATE // 10, 2), dtype=np.float32))
        engine.process(parts[-1])
    return np.concatenate(parts)


SLOW = [(0.02 * i, True, "touch") for i in range(50)]


def test_a_take_that_nobody_ended_renders_to_what_was_heard(engine, match, football, tmp_path):
    path = tmp_path / "take.csv"
    take = Recorder(engine, path, {})
    heard = [play(engine, *SLOW[:20])]
    engine.set("tactor.gain_db", -6.0)
    heard.append(play(engine, *SLOW[20:40]))
    take.poll()
    gesture = ov.load_gesture(path)
    assert gesture.duration_s == 4.0
    assert [change.what for change in gesture.changes] == [{"set": {"tactor.gain_db": -6.0}}]
    rendered = ov.render(match, football, gesture, RATE, tail="none").samples
    assert np.array_equal(rendered[: 4 * RATE], np.concatenate(heard))
    take.close()
    # ended, it says the same in one document
    assert json.loads(path.with_suffix(".json").read_text())["changes"]
    assert ov.load_gesture(path).duration_s == 4.0


def test_a_take_without_events_is_valid(engine, tmp_path):
    path = tmp_path / "take.csv"
    take = Recorder(engine, path, {})
    engine.process(np.empty((RATE, 2), dtype=np.float32))
    take.poll()
    assert ov.load_gesture(path).duration_s == 1.0
    take.close()
    assert ov.load_gesture(path).duration_s == 1.0


def test_a_part_of_a_line_at_the_end_is_left_out_but_not_one_within(engine, tmp_path):
    path = tmp_path / "take.csv"
    take = Recorder(engine, path, {})
    play(engine, *SLOW)
    take.poll()
    whole, beside = path.read_text(), path.with_suffix(".json").read_text()
    for cut in range(1, len(whole.splitlines()[-1])):
        path.write_text(whole[:-cut])
        path.with_suffix(".json").write_text(beside[: len(beside) - cut % 12])
        assert len(ov.load_gesture(path).time_s) >= 49
    path.write_text(whole.replace("0.02,1", "0.02,", 1))
    with pytest.raises(ov.InputError, match="touching"):
        ov.load_gesture(path)


def test_a_take_begun_later_begins_with_the_hands_in_their_order(engine, match, tmp_path):
    play(engine, (1.0, True, "twist"), (2.0, True, "touch"), (0.5, True, "osc"))
    take = Recorder(engine, tmp_path / "take.csv", {}, [{"window": [0.0, 600.0]}])
    play(engine, (0.5, False, "osc"), (2.0, False, "touch"))
    take.close()
    gesture = ov.load_gesture(tmp_path / "take.csv")
    assert gesture.changes[0].time_s == 0.0
    assert gesture.changes[0].what == {"window": [0.0, 600.0]}
    first = list(zip(gesture.time_s, gesture.theta2, gesture.source, strict=True))[:4]
    assert [source for *_, source in first] == [1, 0, 3, 3]
    assert [theta2 for _, theta2, _ in first] == [1.0, 2.0, 0.5, 0.5]
    assert [time_s for time_s, *_ in first] == [0.0, 0.0, 0.0, 0.0]


def test_a_take_that_is_there_keeps_its_bytes_under_another_name(engine, tmp_path):
    path = tmp_path / "take.csv"
    for number in range(3):
        engine.reset()
        take = Recorder(engine, path, {})
        play(engine, (0.1 * number, True, "touch"))
        take.close()
    for name, theta2 in (("take.1.csv", 0.0), ("take.2.csv", 0.1), ("take.csv", 0.2)):
        assert ov.load_gesture(tmp_path / name).theta2[0] == theta2


@pytest.fixture
def disk(tmp_path):
    """A disk of 24 kB, and how to make it read-only."""
    if os.name != "posix" or os.geteuid() != 0:
        pytest.skip("needs root, to mount a small tmpfs")
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=24k", "tmpfs", str(place)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"can't mount a small tmpfs here: {done.stderr.strip()}")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


def until_it_moves(engine, take, said):
    """Play until the take has to go elsewhere, which it says; what sounded."""
    heard = []
    for round_ in range(100):
        heard.append(play(engine, *((0.001 * (i + round_), True, "touch") for i in range(20))))
        take.poll()
        if said:
            return heard
    raise AssertionError("it never had to")


def test_a_full_disk_sends_the_whole_take_elsewhere_and_reports_it_once(
    disk, state, engine, match, football
):
    path = disk / "take.csv"
    said = []
    take = Recorder(engine, path, {}, say=said.append)
    heard = until_it_moves(engine, take, said)
    heard.append(play(engine, *SLOW))
    take.close()
    assert len(said) == 1
    assert "No space left" in said[0]
    assert take.path.parent == state
    assert str(take.path) in said[0]
    samples = np.concatenate(heard)
    for whole, length in ((take.path, len(samples)), (path, 1)):
        gesture = ov.load_gesture(whole)
        rendered = ov.render(match, football, gesture, RATE, tail="none").samples
        assert len(rendered) > length
        length = min(len(rendered) - 1, len(samples))
        assert np.array_equal(rendered[:length], samples[:length])


@pytest.mark.parametrize("gone", ["deleted", "read-only"])
def test_a_take_moves_if_its_folder_can_no_longer_be_written(
    disk, state, engine, match, football, monkeypatch, gone
):
    folder = disk / "takes"
    folder.mkdir()
    told = []
    take = Recorder(engine, folder / "take.csv", {}, say=told.append)
    heard = [play(engine, *SLOW[:20])]
    take.poll()
    if gone == "deleted":
        shutil.rmtree(folder)
    else:  # no disk with open files becomes read-only: its writes are refused as there
        write = os.write

        def refuse(file, data):
            if os.readlink(f"/proc/self/fd/{file}").startswith(str(folder)):
                raise OSError(30, "Read-only file system")
            return write(file, data)

        monkeypatch.setattr(os, "write", refuse)
    heard.append(play(engine, *SLOW[20:]))
    take.close()
    (said,) = told
    assert "deleted" in said or "Read-only" in said
    assert take.path.parent == state
    rendered = ov.render(match, football, ov.load_gesture(take.path), RATE, tail="none").samples
    samples = np.concatenate(heard)
    assert np.array_equal(rendered[: len(samples)], samples)


def test_a_read_only_folder_is_refused_before_anything_is_played(disk, engine):
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    with pytest.raises(ov.InputError, match="Read-only"):
        Recorder(engine, disk / "take.csv", {})


def test_a_take_stays_in_memory_until_a_folder_is_writable(
    disk, engine, match, football, monkeypatch
):
    monkeypatch.setattr(takes, "fallback_paths", lambda path: iter(()))
    (disk / "filler").write_bytes(b"x" * 12_000)
    said = []
    take = Recorder(engine, disk / "take.csv", {}, say=said.append)
    heard = until_it_moves(engine, take, said)
    assert "stays in memory" in said[0]
    heard.append(play(engine, *SLOW))
    take.poll()
    assert ov.load_gesture(disk / "take.csv").duration_s > 0.0
    (disk / "filler").unlink()
    take.close()
    assert len(said) == 1
    rendered = ov.render(match, football, ov.load_gesture(take.path), RATE, tail="none").samples
    samples = np.concatenate(heard)
    assert np.array_equal(rendered[: len(samples)], samples)


def test_a_take_that_can_never_be_written_is_an_error_at_the_end(disk, engine, monkeypatch):
    monkeypatch.setattr(takes, "fallback_paths", lambda path: iter(()))
    said = []
    take = Recorder(engine, disk / "take.csv", {}, say=said.append)
    until_it_moves(engine, take, said)
    with pytest.raises(ov.OutputError, match=r"No space left.*complete up to \d"):
        take.close()
    assert ov.load_gesture(disk / "take.csv").duration_s > 1.0


PLAY = [sys.executable, "-m", "overview_dsp", "play", MATCH, "--device", "none"]


def test_after_a_kill_the_take_is_whole_and_the_next_start_says_where(tmp_path):
    take = tmp_path / "take.csv"
    process = subprocess.Popen(
        [*PLAY, "--input", "sweep:20", "--record", str(take)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment(),
    )
    assert process.stdout is not None
    reports = [json.loads(process.stdout.readline()) for _ in range(2)]
    # another session says nothing of one that still plays
    assert recovery.pop_interrupted_takes() == []
    process.kill()
    process.communicate()
    gesture = ov.load_gesture(take)
    assert gesture.duration_s >= reports[-1]["time_s"] - 0.5
    assert gesture.time_s[-2] >= reports[-1]["time_s"] - 0.5

    def again():
        return overview("play", MATCH, "--device", "none", "--seconds", 0.1).err

    (said,) = [line for line in again().splitlines() if "interrupted take" in line]
    assert str(take) in said
    assert "interrupted take" not in again()


@pytest.mark.skipif(os.name != "posix", reason="signals as on POSIX")
def test_a_session_that_is_stopped_says_nothing_the_next_time(tmp_path, state):
    process = subprocess.Popen(
        [*PLAY, "--record", str(tmp_path / "take.csv")],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment(),
    )
    assert process.stdout is not None
    process.stdout.readline()
    assert len(os.listdir(state)) == 1
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    assert os.listdir(state) == []
