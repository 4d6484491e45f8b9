from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from overview_dsp.files import atomic
from tests.cli.running import MATCH, end_of_group, environment


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
@pytest.mark.parametrize(
    ("name", "outputs"),
    [
        ("SIGINT", ("-o", "a.wav")),
        ("SIGTERM", ("-o", "a.wav", "--trace", "a.npz")),
        ("SIGHUP", ("-o", "a.wav", "--trace", "a.csv")),
    ],
)
def test_a_render_that_is_stopped_leaves_no_file_and_ends_as_signals_do(folder, name, outputs):
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
        command.send_signal(getattr(signal, name))
        out, err = command.communicate(timeout=60)
    finally:
        command.kill()
        command.wait()
    assert command.returncode == 128 + getattr(signal, name)
    # click goes to a new line after the terminal's ^C
    lines = [line for line in err.splitlines() if line and not line.startswith("compiling")]
    assert lines == [
        "note: preset football fits the data best, with 6 of 6 event kinds",
        "error: stopped; no partial output is left",
    ]
    assert out == ""
    assert os.listdir(folder) == []


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_while_code_in_a_string_runs_gives_its_exit_code(folder, name):
    # as a dataclass does; CPython takes such an interrupt for one that nobody caught
    folder.joinpath("stopped.py").write_text(
        "import os, signal\n"
        "from overview_dsp import cli\n"
        f"code = 'os.kill(os.getpid(), signal.{name})'\n"
        "cli.app.main = lambda **_: exec(code)\n"
        "cli.main()\n"
    )
    ended = subprocess.run([sys.executable, "-m", "stopped"], cwd=folder, capture_output=True)
    assert ended.returncode == 128 + getattr(signal, name), ended.stderr.decode()


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
@pytest.mark.parametrize("name", ["SIGHUP", "SIGINT"])
def test_a_signal_while_a_class_is_made_gives_its_exit_code(folder, name):
    # Python 3.11 makes a RuntimeError of an interrupt in __set_name__
    folder.joinpath("stopped.py").write_text(
        "import os, signal\n"
        "from overview_dsp import cli\n"
        "class Part:\n"
        "    def __set_name__(self, owner, name):\n"
        f"        os.kill(os.getpid(), signal.{name})\n"
        "cli.app.main = lambda **_: type('Whole', (), {'part': Part()})\n"
        "cli.main()\n"
    )
    ended = subprocess.run([sys.executable, "-m", "stopped"], cwd=folder, capture_output=True)
    assert ended.returncode == 128 + getattr(signal, name), ended.stderr.decode()
    assert ended.stderr.decode().splitlines() == ["error: stopped; no partial output is left"]


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
def test_an_export_that_is_stopped_leaves_nothing(folder):
    command = subprocess.Popen(
        [
            *(sys.executable, "-m", "overview_dsp", "export", MATCH, "--to", "web"),
            *("--zoom-levels", "3", "-o", "page"),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    try:
        while not os.listdir(folder):
            assert command.poll() is None, command.communicate()
            time.sleep(0.001)
        command.send_signal(signal.SIGTERM)
        _, err = command.communicate(timeout=60)
    finally:
        command.kill()
        command.wait()
    assert command.returncode == 128 + signal.SIGTERM
    assert "no partial output is left" in err
    assert os.listdir(folder) == []


def test_a_temporary_file_is_removed_even_if_stopped_while_it_is_created(folder, monkeypatch):
    def made(path, *flags):
        (folder / path).write_text("x")
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(os, "open", made)
        patched.setattr(os, "unlink", made)  # stopped again while it cleans up
        with pytest.raises(KeyboardInterrupt):
            atomic.atomic_file("a.wav").__enter__()
    assert len(os.listdir(folder)) == 1
    atomic.remove_temporaries()
    assert os.listdir(folder) == []


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_stopped_batch_reports_its_progress_and_ends_its_workers(folder, name):
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
        os.killpg(command.pid, getattr(signal, name))
        out, err = command.communicate(timeout=60)
    finally:
        command.kill()
        command.wait()
    assert command.returncode == 128 + getattr(signal, name)
    assert not (folder / "o" / ".unfinished").exists()
    lines = [line for line in err.splitlines() if line and not line.startswith("compiling")]
    assert len(lines) == 1, err
    assert lines[0].startswith("error: stopped with ")
    assert "of 50000 finished; run the command again to resume" in lines[0]
    assert out == ""
    assert end_of_group(command.pid)
