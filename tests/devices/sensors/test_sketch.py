"""The documented sketch for a board, compiled here: what it sends is understood."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from overview_dsp.devices.sensors.frames import FrameDecoder
from overview_dsp.devices.sensors.reading import Counters

PAGE = Path(__file__).resolve().parents[3] / "docs" / "guide" / "sensors.md"
BOARD = """
#include <cstdint>
#include <cstdio>
#include <cstring>
static uint32_t now_us = 4294960000u;
static uint32_t micros() { return now_us += 1000; }
struct { void write(const uint8_t *data, int count) { fwrite(data, 1, count, stdout); } } Serial;
%s
int main() {
  for (int n = 0; n < 300; n++) {
    int16_t values[6] = {(int16_t)n, (int16_t)-n, (int16_t)(256 * n), 0, 32767, -32768};
    sendSample(values);
  }
}
"""


def test_a_board_with_the_documented_sketch_is_understood(tmp_path):
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("needs a C++ compiler")
    (sketch,) = re.findall(r"```cpp\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    (tmp_path / "board.cpp").write_text(BOARD % sketch)
    program = tmp_path / "board"
    subprocess.run([compiler, "-o", program, tmp_path / "board.cpp"], check=True)
    sent = subprocess.run([program], stdout=subprocess.PIPE, check=True).stdout
    counters = Counters()
    readings = FrameDecoder(counters).feed(sent)
    assert (counters.readings, counters.damaged, counters.fragments) == (300, 0, 0)
    assert [reading["sequence"] for reading in readings] == list(range(300))
    for n, reading in enumerate(readings):
        assert reading["ax"] == n
        assert reading["ay"] == -n
        assert reading["az"] == (256 * n + 32768) % 65536 - 32768
        assert (reading["gx"], reading["gy"], reading["gz"]) == (0, 32767, -32768)
