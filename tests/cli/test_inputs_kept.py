"""No output takes the place of a file that the command reads."""

from __future__ import annotations

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from tests.cli.running import MATCH, QUICK, overview, refused

TAKE = "time_s,theta2_rad,touching\n0,0,1\n0.2,1.5,1\n0.3,1.5,0\n"

CLIP = """{"Version": 1.0, "Pattern": [
  {"Event": {"Time": 0.0, "EventType": "HapticTransient", "EventParameters": [
    {"ParameterID": "HapticIntensity", "ParameterValue": 1.0},
    {"ParameterID": "HapticSharpness", "ParameterValue": 0.5}]}},
  {"Event": {"Time": 0.0, "EventType": "HapticContinuous", "EventDuration": 0.2,
    "EventParameters": [{"ParameterID": "HapticIntensity", "ParameterValue": 0.8},
    {"ParameterID": "HapticSharpness", "ParameterValue": 0.5}]}}]}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A timeline `match.json`, a recording `crowd.wav`, a take `take.csv`, a clip `boing.ahap`."""
    monkeypatch.chdir(tmp_path)
    ov.save_timeline(ov.load_timeline(MATCH), "match.json")
    noise = np.random.default_rng(1).normal(0.0, 0.1, 8000)
    soundfile.write("crowd.wav", noise, 8000)
    (tmp_path / "take.csv").write_text(TAKE)
    (tmp_path / "boing.ahap").write_text(CLIP)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "lost"),
    [
        (("render", "crowd.wav", *QUICK, "-o", "crowd.wav"), "crowd.wav"),
        (("render", "crowd.wav", *QUICK, "-o", "./x/../crowd.wav"), "crowd.wav"),
        (("render", MATCH, "--gesture", "take.csv", "-o", "a.wav", "--trace", "take.csv"),
         "take.csv"),
        (("export", "match.json", *QUICK[:2], "--to", "haptic", "--to", "android", "-o", "match"),
         "match.json"),
        (("presets", "import", "boing.ahap", "--as", "goal", "-o", "boing.ahap"), "boing.ahap"),
        (("timeline", "convert", "match.json", "-o", "match.json"), "match.json"),
        (("play", "match.json", "--device", "none", "--record", "match.csv", "--seconds", "0.1"),
         "match.json"),
        (("play", MATCH, "--input", "take.csv", "--device", "none", "--record", "take.csv"),
         "take.csv"),
    ],
)  # fmt: skip
def test_what_is_read_is_not_written_over(folder, arguments, lost):
    (folder / "x").mkdir()
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    refused(overview(*arguments), lost, "name another output")
    assert {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()} == before


def test_an_output_that_is_a_link_to_the_input_is_refused(folder):
    (folder / "link.wav").symlink_to("crowd.wav")
    refused(overview("render", "link.wav", *QUICK, "-o", "crowd.wav"), "name another output")


def test_another_file_and_a_later_command_may_be_written(folder):
    assert overview("render", "crowd.wav", *QUICK, "-o", "out.wav").code == 0
    assert overview("render", MATCH, *QUICK, "-o", "crowd.wav").code == 0


def test_from_python_a_timeline_may_be_saved_where_it_was(folder):
    ov.save_timeline(ov.load_timeline("match.json"), "match.json")
    assert len(ov.load_timeline("match.json").events) == len(ov.load_timeline(MATCH).events)
