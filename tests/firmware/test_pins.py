"""Pins of the firmware on each board, and what the program for MicroPython reads there."""

from __future__ import annotations

import configparser
import re
import sys
import types

import pytest

import overview_dsp as ov
from tests.firmware.boards import FIRMWARE, needs, run

ESP32_TAKEN = {0, 1, 2, 3, 5, 12, 15, *range(6, 12), 20, 24, *range(28, 32)}
"""Pins that start the chip, its serial port, its flash, and those that a module doesn't have."""

S3_TAKEN = {0, 3, 19, 20, *range(22, 38), 43, 44, 45, 46}
"""The same of an ESP32-S3, with USB and the memory of modules with 8 lines."""

INPUT_ONLY = {34, 35, 36, 39}  # of an ESP32: no outputs, no pull-ups


def pins(sketch, tmp_path, *defined):
    """The pins that a sketch uses on a board."""
    needs("gcc", "gcc")
    text = (FIRMWARE / sketch / f"{sketch}.ino").read_text("utf-8")
    source = tmp_path / "sketch.cpp"
    source.write_text(re.sub(r"^#include.*$", "", text, flags=re.M))
    code = run("gcc", "-E", "-P", *(f"-D{one}" for one in defined), source).stdout
    found = re.findall(r"const int (?:A|WIPER) = (\d+)(?:, B = (\d+))?;", code)
    found += re.findall(r"Wire\.begin\((\d+), (\d+)\)", code)
    found += re.findall(r"= BLDCDriver3PWM\((\d+), (\d+), (\d+), (\d+)\)", code)
    return [int(one) for group in found for one in group if one]


@pytest.mark.parametrize("sketch", ["pot", "encoder", "imu", "knob"])
def test_no_sketch_uses_pins_that_an_esp32_needs_itself(tmp_path, sketch):
    plain = pins(sketch, tmp_path, "ESP32", "CONFIG_IDF_TARGET_ESP32")
    assert plain
    assert not set(plain) & ESP32_TAKEN
    assert sketch == "pot" or not set(plain) & INPUT_ONLY
    s3 = pins(sketch, tmp_path, "ESP32", "CONFIG_IDF_TARGET_ESP32S3")
    assert s3
    assert not set(s3) & S3_TAKEN


def test_the_motor_of_a_pico_is_not_at_the_pins_of_its_encoder(tmp_path):
    assert not {4, 5} & set(pins("knob", tmp_path, "ARDUINO_ARCH_RP2040"))


def test_the_guide_lists_the_pins_that_the_sketches_use(tmp_path):
    page = (FIRMWARE.parent / "docs" / "guide" / "boards.md").read_text("utf-8")
    boards = {"Uno and Nano": (), "ESP32": ("ESP32", "CONFIG_IDF_TARGET_ESP32"),
              "ESP32-S3": ("ESP32", "CONFIG_IDF_TARGET_ESP32S3"),
              "RP2040": ("ARDUINO_ARCH_RP2040",)}  # fmt: skip
    for heading, board in boards.items():
        section = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", page, re.M | re.S)[1]
        for sketch in ("encoder", "imu", "knob") if board else ("encoder",):
            for pin in pins(sketch, tmp_path, *board):
                assert re.search(rf"(?<!\d){pin}\b", section), (heading, sketch, pin)


def program(monkeypatch, platform="microbit", machine="", **modules):
    """The program for MicroPython on a board, without its last line, which runs for ever."""
    text = (FIRMWARE / "micropython" / "main.py").read_text("utf-8")
    text, last = text.rsplit("\n\n\n", 1)
    assert last == "run(*found())\n"
    clock = types.SimpleNamespace(sleep_ms=None, ticks_ms=None)
    implementation = types.SimpleNamespace(_machine=machine)
    kind = types.SimpleNamespace(platform=platform, implementation=implementation)
    names = {"kind": kind}
    for name, module in {"utime": clock, "microbit": None, **modules}.items():
        monkeypatch.setitem(sys.modules, name, module)
    exec(text.replace("import sys\n", "sys = kind\n"), names)
    return names


def gravity(right, pins_down, face_down):
    """What a micro:bit gives: parts of gravity to its right, to its pins, and out of its face."""
    return tuple(round(1024 * one) for one in (right, pins_down, face_down))


@pytest.mark.parametrize(
    ("pulled", "printed"),
    [(gravity(0, 0, -1), (0, 0, 1024)), (gravity(0, 0, 1), (0, 0, -1024)),
     (gravity(1, 0, 0), (0, 1024, 0)), (gravity(0, 1, 0), (1024, 0, 0))],
    ids=["face up", "face down", "right side down: left is up", "pins down: the fingers are up"],
)  # fmt: skip
def test_a_microbit_prints_the_direction_of_up(monkeypatch, pulled, printed):
    sensor = types.SimpleNamespace(get_values=lambda: pulled)
    board = types.SimpleNamespace(accelerometer=sensor)
    name, columns, read = program(monkeypatch, microbit=board)["found"]()
    assert (name, columns) == ("micro:bit", "ax,ay,az")
    assert tuple(map(int, read().split(","))) == printed


@pytest.mark.parametrize(
    ("platform", "machine", "wanted"),
    [("rp2", "Raspberry Pi Pico with RP2040", (4, 5, 26)), ("esp32", "ESP32 module", (21, 22, 34)),
     ("esp32", "Generic ESP32S3 module with ESP32S3", (8, 9, 4)), ("pyboard", "PYBv1.1",
      ("X10", "X9", "X19"))],
)  # fmt: skip
def test_micropython_uses_the_pins_of_its_board(monkeypatch, platform, machine, wanted):
    used = []
    board = types.SimpleNamespace(
        Pin=lambda number: used.append(number) or number,
        I2C=lambda *_, **__: types.SimpleNamespace(scan=list),
        ADC=lambda pin: types.SimpleNamespace(read_u16=lambda: 65535),
    )
    found = program(monkeypatch, platform, machine)["found"]
    monkeypatch.setitem(sys.modules, "machine", board)
    name, columns, read = found()
    assert (name, columns, read()) == ("potentiometer", "pot", "1023")
    assert tuple(used) == wanted


@pytest.mark.parametrize("folder", ["firmware", "exported"])
def test_each_environment_of_platformio_compiles_a_sketch(folder, match, tmp_path):
    """PlatformIO finds sketches at the top of its folder only: a file there includes each."""
    root = FIRMWARE
    if folder == "exported":
        root = tmp_path
        ov.export.export_board(match, ov.load_preset("football"), root)
    config = configparser.ConfigParser()
    config.read(root / "platformio.ini")
    assert config["platformio"]["src_dir"] == "."
    built = {one["build_src_filter"] for one in config.values() if "build_src_filter" in one}
    assert len(built) == (3 if folder == "firmware" else 2)
    for pattern in built:
        source = (root / pattern.removeprefix("+<").removesuffix(">")).read_text("utf-8")
        assert (root / re.search(r'#include "(.*\.ino)"', source)[1]).is_file()
