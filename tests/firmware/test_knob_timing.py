"""The motor knob's sketch over 110 minutes of a simulated clock, with slow reads and stalls."""

from __future__ import annotations

import json
import shutil

import pytest

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.sensors.frames import framed
from overview_dsp.devices.sensors.profile import load_sensor
from tests.devices.force_feedback.board_frames import all_frames
from tests.firmware.boards import FIRMWARE, SIMPLE_FOC, run

LIBRARY = """
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include "surface.h"
static uint64_t now = 0;  // us; a board's counter has 32 bits
static uint32_t micros() { return (uint32_t)now; }
static const unsigned char *next_byte = FRAMES;
static int waiting = 0;
static uint64_t steps = 0, reports = 0;
static float angle = 0, volts = 0;
static uint32_t dice = 1;
static uint32_t least_us = LEAST_US, most_us = MOST_US;
static uint32_t drawn() { return (dice = dice * 1664525u + 1013904223u) >> 8; }
static float counted(Knob *k, float shaft) { steps++; return knob_step(k, shaft); }
#define knob_step counted
#define long int  // as on the boards: 32 bits
struct {
  void begin(int) {}
  int available() { return waiting; }
  int read() { waiting--; return *next_byte++; }
  void println(const char *) {}
  void write(uint8_t) {}
  void write(const uint8_t *, int) { reports++; }
} Serial;
static void loop_foc() { now += least_us + drawn() % (most_us - least_us + 1); }
"""

MAIN = """
#undef long
// The host speaks to HOST_US and from AGAIN_US on; each 7 minutes (STALLS) loop() stalls for 0.5 s.
#define US 1000000ull
static void say(const unsigned char *bytes, int count) { next_byte = bytes; waiting = count; }
int main() {
  uint64_t said = 0, begun, dead_us = 0, stall = 420 * US, held = 0, second = US, at = 0;
  uint64_t least = 1u << 30, most = 0, after_stall = 0, turned = 0, again = 0;
  setup();
  say(FRAMES, sizeof FRAMES);
  begun = now;
  for (bool first = true; now < 6600 * US; first = false) {
    bool speaks = now < HOST_US || now >= AGAIN_US;
    if (!first && !waiting && speaks && now - said >= 2000) say(ALIVE, sizeof ALIVE), said = now;
    float way = now / 1000 % 4000 < 2000 ? -1.4f : 1.4f;
    angle = 1.5f + way * (0.5f - (now / 1000 % 2000) / 2000.0f);
    if (STALLS && now >= stall) now += US / 2, stall += 420 * US, after_stall = now;
    loop();
    if (volts != 0) {
      if (speaks) { turned++; if (now >= AGAIN_US) again++; }
      else if (now > HOST_US) { held++; dead_us = now - HOST_US; }
    }
    if (now >= second) {
      uint64_t rate = (steps - at) * US / (now - second + US);
      if (now - after_stall > 2 * US || !after_stall) {
        if (rate < least) least = rate;
        if (rate > most) most = rate;
      }
      at = steps;
      second = now + US;
    }
  }
  printf("{\\"least\\": %llu, \\"most\\": %llu, \\"steps\\": %llu, \\"reports\\": %llu, "
         "\\"dead_us\\": %llu, \\"turned\\": %llu, \\"again\\": %llu}\\n",
         (unsigned long long)least, (unsigned long long)most, (unsigned long long)steps,
         (unsigned long long)reports,
         (unsigned long long)dead_us, (unsigned long long)turned, (unsigned long long)again);
}
"""
MINUTE_US = 60_000_000


@pytest.fixture(scope="module")
def played(tmp_path_factory, match, football):
    """A function that compiles the sketch for reads of `us` and returns what 110 minutes gave."""
    compiler = next(filter(shutil.which, ("c++", "g++", "clang++")), None)
    if compiler is None:
        pytest.skip("needs a C++ compiler")
    loop = BoardLoop(load_sensor("simplefoc"), 1_000_000)
    loop.render(ov.build_surface(match, football), football.values)
    data = "".join(
        f"static const unsigned char {name}[] = {{{','.join(map(str, sent))}}};\n"
        for name, sent in (
            ("FRAMES", b"".join(all_frames(loop, 8193)) + framed(bytes((19, 1)))),
            ("ALIVE", framed(bytes((19, 1)))),
        )
    )

    def play(least_us, most_us, host=200.0, again=200.0, stalls=True):
        folder = tmp_path_factory.mktemp("timing")
        (folder / "SimpleFOC.h").write_text(data + LIBRARY + SIMPLE_FOC)
        sketch = (FIRMWARE / "knob" / "knob.ino").read_text("utf-8")
        (folder / "knob.cpp").write_text(sketch + MAIN)
        values = {
            "LEAST_US": least_us,
            "MOST_US": most_us,
            "HOST_US": f"{int(host * MINUTE_US)}ull",
            "AGAIN_US": f"{int(again * MINUTE_US)}ull",
            "STALLS": int(stalls),
        }
        run(compiler, "-O2", f"-I{folder}", f"-I{FIRMWARE / 'knob'}",
            *(f"-D{name}={one}" for name, one in values.items()),
            "-o", folder / "knob", folder / "knob.cpp")  # fmt: skip
        return json.loads(run(folder / "knob").stdout)

    return play


@pytest.mark.parametrize("reads_us", [(470, 470), (20, 900)])
def test_the_surface_is_stepped_at_its_rate_for_110_minutes(played, reads_us):
    """Also after the counter of microseconds began again, and beside stalls."""
    got = played(*reads_us)
    print(got)
    assert got["least"] >= 3980
    assert got["most"] <= 4020
    assert got["turned"] > 0
    assert got["reports"] == pytest.approx(500 * 6600, rel=0.01)


def test_the_torque_ends_with_the_host_and_stays_away_for_80_minutes(played):
    """It comes back with the host."""
    got = played(20, 900, host=10.0, again=90.0)
    print(got)
    assert 0 < got["dead_us"] <= 40_000
    assert got["again"] > 0
