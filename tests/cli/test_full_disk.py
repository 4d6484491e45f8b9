"""A disk that fills up on the way: one line, exit code 1, and nothing left behind."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.cli.running import MATCH, Outcome, environment, overview, refused

LONG = ("--gesture", "sweep:9", "--sample-rate", "8000", "--tail", "none")
OUTPUTS = {
    "wav": ("-o", "a.wav"),
    "flac": ("-o", "a.flac"),
    "float": ("-o", "a.wav", "--subtype", "FLOAT"),
    "npz": ("-o", "a.wav", "--trace", "a.npz"),
    "csv": ("-o", "a.wav", "--trace", "a.csv"),
}


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 64 kB."""
    if os.name != "posix" or os.geteuid() != 0:
        pytest.skip("needs root, to mount a small tmpfs")
    place = tmp_path / "disk"
    place.mkdir()
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(place)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        pytest.skip(f"can't mount a small tmpfs here: {done.stderr.strip()}")
    yield place
    os.chdir(tmp_path)
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.parametrize("outputs", OUTPUTS.values(), ids=OUTPUTS)
def test_a_full_disk_gives_a_one_line_error_and_leaves_nothing(small_disk, monkeypatch, outputs):
    monkeypatch.chdir(small_disk)
    refused(overview("render", MATCH, *LONG, *outputs), "a.", "nothing was left behind", code=1)
    assert os.listdir(small_disk) == []


@pytest.mark.parametrize("outputs", OUTPUTS.values(), ids=OUTPUTS)
def test_a_full_disk_leaves_the_existing_file_unchanged(small_disk, monkeypatch, outputs):
    monkeypatch.chdir(small_disk)
    for name in ("a.wav", "a.flac", "a.npz", "a.csv"):
        (small_disk / name).write_text(name)
    refused(overview("render", MATCH, *LONG, *outputs), "a.", code=1)
    for name in ("a.wav", "a.flac", "a.npz", "a.csv"):
        assert (small_disk / name).read_text() == name
    assert len(os.listdir(small_disk)) == 4


def test_a_sound_that_does_not_fit_removes_its_trace_too(small_disk, monkeypatch):
    monkeypatch.chdir(small_disk)
    short = ("--gesture", "tap:0.5:0.05", "--sample-rate", "1000", "--tail", "none")
    # the trace fits, the sound's last bytes don't: whatever is left over, it is none of the two
    for size in range(60, 36, -4):
        (small_disk / "filler").write_bytes(b"x" * size * 1000)
        outcome = overview("render", MATCH, *short, "-o", "a.wav", "--trace", "a.csv")
        left = sorted(os.listdir(small_disk))
        if outcome.code == 0:
            assert left == ["a.csv", "a.wav", "filler"]
            return
        refused(outcome, "a.", code=1)
        assert left == ["filler"]
    pytest.fail("the two files should fit at last")


@pytest.mark.parametrize("command", ["demo", "figures"])
def test_pictures_and_the_demo_on_a_full_disk_give_a_one_line_error(small_disk, command):
    (small_disk / "filler").write_bytes(b"x" * 62_000)
    refused(overview(command, "--output", small_disk), str(small_disk), code=1)
    for name in os.listdir(small_disk):
        assert name == "filler" or os.path.getsize(small_disk / name) > 1000
        assert not name.startswith(".")


def limited(folder, *arguments: str) -> Outcome:
    """The command in a process whose files may have 64 kB: a full disk for people who aren't root.

    Python ignores the signal that comes with it, so that a write fails.
    """
    pytest.importorskip("resource")
    code = (
        "import resource, sys\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))\n"
        "from overview_dsp.cli import main\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env=environment(),
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


@pytest.mark.parametrize("outputs", [OUTPUTS["flac"], OUTPUTS["npz"], OUTPUTS["csv"]])
def test_a_file_that_grows_beyond_what_is_allowed_gives_a_one_line_error(folder, outputs):
    # compiled beforehand, where files may be as long as they like
    overview("render", MATCH, "--gesture", "tap:0.1:0.01", "--tail", "none")
    os.unlink(folder / "out.wav")
    refused(limited(folder, "render", MATCH, *LONG, *outputs), "a.", code=1)
    assert os.listdir(folder) == []
