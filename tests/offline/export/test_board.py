"""A board that plays alone: its library against `render`, its files, and its sketches."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import board_table
from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from tests.cli.running import MATCH, overview
from tests.examples import timeline_of
from tests.firmware.boards import SIMPLE_FOC, needs, run
from tests.offline.export.test_c import ROOT
from tools import measure_board
from tools.measure_board import GESTURES, RATE, TIMELINES, build, compare, export, play

STANDINS = ROOT / "tests" / "offline" / "export" / "arduino"
WARNINGS = (
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wno-unused-function",
    "-Wno-unused-variable",
)


@pytest.fixture(scope="module")
def source(match, football, tmp_path_factory):
    """The sketch of a Teensy with the match."""
    return export(match, football, tmp_path_factory.mktemp("board"))


def played(timeline, preset, gesture, folder, *options):
    """What the rig plays on this machine, and its difference to `render`."""
    needs("gcc", "gcc")
    result = ov.render(timeline, preset, gesture, RATE)
    program = build("here", export(timeline, preset, folder), *options)
    there = play("here", program, gesture, len(result.samples))
    return there, compare(there, result)


@pytest.mark.parametrize("gesture", GESTURES)
@pytest.mark.parametrize("name", TIMELINES)
def test_a_board_strikes_the_events_of_render_at_their_levels(tmp_path, name, gesture):
    load, preset = TIMELINES[name]
    _, difference = played(load(), ov.load_preset(preset), GESTURES[gesture](), tmp_path)
    print(difference)
    assert difference.strikes > 50
    assert difference.compared[1] > 50
    assert difference.failures == 0


def variant(**values):
    preset = ov.load_preset("football")
    given = {key.replace("__", "."): value for key, value in values.items()}
    return replace(preset, values={**preset.values, **given})


OTHERS = {
    "without a clutch": lambda: variant(clutch__max_speed_ratio=0.0),
    "returning": lambda: variant(disk__release="return"),
    "limited": lambda: variant(tactor__gain_db=12.0, click__gain_db=12.0),
    "crests of the surface": lambda: ov.load_preset("gravel"),
    "ticks": lambda: ov.load_preset("safe-dial"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_kinds_of_presets_and_returns_are_those_of_render(match, tmp_path, name):
    gesture = (
        ov.sweep(1.0) + ov.pause(0.3) + ov.tap(0.3, 0.2) + ov.pause(1.0) + ov.sweep(2.0, 0.9, 0.1)
    )
    there, difference = played(match, OTHERS[name](), gesture, tmp_path)
    print(difference)
    assert difference.strikes > 70
    assert difference.failures == 0
    assert np.abs(there.samples).max() <= 10 ** (-1 / 20)


def test_a_wrong_friction_is_noticed(match, football, tmp_path):
    """The comparison can fail: a friction 20 % too high is not that of render."""
    needs("gcc", "gcc")
    gesture = ov.sweep(1.0)
    result = ov.render(match, football, gesture, RATE)
    folder = export(match, football, tmp_path)
    text = (folder / "overview_board.h").read_text("utf-8")
    line = "return points[0] + (points[1] - points[0]) * at.part;"
    assert line in text
    wrong = text.replace(line, line.replace("points[0] +", "1.2f * points[0] +"))
    (folder / "overview_board.h").write_text(wrong, "utf-8")
    there = play("here", build("here", folder), gesture, len(result.samples))
    assert compare(there, result).failures > 0


@pytest.fixture(scope="module")
def usual(source):
    """A gesture played in blocks of 64."""
    needs("gcc", "gcc")
    return play("here", build("here", source), BLOCKS, 2 * RATE)


BLOCKS = ov.sweep(0.7) + ov.tap(0.95, 0.2)


@pytest.mark.parametrize("block", [1, 17, 1000])
def test_no_block_size_changes_a_sample(source, usual, block):
    other = play("here", build("here", source, f"-DBLOCK={block}"), BLOCKS, 2 * RATE)
    assert np.abs(usual.samples).max(axis=0).min() > 0.1
    assert np.array_equal(usual.samples, other.samples)
    assert np.array_equal(usual.strikes, other.strikes)


def test_a_timeline_without_events_is_only_texture_and_vibration(football, tmp_path):
    there, difference = played(timeline_of(), football, ov.sweep(1.0), tmp_path)
    assert (difference.strikes, difference.failures) == (0, 0)
    assert np.abs(there.samples).max(axis=0).min() > 0.001


@pytest.mark.parametrize("language", [("gcc", "-std=c99"), ("g++", "-std=c++11", "-x", "c++")])
def test_the_library_compiles_without_warnings_as_c_and_cpp(source, tmp_path, language):
    needs("gcc g++", language[0])
    (tmp_path / "use.c").write_text(
        '#include "surface.h"\n#include "overview_board.h"\n#include "timeline.h"\n'
        "OverviewBoard voice;\nKnob knob;\nvoid use(float *a);\nvoid use(float *a) {\n"
        "  overview_board_init(&voice, &OVERVIEW_TIMELINE);\n"
        "  overview_board_knob(&knob, OVERVIEW_KNOB, sizeof OVERVIEW_KNOB);\n"
        "  overview_board_set(&voice, 1.0f, 1);\n"
        "  overview_board_process(&voice, a, a + 8, 8);\n}\n"
    )
    options = ("-Wno-unknown-pragmas", "-c", tmp_path / "use.c", "-o", tmp_path / "use.o")
    run(*language, "-O2", *WARNINGS, f"-I{source}", *options)


def test_coefficients_are_in_the_order_of_the_kernels(source):
    text = (source / "overview_board.h").read_text("utf-8")
    (listed,) = re.findall(r"enum \{\s*(OV_SPRING_HELD.*?)OV_COEFFICIENTS", text, re.S)
    names = [name for name in vars(layout) if name.startswith("C_")]
    names.sort(key=lambda name: getattr(layout, name))
    assert re.findall(r"OV_(\w+)", listed) == [name.removeprefix("C_") for name in names]


def test_the_data_name_every_event_and_quote_what_labels_hold(football, tmp_path):
    events = (ov.Event(1.0, "goal", '*/ "??/\n#error \\'), ov.Event(2.0, "foul", "Žižek"))
    timeline = ov.Timeline(title="a\\", duration_s=3.0, events=events, intensity=None)
    folder = export(timeline, football, tmp_path)
    lines = (folder / "timeline.h").read_text("ascii").splitlines()
    assert lines[0] == r'// "a\\" with the preset "football"'
    assert lines[1] == r'// event 0 at 0.3333: "goal */ \"??/\n#error \\"'
    assert lines[2].startswith("// event 1 at 0.6667: ")
    needs("gcc", "gcc")
    build("here", folder)


def test_what_a_board_does_not_compute_is_refused_by_name(match, tmp_path):
    with pytest.raises(InputError, match=r"'creaking-door' has bristles, which a board alone"):
        ov.export.export_board(match, ov.load_preset("creaking-door"), tmp_path / "board")
    for option in (("--gesture", "tap:0.5"), ("--zoom-levels", "1"), ("--actuator", "c2"),
                   ("--to", "c"), ("--transcript", "t.vtt")):  # fmt: skip
        done = overview("export", MATCH, "--to", "board", "-o", tmp_path / "board", *option)
        assert done.code == 2
        assert "--to" in done.err
    assert not (tmp_path / "board").exists()


def test_the_command_writes_a_complete_sketch_for_each_board(tmp_path):
    done = overview("export", MATCH, "--to", "board", "-o", tmp_path / "alone", "--json")
    assert done.code == 0, done.err
    for board in ("teensy4", "esp32s3"):
        text = (tmp_path / "alone" / board / f"{board}.ino").read_text("utf-8")
        for name in re.findall(r'#include "(.*?)"', text):
            assert (tmp_path / "alone" / board / name).is_file()
    assert (tmp_path / "alone" / "README.txt").is_file()


def test_a_knobs_core_gets_the_table_that_a_host_would_send(match, football, source, tmp_path):
    needs("gcc", "gcc")
    (tmp_path / "knob.c").write_text("""
