"""A rising tone on an output, and the level at which a key was pressed."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.live.output import threshold
from overview_dsp.live.output.settings import SignalSettings
from overview_dsp.live.output.threshold import NullSamplePlayer, RisingTone, find_threshold
from tests.live import jack_server

RATE = 48_000
C2 = ov.load_actuator("c2").unshaped
OUT = SignalSettings(2)


def test_the_tone_rises_as_it_says_through_the_actuators_drive():
    rise = RisingTone(250.0, 20.0, 1.5)
    drive = rise.drive(C2, OUT, 2, RATE)
    assert drive.shape == (RATE * 9 // 2, 2)
    assert not drive[:, 0].any()
    assert not drive[: RATE * 3 // 2].any()
    crest = np.abs(drive[RATE * 3 // 2 :, 1]).reshape(-1, RATE // 250).max(axis=1)
    for time_s in (2.0, 3.0, 4.0):
        level = 20.0 * math.log10(crest[round((time_s - 1.5) * 250)] / C2.nominal)
        assert level == pytest.approx(rise.level_at(time_s), abs=0.1)
    assert rise.level_at(1.5) == -70.0
    assert rise.level_at(4.5) == -10.0
    assert rise.level_at(1.49) == -math.inf


def test_the_tone_is_on_the_outputs_channel_below_its_ceiling():
    drive = RisingTone(250.0, 60.0, 0.0).drive(C2, SignalSettings(4, ceiling_db=-20.0), 4, RATE)
    assert drive.shape[1] == 4
    assert not drive[:, :3].any()
    assert np.abs(drive[:, 3]).max() == pytest.approx(0.1)
    both = RisingTone(250.0, 60.0, 0.0).drive(C2, SignalSettings((3, 4), ceiling_db=-20.0), 4, RATE)
    assert not both[:, :2].any()
    assert (both[:, 2:] == drive[:, 3:]).all()


@pytest.mark.parametrize(
    ("hertz", "db_per_s", "words"),
    [
        (0.5, 3.0, "tone frequency 0.5 Hz must be 1 to 21600 Hz"),
        (float("nan"), 3.0, "tone frequency nan Hz"),
        (250.0, 0.0, "ramp of 0 dB/s must be 0.5 to 60"),
        (250.0, float("nan"), "ramp of nan dB/s"),
    ],
)
def test_an_invalid_tone_gives_a_one_line_error(hertz, db_per_s, words):
    with pytest.raises(ov.InputError, match=words):
        RisingTone(hertz, db_per_s, 0.0).drive(C2, OUT, 2, RATE)


class PlaybackStub:
    """A playback that is as far as it is told, and counts its calls."""

    def __init__(self, times):
        self.times = list(times)
        self.played_s = 0.0
        self.calls = []

    def start(self):
        self.calls.append("start")

    def close(self):
        self.calls.append("close")

    @property
    def over(self):
        if not self.times:
            return True
        self.played_s = self.times.pop(0)
        return False


def test_the_threshold_is_the_level_played_when_the_key_is_pressed():
    rise = RisingTone(250.0, 3.0, 2.0)
    for pressed_at, level in ((5.0, -61.0), (12.0, -40.0), (1.0, -math.inf), (99.0, math.inf)):
        playback = PlaybackStub(np.arange(0.0, 22.0, 0.5))
        found = find_threshold(rise, playback, lambda p=playback, at=pressed_at: p.played_s >= at)
        assert found == level
        assert playback.calls == ["start", "close"]


def test_an_output_is_given_back_when_asking_fails():
    playback = PlaybackStub([0.0, 1.0])

    def broken():
        raise ov.InputError("no more")

    with pytest.raises(ov.InputError):
        find_threshold(RisingTone(250.0, 3.0, 0.0), playback, broken)
    assert playback.calls == ["start", "close"]


def test_a_player_without_sound_lasts_as_long_as_its_samples():
    output = NullSamplePlayer(np.zeros((2400, 2), dtype=np.float32), RATE)
    output.start()
    assert not output.over
    time.sleep(0.06)
    assert output.over


def test_the_played_time_is_that_delivered_less_the_latency(monkeypatch):
    now = [100.0]
    opened = []

    class Stream:
        latency = 0.25

        def __init__(self, **settings):
            self.callback = settings["callback"]
            opened.append(self)

    monkeypatch.setattr(
        threshold,
        "import_sounddevice",
        lambda: SimpleNamespace(OutputStream=Stream, PortAudioError=ValueError),
    )
    monkeypatch.setattr(threshold, "time", SimpleNamespace(monotonic=lambda: now[0]))
    output = threshold.SamplePlayer(np.ones((1000, 1), dtype=np.float32), 1000.0)
    assert output.played_s == 0.0
    out = np.empty((500, 1), dtype=np.float32)
    opened[0].callback(out, 500, None, None)
    assert output.played_s == pytest.approx(0.25)
    now[0] += 0.1
    assert output.played_s == pytest.approx(0.35)
    opened[0].callback(out, 500, None, None)
    assert output.played_s == pytest.approx(0.75)
    assert not output.over
    now[0] += 0.3
    assert output.over


CALIBRATE = [sys.executable, "-m", "overview_dsp", "actuators", "calibrate", "c2"]


def test_pressing_enter_keeps_the_level_and_it_is_used_from_then_on(tmp_path, monkeypatch):
    for variable in ("XDG_CONFIG_HOME", "APPDATA", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path))
    process = subprocess.Popen(
        [*CALIBRATE, "--device", "none", "--repeats", "1", "--ramp", "10", "--json"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdin is not None and process.stderr is not None  # noqa: PT018
    for line in process.stderr:
        if line.startswith("tone"):
            time.sleep(3.5)  # after the longest silence, before the end of the shortest
            process.stdin.write("\n")
            process.stdin.flush()
            break
    report = json.loads(process.communicate(timeout=30)[0])
    assert process.returncode == 0
    assert report["levels_db"] == [report["threshold_db"]]
    assert -70.0 <= report["threshold_db"] <= -10.0
    assert report["gain_db"] == pytest.approx(report["threshold_db"] + 40.0)
    shown = subprocess.run(
        [*CALIBRATE[:-2], "show", "c2", "--json"], capture_output=True, text=True, check=True
    )
    assert json.loads(shown.stdout)["calibration_db"] == pytest.approx(report["gain_db"], abs=0.01)


HEAR = """
import sys, time
import jack
import numpy as np
from overview_dsp.live.output.threshold import SamplePlayer

