"""`overview play` without a terminal and without a sound card."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

import overview_dsp as ov
from overview_dsp.live.session.loop import Loop
from tests.cli.running import MATCH, overview, refused

PLAY = [sys.executable, "-m", "overview_dsp", "play", MATCH, "--device", "none"]


def played(*arguments, text=None):
    return subprocess.run(
        [*PLAY, *map(str, arguments)], input=text, capture_output=True, text=True, timeout=120
    )


def played_here(springy_file, *arguments):
    """As `played`, in this process, with a disk that is back soon."""
    done = overview("play", MATCH, "--device", "none", "--preset", springy_file, *arguments)
    assert done.code == 0, done.err
    return done


def test_play_prints_a_line_per_second_and_a_summary(tmp_path, match, springy_file):
    take = tmp_path / "take.csv"
    done = played_here(springy_file, "--input", "sweep:1+tap:0.8:0.5", "--record", take)
    *lines, last = [json.loads(line) for line in done.out.splitlines()]
    assert len(lines) >= 2
    assert {"name": "running", "reason": "by touch", "last_stop": ""} in [
        one["state"] for one in lines
    ]
    assert {"time_s", "cursor", "touching", "late_callbacks", "frames_lost"} <= lines[0].keys()
    assert {"blocks", "callback_p50_us", "callback_p99_us", "callback_max_us"} <= (
        last["summary"].keys()
    )
    result = ov.render(match, ov.load_preset(springy_file), ov.load_gesture(take))
    assert len(result.strikes) > 20


def test_a_session_uses_an_actuator_and_reports_it(springy_file):
    done = played_here(springy_file, "--input", "tap:0.5:0.2", "--actuator", "lra")
    assert "note: lra is felt" in done.err
    summary = json.loads(done.out.splitlines()[-1])["summary"]
    assert summary["actuator"]["name"] == "lra"
    assert {"calibration_db", "reduction_db", "samples_at_peak"} <= summary["actuator"].keys()


def test_standard_input_moves_the_disk():
    lines = "".join(f"{angle / 10} 1\n" for angle in range(25))
    done = played("--input", "-", text=lines + "x\n")
    assert done.returncode == 0, done.stderr
    assert "1 lines were not `theta2 touching`; first: line 26: 'x'" in done.stderr


def test_lines_for_a_person_are_printed_also_where_standard_input_moves_the_disk():
    process = subprocess.Popen(
        [*PLAY, "--screen", "lines", "--input", "-", "--seconds", "20"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stderr is not None
    process.stdin.write("0.5 1\n")
    process.stdin.flush()
    said = iter(process.stderr.readline, "")
    assert "15:51, 0 to 0.\n" in said
    out, rest = process.communicate(timeout=60)
    assert (out, rest, process.returncode) == ("", "Released at 15:51, 0 to 0.\n", 0)


@pytest.mark.skipif(os.name != "posix", reason="signals as on POSIX")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_ends_the_session_and_the_take_is_saved(tmp_path, name):
    take = tmp_path / "take.csv"
    process = subprocess.Popen(
        [*PLAY, "--record", take], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(0.2)
    process.send_signal(getattr(signal, name))
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 128 + getattr(signal, name)
    assert f"stopped by {name}" in errors
    assert "Traceback" not in errors
    assert len(ov.load_gesture(take).time_s) >= 1


@pytest.mark.skipif(os.name != "posix", reason="signals as on POSIX")
def test_a_signal_that_is_ignored_from_the_start_stays_ignored():
    """As `nohup` starts it: the closed terminal's SIGHUP doesn't end it, SIGTERM does."""
    process = subprocess.Popen(
        PLAY,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGHUP)
    assert "time_s" in json.loads(process.stdout.readline())
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM
    assert "stopped by SIGTERM" in errors


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--block-size", "-1"], "block size -1 must be 0 to 8192 frames"),
        (["--seconds", "nan"], "--seconds is nan; must be 0 or more"),
        (["--seconds", "-1"], "--seconds is -1; must be 0 or more"),
        (["--sample-rate", "0"], "--sample-rate is 0 Hz; must be 1000 to 768000 Hz"),
        (["--set", "click.gain=99"], "gain 99 is out of range"),
        (["--set", "click.channel=2"], "both use channel 2"),
        (["--set", "tactor.channel=3+x"], "channel '3+x' must be a number, several numbers (3+4)"),
        (["--input", "wobble:3"], "gesture 'wobble:3' is not valid"),
        (["--input", "osc:9000,smooth=soon"], "smooth=soon; must be 0 to 100 (ms)"),
        (["--input", "midi:pad,smooth=-1"], "smooth=-1; must be 0 to 100 (ms)"),
        (["--input", "pad:,smooth=6"], "smooth applies to osc:, midi:"),
        (["--screen", "full"], "--screen full needs a terminal, whose keys --input - excludes"),
        (["--preset", "nothing"], "no preset is called 'nothing'"),
        (["--record", "/no/such/folder/take.csv", "--seconds", "0.1"], "/no/such/folder"),
    ],
)
def test_a_mistake_gives_a_one_line_error_and_exit_code_2(arguments, words):
    assert words in refused(overview("play", MATCH, "--device", "none", *arguments))


def test_a_zoom_is_recorded_and_the_whole_timeline_stays_available(tmp_path, match, springy_file):
    take = tmp_path / "take.csv"
    played_here(springy_file, "--input", "sweep:0.5", "--zoom-to", "goal:2:100", "--record", take)
    goal = match.event("goal", 2).time_s
    (change,) = json.loads(take.with_suffix(".json").read_text())["changes"]
    assert change["window"] == [goal - 75.0, goal + 25.0]
    assert ov.load_gesture(take).changes[0].what["window"] == change["window"]


def test_a_window_may_be_given_by_events_and_clocks(springy_file):
    played_here(springy_file, "--input", "tap:0.5:0.1", "--window", "goal:2-1:00", "goal:2+5")
    wrong = overview("play", MATCH, "--device", "none", "--window", "goal:2", "9:99")
    assert refused(wrong).startswith("error: --window: '9:99' is not a moment")


@pytest.mark.parametrize(
    ("replay", "repeats"), [("tap:0.5:0.1,loop", True), ("tap:0.5:0.1", False)]
)
def test_a_replay_repeats_on_request(monkeypatch, springy_file, replay, repeats):
    begun = []
    begin = Loop.begin
    monkeypatch.setattr(Loop, "begin", lambda *given: begun.append(given[2:]) or begin(*given))
    played_here(springy_file, "--replay", replay, "--seconds", "0.2")
    assert begun == [("tap:0.5:0.1", repeats)]


def test_a_preset_to_compare_is_checked_before_it_plays():
    wrong = overview("play", MATCH, "--device", "none", "--compare", "footbal")
    refused(wrong, "no preset is called 'footbal'", "did you mean 'football'")
