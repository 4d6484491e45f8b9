"""A board that plays alone: its library in an emulator, its memory, and its pins."""

from __future__ import annotations

import re

import pytest

import overview_dsp as ov
from tests.firmware.boards import ROOT, needs, run
from tests.firmware.test_pins import S3_TAKEN
from tools import measure_board
from tools.measure_board import GESTURES, M7, RATE, TIMELINES

BOARD = ROOT / "overview_dsp" / "offline" / "export" / "board"
PAGE = ROOT / "docs" / "guide" / "alone.md"
CYCLES_S3 = 240e6 / RATE  # of a sample
FLASH, RAM = 350_000, 64_000  # bytes of voice and knob together


@pytest.fixture(scope="module", params=TIMELINES)
def exported(request, tmp_path_factory):
    """A timeline, its preset, and a sketch with both."""
    load, name = TIMELINES[request.param]
    timeline, preset = load(), ov.load_preset(name)
    folder = tmp_path_factory.mktemp(request.param)
    return timeline, preset, measure_board.export(timeline, preset, folder)


def needs_arm():
    needs("gcc-arm-none-eabi libnewlib-arm-none-eabi", "arm-none-eabi-gcc")


def test_an_emulated_teensys_core_strikes_the_events_of_render_at_their_levels(exported):
    needs_arm()
    needs("qemu-system-arm", "qemu-system-arm")
    timeline, preset, source = exported
    program = measure_board.build("cortex-m7", source)
    for name, gesture in GESTURES.items():
        result = ov.render(timeline, preset, gesture(), RATE)
        played = measure_board.play("cortex-m7", program, gesture(), len(result.samples))
        difference = measure_board.compare(played, result)
        print(name, difference, played.mean, played.highest)
        assert difference.strikes > 50
        assert difference.failures == 0
        # at two cycles for each instruction, in half the time of the slower board
        assert 100 < played.mean < played.highest < CYCLES_S3 / 4


@pytest.mark.parametrize(
    ("compiler", "options", "packages"),
    [
        ("arm-none-eabi", M7, "gcc-arm-none-eabi libnewlib-arm-none-eabi"),
        ("xtensa-lx106-elf", ("-O2", "-mlongcalls"), "gcc-xtensa-lx106"),
    ],
)
def test_voice_and_knob_leave_room_on_both_boards(exported, compiler, options, packages):
    needs(packages, f"{compiler}-gcc")
    flash = ram = 0
    for part in ("voice", "knob"):
        sizes = measure_board.sections(compiler, options, exported[2], part)
        print(part, sizes)
        assert min(sizes["code"], sizes["RAM"]) > 1000
        flash += sizes["code"] + sizes["constants"]
        ram += sizes["RAM"]
    assert 4 * 65537 < flash < FLASH
    assert ram < RAM


def test_the_tables_stay_in_the_flash_of_a_teensy(exported):
    """Its core has PROGMEM for that; other constants are copied to RAM."""
    needs_arm()
    flash = '-DPROGMEM=__attribute__((section(".progmem")))'
    options = (*M7, "-D__IMXRT1062__", flash)
    built = exported[2] / "voice.o"
    sizes = measure_board.sections("arm-none-eabi", options, exported[2], "voice")
    listed = run("arm-none-eabi-size", "-A", built).stdout
    assert int(re.search(r"^\.progmem\s+(\d+)", listed, re.M).group(1)) > 4 * 65537
    assert sizes["constants"] < 500


def pins(board):
    """The pins of a sketch by their names."""
    text = (BOARD / f"{board}.ino").read_text("utf-8")
    found = dict(re.findall(r"\b(WIPER_PIN|PHASE_[ABC]|ENABLE) = (?:A)?(\d+)", text))
    found |= dict(re.findall(r"#define I2S_(\w+) GPIO_NUM_(\d+)", text))
    return {name: int(number) for name, number in found.items()}


def test_no_sketch_uses_pins_that_an_esp32_s3_needs_itself():
    used = pins("esp32s3")
    assert len(used) == 8
    assert not set(used.values()) & S3_TAKEN
    assert not {used[name] for name in ("BCLK", "LRC", "DIN")} & {4, 5, 6, 7, 8, 9}


@pytest.mark.parametrize("path", [PAGE, BOARD / "README.txt"])
def test_the_wiring_lists_the_pins_of_the_sketches(path):
    text = path.read_text("utf-8")
    s3 = pins("esp32s3")
    heads = {board: (BOARD / f"{board}.ino").read_text("utf-8") for board in ("teensy4", "esp32s3")}
    for signal, teensy in (("BCLK", 21), ("LRC", 20), ("DIN", 7)):
        (row,) = re.findall(rf"^.* {signal}(?: of both[a-z ]*\|)?$", text, re.M)
        assert re.findall(r"\d+", row) == [str(teensy), str(s3[signal])]
        assert f"{signal} to {teensy}" in heads["teensy4"]
        assert f"{signal} to {s3[signal]}" in heads["esp32s3"]


def test_the_guide_has_the_figures_of_the_tool(match, football, tmp_path):
    """Code, constants and RAM of the match on a Teensy 4."""
    needs_arm()
    source = measure_board.export(match, football, tmp_path)
    page = PAGE.read_text("utf-8")
    for part, row in (("voice", "Teensy 4 (Cortex-M7), voice"), ("knob", "Teensy 4, core")):
        sizes = measure_board.sections("arm-none-eabi", M7, source, part)
        line = re.search(rf"^\| {re.escape(row)}[^|]*\|(.*)$", page, re.M).group(1)
        code, constants, flash, ram = (int(one.replace(",", "")) for one in line.split("|")[:4])
        assert code == pytest.approx(sizes["code"], rel=0.05)  # another version of gcc
        assert (constants, ram) == (sizes["constants"], sizes["RAM"])
        assert flash == code + constants