#include <stdio.h>
#include "surface.h"
#include "overview_board.h"
#include "timeline.h"
static Knob knob;
int main(void) {
    static const uint8_t ALIVE[] = {KNOB_ALIVE, 1};
    int n;
    float most = 0.0f;
    knob_begin(&knob, 1.0f);
    overview_board_knob(&knob, OVERVIEW_KNOB, sizeof OVERVIEW_KNOB);
    printf("%d %d %d %d\\n", knob.disk_id, knob.active_id, knob.missing, KNOB_ALL_PARTS);
    for (n = 0; n < KNOB_POINTS; n++) printf("%d ", knob.points[knob.slot][n]);
    for (n = 0; n < 16000; n++) { /* half a turn in 4 s */
        knob_take(&knob, ALIVE, 2);
        knob_step(&knob, 1.0f + 3.14159265f * n / 16000);
        if (-knob.torque > most) most = -knob.torque;
    }
    printf("\\n%f %f\\n", knob.x / (KNOB_POINTS - 1), most);
    return 0;
}
""")
    run("gcc", "-O2", f"-I{source}", tmp_path / "knob.c", "-o", tmp_path / "knob")
    first, points, last = run(tmp_path / "knob").stdout.splitlines()
    disk, table, parts, all_parts = map(int, first.split())
    assert (disk, table, parts) == (1, 1, all_parts)
    surface = ov.build_surface(match, football)
    sent = board_table(surface, 8193, float(football.values["surface.friction"]))
    assert list(map(int, points.split())) == sent.parts.reshape(-1)[:8193].tolist()
    position, torque = map(float, last.split())
    assert position > 0.97
    assert torque > 2e-3  # N m, against the turn


TEENSY_MAIN = """
int peak[2];
int main() {
  setup();
  for (int n = 0; n < 1500; n++) {
    for (int pass = 0; pass < 29; pass++) loop();
    voice.update();
    for (int channel = 0; channel < 2; channel++)
      for (int at = 0; at < AUDIO_BLOCK_SAMPLES; at++)
        if (latest[channel][at] > peak[channel]) peak[channel] = latest[channel][at];
  }
  printf("%d %d %u %d %f\\n", peak[0], peak[1], (unsigned)board.strikes, wiper_pin, hand_theta2);
  return 0;
}
"""
ESP_MAIN = """
#include <stdlib.h>
int peak[2], blocks;
int i2s_channel_write(i2s_chan_handle_t, const void *data, size_t bytes, size_t *written,
                      uint32_t) {
  const int16_t *samples = (const int16_t *)data;
  for (size_t at = 0; at < bytes / 2; at++)
    if (samples[at] > peak[at % 2]) peak[at % 2] = samples[at];
  *written = bytes;
  for (int pass = 0; pass < 14; pass++) loop();
  if (++blocks < 3000) return 0;
  printf("%d %d %u %d %f\\n", peak[0], peak[1], (unsigned)board.strikes, wiper_pin, hand_theta2);
  exit(0);
}
int main() {
  setup();
  task(NULL);
}
"""


@pytest.mark.parametrize(
    ("board", "main", "pin"), [("teensy4", TEENSY_MAIN, 14), ("esp32s3", ESP_MAIN, 4)]
)
def test_a_sketch_plays_the_turn_of_a_potentiometer(source, tmp_path, board, main, pin):
    """Against stand-ins for the cores: 4 s for a turn from one end to the other."""
    needs("g++", "g++")
    sketch = (source.parent / board / f"{board}.ino").read_text("utf-8")
    (tmp_path / "sketch.cpp").write_text('#include "Arduino.h"\n' + sketch + main)
    run("g++", "-O1", "-std=gnu++17", "-Wall", "-Werror", "-Wno-unused-function",
        f"-I{STANDINS}", f"-I{source.parent / board}", tmp_path / "sketch.cpp",
        "-o", tmp_path / "sketch")  # fmt: skip
    lines = run(tmp_path / "sketch").stdout.split()
    click, tactor, strikes, wiper = map(int, lines[:4])
    assert min(click, tactor) > 3000
    assert strikes == 32  # every event of the match, once
    assert wiper == pin
    assert float(lines[4]) == pytest.approx(np.pi, abs=1e-4)


MOTOR = """
#include <math.h>
static float angle = 2, volts;
static void loop_foc() { // half a turn in 4 s
  const double part = (now_us - BEGAN_US) / 4e6;
  angle = 2 + 3.1416f * (part > 1 ? 1 : part);
}
"""
WATCHDOG = """
#define ESP_OK 0
struct esp_task_wdt_config_t { int timeout_ms, idle_core_mask; bool trigger_panic; };
static int esp_task_wdt_reconfigure(esp_task_wdt_config_t *) { return 0; }
static int esp_task_wdt_init(esp_task_wdt_config_t *) { return 0; }
static int esp_task_wdt_add(void *) { return 0; }
static int esp_task_wdt_reset() { return 0; }
"""


@pytest.mark.parametrize(("board", "main"), [("teensy4", TEENSY_MAIN), ("esp32s3", ESP_MAIN)])
def test_a_sketch_plays_the_turn_of_a_motor_knob_and_brakes_it(source, tmp_path, board, main):
    """Against a stand-in for SimpleFOC as well."""
    needs("g++", "g++")
    sketch = (source.parent / board / f"{board}.ino").read_text("utf-8")
    (tmp_path / "SimpleFOC.h").write_text(
        MOTOR + SIMPLE_FOC.replace("volts = target", "volts = fminf(volts, target)")
    )
    (tmp_path / "esp_task_wdt.h").write_text(WATCHDOG)
    said = 'printf("%f ", volts), printf("%d'
    (tmp_path / "sketch.cpp").write_text(
        '#include "Arduino.h"\n' + sketch + main.replace('printf("%d', said)
    )
    defined = ["-DMOTOR", *(["-DARDUINO_ARCH_ESP32"] if board == "esp32s3" else [])]
    run("g++", "-O1", "-std=gnu++17", "-Wall", "-Werror", "-Wno-unused-function",
        "-Wno-unused-variable", "-Wno-unknown-pragmas", *defined, f"-I{tmp_path}",
        f"-I{STANDINS}", f"-I{source.parent / board}", tmp_path / "sketch.cpp",
        "-o", tmp_path / "sketch")  # fmt: skip
    volts, click, tactor, strikes, _, theta2 = map(float, run(tmp_path / "sketch").stdout.split())
    assert volts < -0.5  # against the turn
    assert min(click, tactor) > 3000
    assert strikes == 32
    assert theta2 == pytest.approx(np.pi, abs=1e-3)


def test_the_tool_reports_missing_programs_by_their_package(monkeypatch):
    monkeypatch.setattr(measure_board.shutil, "which", lambda name: None)
    assert measure_board.missing("here") == "gcc"
    assert "qemu-system-arm" in measure_board.missing("cortex-m7")
