"""The motor knob's sketch, compiled here with a stand-in for SimpleFOC and turned."""

from __future__ import annotations

import shutil

import pytest

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.sensors.frames import FrameDecoder, framed
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.devices.sensors.reading import Counters
from tests.devices.force_feedback.board_frames import all_frames
from tests.firmware.boards import FIRMWARE, SIMPLE_FOC, needs, run

LIBRARY = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
static unsigned long now_us = 0;
static unsigned long micros() { return now_us; }
static unsigned long received = 0;
static float angle = 0, volts = 0;
struct {
  void begin(long) {}
  // a byte each 10 us, as a wire of a megabaud brings them
  int available() { return received < sizeof FRAMES && received < now_us / 10; }
  int read() { return FRAMES[received++]; }
  void println(const char *line) { puts(line); }
  void write(uint8_t) {}
  void write(const uint8_t *data, int count) { while (count--) printf("%02x", *data++); puts(""); }
} Serial;
static void loop_foc() {}
"""

MAIN = """
int main() {
  setup();
  for (; now_us < 900000; now_us += 125) {
    angle = now_us < 300000 ? 0 : 2e-6f * (now_us - 300000);
    loop();
    if (now_us % 1000 == 0) printf("volts %lu %.4f\\n", now_us / 1000, volts);
  }
}
"""


@pytest.fixture(scope="module")
def sources(tmp_path_factory, match, football):
    """A folder with the sketch as a program, and how long the host speaks, ms."""
    folder = tmp_path_factory.mktemp("knob")
    loop = BoardLoop(load_sensor("simplefoc"), 1_000_000)
    loop.render(ov.build_surface(match, football), football.values)
    frames = b"".join(all_frames(loop, 8193))
    frames += framed(bytes((19, 1))) * 4000
    data = f"static const unsigned char FRAMES[] = {{{','.join(map(str, frames))}}};\n"
    (folder / "SimpleFOC.h").write_text(data + LIBRARY + SIMPLE_FOC)
    sketch = (FIRMWARE / "knob" / "knob.ino").read_text("utf-8")
    (folder / "knob.cpp").write_text(sketch + MAIN)
    return folder, len(frames) // 100


def test_the_knobs_sketch_brakes_the_turn_and_ends_with_the_host(sources):
    compiler = next(filter(shutil.which, ("c++", "g++", "clang++")), None)
    if compiler is None:
        pytest.skip("needs a C++ compiler")
    folder, silent = sources
    program = folder / "knob"
    run(compiler, "-O1", "-Wall", "-Werror", f"-I{folder}", f"-I{FIRMWARE / 'knob'}", "-o", program,
        folder / "knob.cpp")  # fmt: skip
    lines = run(program).stdout.splitlines()
    assert lines[0].startswith("# overview knob 1: frames")
    volts = {int(line.split()[1]): float(line.split()[2]) for line in lines if line[0] == "v"}
    sent = b"".join(bytes.fromhex(line) for line in lines[1:] if line[0] != "v")
    readings = FrameDecoder(Counters()).feed(sent)
    assert len(readings) == pytest.approx(450, abs=2)
    states = [one for one in readings if "knob_table" in one]
    assert states[-1]["knob_table"] == 1
    assert states[-1]["knob_rejected"] == 0
    assert max(volts[ms] for ms in range(320, silent)) < 0.0  # against the turn
    assert all(volts[ms] == 0.0 for ms in range(silent + 41, 900))
    assert all(volts[ms] == 0.0 for ms in range(300))


def test_the_knobs_sketch_compiles_for_a_small_arm_board(sources):
    needs("gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib",
          "arm-none-eabi-g++")  # fmt: skip
    folder, _ = sources
    run("arm-none-eabi-g++", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16",
        "-Os", "-Wall", "-Werror", f"-I{folder}", f"-I{FIRMWARE / 'knob'}", "-c",
        folder / "knob.cpp", "-o", folder / "knob.o")  # fmt: skip