path, seconds = sys.argv[1], float(sys.argv[2])
samples = np.zeros((48_000, 2), dtype=np.float32)
samples[:, 1] = np.linspace(0.25, 0.5, 48_000)
output = SamplePlayer(samples, 48_000, "system")
client = jack.Client("recorder")
ports = [client.inports.register(name) for name in ("one", "two")]
heard = np.zeros((120_000, 2), dtype=np.float32)
state = {"at": 0}

@client.set_process_callback
def record(frames):
    at = state["at"]
    count = min(frames, len(heard) - at)
    for channel, port in enumerate(ports):
        heard[at : at + count, channel] = port.get_array()[:count]
    state["at"] = at + count

with client:
    output.start()
    for channel, port in enumerate(ports):
        client.connect(f"overview:out_{channel}", port)
    until = time.monotonic() + seconds
    while time.monotonic() < until and not output.over:
        time.sleep(0.01)
    told = output.played_s
    output.close()
    output.close()
    time.sleep(0.3)
np.save(path, heard)
print(told)
"""


@pytest.mark.realtime
@pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
def test_a_device_plays_the_samples_and_ends_without_a_step(tmp_path):
    with jack_server.Server() as server:
        done = subprocess.run(
            [sys.executable, "-c", HEAR, str(tmp_path / "heard.npy"), "0.6"],
            env=server.environment, capture_output=True, text=True, timeout=60,
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    heard = np.load(tmp_path / "heard.npy")
    assert not heard[:, 0].any()
    sound = np.flatnonzero(heard[:, 1])
    level = heard[sound[0] : sound[-1] + 1, 1].astype(float)
    # the samples themselves until the fade, which is smooth
    step = 0.25 / 47_999
    fade = len(level) - 960
    assert np.abs(np.diff(level[: fade - 1024]) - step).max() < 1e-6
    assert np.abs(np.diff(level)).max() < 0.002
    assert abs(level[-1]) < 0.002
    assert float(done.stdout) == pytest.approx((level[fade] - 0.25) / 0.25, abs=0.1)
