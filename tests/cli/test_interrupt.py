from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.cli.running import MATCH, end_of_group, environment


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
@pytest.mark.parametrize(
    "outputs",
    [("-o", "a.wav"), ("-o", "a.wav", "--trace", "a.npz"), ("-o", "a.wav", "--trace", "a.csv")],
)
def test_ctrl_c_in_a_render_leaves_no_file_and_ends_with_130(folder, outputs):
    command = subprocess.Popen(
        [
            *(sys.executable, "-m", "overview_dsp", "render", MATCH, "--gesture", "sweep:5000"),
            *("--sample-rate", "48000", *outputs),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    try:
        # until it writes
        while not any(path.stat().st_size > 100_000 for path in folder.iterdir()):
            assert command.poll() is None, command.communicate()
            time.sleep(0.02)
        command.send_signal(signal.SIGINT)
        out, err = command.communicate(timeout=60)
    finally:
        command.kill()
        command.wait()
    assert command.returncode == 130
    # click goes to a new line after the terminal's ^C
    lines = [line for line in err.splitlines() if line and not line.startswith("compiling")]
    assert lines == ["error: stopped; nothing was left behind"]
    assert out == ""
    assert os.listdir(folder) == []


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_ctrl_c_in_a_study_says_how_far_it_came_and_ends_its_workers(folder):
    pytest.importorskip("pyarrow", reason="needs the extra batch")
    (folder / "jobs.toml").write_text(
        f'out = "o"\ntimelines = ["{MATCH}"]\ngestures = ["tap:1:0.5"]\nseeds = 50000\n'
        'tail = "none"\n'
    )
    command = subprocess.Popen(
        [*(sys.executable, "-m", "overview_dsp", "batch", "jobs.toml", "--workers", "2")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
        start_new_session=True,
    )
    try:
        while len(list(folder.rglob("*.wav"))) < 20:
            assert command.poll() is None, command.communicate()
            time.sleep(0.02)
        # as a terminal does: to all of its processes
        os.killpg(command.pid, signal.SIGINT)
        out, err = command.communicate(timeout=60)
    finally:
        command.kill()
        command.wait()
    assert command.returncode == 130
    lines = [line for line in err.splitlines() if line and not line.startswith("compiling")]
    assert len(lines) == 1, err
    assert lines[0].startswith("error: stopped with ")
    assert "of 50000 finished; run it again to go on" in lines[0]
    assert out == ""
    assert end_of_group(command.pid)
