"""Whole sessions whose folder fills up, vanishes or becomes read-only while they play."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

import overview_dsp as ov
from tests.cli.running import MATCH, environment

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        sys.platform != "linux" or os.geteuid() != 0, reason="needs root, to mount small disks"
    ),
]

EVENTS = 400


def attempt(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"can't {command[0]} here: {done.stderr.strip()}")
    return done.stdout


@pytest.fixture
def disk(request, tmp_path):
    """A small disk, and what is done to it while a session plays."""
    place = tmp_path / "disk"
    place.mkdir()
    if request.param == "read-only":
        image = tmp_path / "image"
        image.write_bytes(bytes(8 << 20))
        attempt("mkfs.ext4", "-q", "-F", str(image))
        attempt("mount", "-o", "loop,errors=remount-ro", str(image), str(place))
        source = attempt("findmnt", "-n", "-o", "SOURCE", str(place)).strip()
        fault = Path("/sys/fs/ext4", Path(source).name, "trigger_fs_error")
        act = lambda: fault.write_text("1")  # noqa: E731 - as a disk that fails
    else:
        size = "12k" if request.param == "full" else "1m"
        attempt("mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place))
        act = lambda: shutil.rmtree(place / "takes") if request.param == "deleted" else None  # noqa: E731
    (place / "takes").mkdir()
    yield place / "takes", act
    subprocess.run(["umount", "-l", str(place)], check=True)


@pytest.mark.parametrize(
    ("disk", "why"),
    [
        ("full", "No space left"),
        ("deleted", "has been deleted"),
        ("read-only", "Read-only file system"),
    ],
    indirect=["disk"],
)
def test_the_whole_take_goes_on_elsewhere_and_the_session_says_where(disk, why, tmp_path):
    folder, act = disk
    play = [sys.executable, "-m", "overview_dsp", "play", MATCH, "--device", "none", "--input", "-"]
    process = subprocess.Popen(
        [*play, "--record", str(folder / "take.csv")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**environment(), "XDG_STATE_HOME": str(tmp_path / "state")},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.readline()  # it plays
    for number in range(EVENTS):
        if number == EVENTS // 2:
            act()
        process.stdin.write(f"{0.005 * number:.4f} 1\n")
        process.stdin.flush()
        time.sleep(0.01)
    process.stdin.close()
    with process.stdout, process.stderr:
        said = process.stderr.read().splitlines()
        assert process.wait(60) == 0
    (take,) = (tmp_path / "state").rglob("*.csv")
    assert [line for line in said if why in line and f"continues in {take}" in line], said
    assert f"take saved as {take}; its render is bit-identical" in said
    gesture = ov.load_gesture(take)
    assert gesture.touching.sum() == EVENTS
