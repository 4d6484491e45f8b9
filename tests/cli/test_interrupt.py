from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from .running import MATCH, environment


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
