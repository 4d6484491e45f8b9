"""`overview sensor firmware`."""

from __future__ import annotations

import filecmp

import pytest

from overview_dsp.devices.sensors.firmware import firmware_head, firmware_names
from overview_dsp.devices.sensors.profile import LIBRARY, load_sensor
from tests.cli.running import overview, refused
from tests.firmware.boards import FIRMWARE


def test_it_lists_what_there_is():
    said = overview("sensor", "firmware").out.splitlines()
    assert [line.split()[0] for line in said] == ["encoder", "imu", "knob", "micropython", "pot"]
    assert firmware_names() == ("encoder", "imu", "knob", "micropython", "pot")


@pytest.mark.parametrize("name", firmware_names())
def test_each_says_its_wiring_what_to_type_and_what_it_prints(name):
    head = firmware_head(name)
    for word in ("Wiring ", "Flash ", "Play ", "Prints on reset", f"# overview {name} 1: "):
        assert word in head
    assert "overview play MATCH --input serial:PORT" in head


def test_it_copies_a_folder_once(tmp_path):
    done = overview("sensor", "firmware", "imu", "-o", tmp_path)
    assert done.code == 0
    assert "Wiring" in done.out
    compared = filecmp.dircmp(FIRMWARE / "imu", tmp_path / "imu")
    assert not compared.left_only
    assert not compared.diff_files
    again = overview("sensor", "firmware", "imu", "-o", tmp_path)
    assert (again.code, len(again.errors)) == (2, 1)
    assert "already exists" in again.err


@pytest.mark.parametrize("arguments", [("imo",), ("-o", "x"), ("knob", "-o", "/dev/null/x")])
def test_a_mistake_is_one_line(arguments):
    done = overview("sensor", "firmware", *arguments)
    assert (done.code, len(done.errors)) == (2, 1)


def test_a_sensors_file_is_listed_printed_and_copied(tmp_path):
    listed = overview("sensor", "profile").out.splitlines()
    assert [line.split()[0] for line in listed] == list(LIBRARY.bundled)
    assert all(len(line.split()) > 3 for line in listed)
    path = tmp_path / "my-knob.toml"
    done = overview("sensor", "profile", "simplefoc", "-o", path)
    assert done.code == 0
    assert load_sensor(path).values == load_sensor("simplefoc").values
    assert overview("sensor", "profile", "simplefoc").out == path.read_text(encoding="utf-8")
    before = path.read_bytes()
    refused(overview("sensor", "profile", "imu", "-o", path), "already exists")
    assert path.read_bytes() == before
    refused(overview("sensor", "profile", "simplefok"), "did you mean 'simplefoc'?")
    refused(overview("sensor", "profile", "-o", path), "must be dualsense or encoder")
