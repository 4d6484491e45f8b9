"""The documented sketch for a board, compiled here with a stand-in for the library."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

from overview_dsp.devices.force_feedback.motor_loop import Commander
from tests.devices.force_feedback.simulation import ROOT

PAGE = ROOT / "docs" / "guide" / "force.md"
LIBRARY = """
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <string>
static unsigned long now_ms = 0;
static unsigned long millis() { return now_ms; }
static std::deque<std::string> waiting;
struct { void begin(long) {} } Serial;
enum { AS5600_I2C };
enum class MotionControlType { torque, velocity };
struct MagneticSensorI2C { MagneticSensorI2C(int) {} void init() {} };
struct BLDCDriver3PWM {
  double voltage_power_supply;
  BLDCDriver3PWM(int, int, int, int) {}
  void init() {}
};
struct BLDCMotor {
  double target = 0, voltage_limit = 0;
  int monitor_downsample = 10;
  MotionControlType controller = MotionControlType::velocity;
  BLDCMotor(int) {}
  template <class T> void linkSensor(T *) {}
  template <class T> void linkDriver(T *) {}
  template <class T> void useMonitoring(T &) {}
  void init() {} void initFOC() {} void loopFOC() {} void move() {}
  void monitor() { printf("%lu %.4f\\n", now_ms, target); }
};
struct Commander {
  void (*handler)(char *) = nullptr;
  template <class T> Commander(T &) {}
  void add(char, void (*given)(char *), const char *) { handler = given; }
  void motor(BLDCMotor *motor, char *line) {
    if (*line == '-' || (*line >= '0' && *line <= '9')) motor->target = atof(line);
  }
  void run() {
    while (!waiting.empty()) {
      if (waiting[0][0] == 'M') handler(&waiting[0][1]);
      waiting.pop_front();
    }
  }
};
"""
MAIN = """
int main() {
  setup();
  for (; now_ms < 300; now_ms++) {
    if (now_ms < 100) waiting.push_back("%s");
    loop();
  }
}
"""


def test_a_board_with_the_documented_sketch_ends_the_torque_in_silence(tmp_path):
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("needs a C++ compiler")
    (sketch,) = re.findall(r"```cpp\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    command = Commander("M", 10).target(-0.5).decode().strip()
    (tmp_path / "SimpleFOC.h").write_text(LIBRARY)
    (tmp_path / "board.cpp").write_text(sketch + MAIN % command)
    program = tmp_path / "board"
    subprocess.run([compiler, "-I", tmp_path, "-o", program, tmp_path / "board.cpp"], check=True)
    said = subprocess.run([program], stdout=subprocess.PIPE, check=True, text=True).stdout
    targets = {int(ms): float(target) for ms, target in map(str.split, said.splitlines())}
    assert all(targets[ms] == -0.5 for ms in range(1, 100))
    silent_at = min(ms for ms in targets if ms >= 100 and targets[ms] == 0.0)
    assert silent_at - 99 <= 50
    assert all(targets[ms] == 0.0 for ms in range(silent_at, 300))
