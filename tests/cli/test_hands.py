"""`overview play --input`: several hands, and what is refused."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import pytest

from overview_dsp.cli.options.input import _settings
from overview_dsp.cli.options.output import callback_kind
from overview_dsp.devices.controllers.control_map import load_osc_map
from overview_dsp.errors import OverviewError
from overview_dsp.installation import install_command
from overview_dsp.live.output import devices
from overview_dsp.live.output import settings as output_settings
from overview_dsp.live.ports import midi, pads
from tests.cli.running import MATCH, ROOT, overview, refused
from tests.devices.controllers.osc_bytes import message

PLAY = ("play", MATCH, "--device", "none")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--input", "osc:"), ("osc:", "overview devices")),
        (("--input", "midi:"), ("midi:", "overview devices")),
        (("--input", "osc:x"), ("'x'", "9000")),
        (("--input", "osc:70000"), ("70000", "9000")),
        (
            ("--input", "osc:9000", "--input", "osc:9001"),
            ("osc:9001", "a second source"),
        ),
        (("--input", "sweep:1", "--input", "osc:9000"), ("must be the only source",)),
        (("--input", "sweep:1", "--input", "sweep:1"), ("a second source",)),
        (("--input", "osc:9000,sensor=imu"), ("sensor applies to serial:", "osc: allows map")),
        (("--input", "serial:x,map=x.toml"), ("map applies to osc:, midi:",)),
        (("--input", "midi:x,map=nowhere.toml"), ("nowhere.toml", "midi learn")),
        (("--osc-out", "x"), ("'x'", "9000")),
        (("--input", "midi:x,mapp=zigsim"), ("unknown setting 'mapp'", "did you mean 'map'")),
        (("--input", "osc:9000,map=zigsin"), ("osc learn", "zigsim")),
        (("--input", "http://"), ("http", "phyphox")),
        (("--input", "post:x"), ("'x'", "9000")),
        (
            ("--input", "post:8000", "--input", "serial:x"),
            ("serial:x", "a second source"),
        ),
    ],
)
def test_an_invalid_input_option_gives_a_one_line_error(arguments, words):
    refused(overview(*PLAY, *arguments), *words)


@pytest.mark.parametrize(
    ("learner", "known"),
    [("osc", "theta2, touch, mark, device"), ("midi", "theta2, touch, mark, taps")],
)
def test_what_cannot_be_learned_gives_a_one_line_error_with_what_can(tmp_path, learner, known):
    words = refused(overview(learner, "learn", "9000", "tactor.gian_db", "-o", tmp_path / "a.toml"))
    assert "did you mean 'tactor.gain_db'?" in words
    assert f"TARGET must be {known} or the id of a parameter" in words


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def test_a_fader_that_is_moved_is_learned_and_played(tmp_path):
    number, path, over = free_port(), tmp_path / "tablet.toml", threading.Event()

    def move():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            n = 0
            while not over.wait(0.01):
                n += 1
                if n < 200:
                    place = abs(1.0 - n / 100.0)
                    client.sendto(message("/1/fader7", 127.0 * place), ("127.0.0.1", number))

    moving = threading.Thread(target=move)
    moving.start()
    outcome = overview("osc", "learn", number, "theta2", "-o", path, "--json")
    over.set()
    moving.join()
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["address"] == "/1/fader7"
    assert "move it from one end to the other" in outcome.err
    assert overview("osc", "learn", number, "device", "-o", path, "--timeout", 0.2).code == 2
    assert load_osc_map(path)[0].matches("/1/fader7")
    played = overview(*PLAY, "--input", f"osc:{number},map={path}", "--seconds", 0.2)
    assert played.code == 0, played.err


def test_a_map_with_an_unknown_parameter_is_refused_before_playing(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('schema = 1\n[[control]]\ncontrol = "cc 7"\nto = "tactor.gian_db"\n')
    line = refused(overview(*PLAY, "--input", f"midi:x,map={path}"))
    assert "did you mean 'tactor.gain_db'" in line


@pytest.mark.parametrize(
    ("module", "arguments", "extra"),
    [
        ("pythonosc", ("--input", "osc:9000"), "osc"),
        ("pythonosc", ("--osc-out", "9000"), "osc"),
        ("rtmidi", ("--input", "midi:x"), "midi"),
        ("hid", ("--input", "pad:"), "pads"),
        ("bleak", ("--input", "ble:x"), "ble"),
    ],
)
def test_a_missing_library_gives_a_one_line_error_that_says_how_to_get_it(
    monkeypatch, module, arguments, extra
):
    for other in (module, {"rtmidi": "rtmidi2", "hid": "hidraw"}.get(module, module)):
        monkeypatch.setitem(sys.modules, other, None)
    refused(overview(*PLAY, *arguments), install_command(extra), code=1)


def test_lines_and_osc_play_together_and_each_is_reported(tmp_path):
    number = free_port()
    take = tmp_path / "take.csv"
    command = [sys.executable, "-m", "overview_dsp", *PLAY, "--input", "-", "--input",
               f"osc:{number}", "--record", str(take), "--seconds", "4"]  # fmt: skip
    playing = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        playing.stdin.write("2.0 1\n2.0 0\n")
        playing.stdin.flush()
        until = time.monotonic() + 60.0
        while playing.poll() is None and time.monotonic() < until:
            client.sendto(message("/overview/theta2", 1.0, 1), ("127.0.0.1", number))
            time.sleep(0.05)
    out, err = playing.communicate(timeout=60)
    assert playing.returncode == 0, err
    report = json.loads(out.splitlines()[-1])["summary"]["input"]
    assert report["osc"]["messages"] > 5
    assert report["osc"]["rejected"] == 0
    sources = {line.split(",")[-1] for line in take.read_text().splitlines()}
    assert {"twist", "osc"} <= sources, sources


def test_devices_without_portaudio_lists_the_rest_and_says_what_is_missing(monkeypatch):
    def no_library():
        raise OverviewError("no PortAudio library: install it")

    monkeypatch.setattr(devices, "devices", no_library)
    monkeypatch.setattr(pads, "pads", lambda: [pads.Pad("joycon", "Joy-Con (L)", b"")])
    lines = overview("devices", "--listen", 0)
    assert lines.code == 0
    assert "no audio output: no PortAudio library: install it" in lines.out
    assert "pad:joycon Joy-Con (L)" in lines.out
    report = json.loads(overview("devices", "--json", "--listen", 0).out)
    assert report["missing"]["outputs"] == "no PortAudio library: install it"
    assert report["outputs"] == []
    assert [pad["kind"] for pad in report["pads"]] == ["joycon"]


def test_devices_lists_midi_ports_or_says_what_is_missing(monkeypatch):
    monkeypatch.setattr(midi, "midi_ports", lambda: ["nanoKONTROL2"])
    assert "midi:nanoKONTROL2" in overview("devices", "--listen", 0).out
    found = json.loads(overview("devices", "--listen", 0, "--json").out)
    assert found["midi_ports"] == ["nanoKONTROL2"]
    monkeypatch.setattr(pads, "pads", lambda: [pads.Pad("joycon", "Joy-Con (L)", b"")])
    assert "pad:joycon Joy-Con (L)" in overview("devices", "--listen", 0).out
    monkeypatch.undo()
    for name in ("rtmidi", "rtmidi2", "hid", "hidraw"):
        monkeypatch.setitem(sys.modules, name, None)
    missing = overview("devices", "--listen", 0).out
    assert install_command("midi") in missing
    assert install_command("pads") in missing


@pytest.fixture
def remembered(tmp_path, monkeypatch):
    """A made-up output device, and the file of settings in a folder of its own."""
    monkeypatch.setattr(output_settings, "settings_file", lambda: tmp_path / "outputs.json")
    card = SimpleNamespace(full_name="Card (ALSA)", channels=4)
    monkeypatch.setattr(devices, "find_device", lambda name: card)
    return lambda: output_settings.load_settings(card.full_name, card.channels)


def test_devices_saves_changed_settings_and_keeps_the_others(remembered):
    settings = ("--set", "tactor.gain=-6", "--set", "tactor.channel=3+4", "--set", "click.mute=yes")
    assert overview("devices", "--listen", 0, "--device", "Card", *settings).code == 0
    assert (remembered().tactor.gain_db, remembered().tactor.channel) == (-6.0, (3, 4))
    assert remembered().click.mute
    assert overview("devices", "--listen", 0, "--set", "click.mute=no").code == 0
    assert not remembered().click.mute
    assert remembered().tactor.gain_db == -6.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--device", "Card"), ("--device", "--set")),
        (("--device", "none", "--set", "click.gain=1"), ("none has no settings",)),
        (("--set", "tactor.gian=1"), ("did you mean 'tactor.gain'?", "click.ceiling")),
        (("--set", "tactor.gain"), ("not KEY=VALUE",)),
        (("--set", "tactor.gain=loud"), ("--set tactor.gain=loud: 'loud' is not a number",)),
        (("--set", "tactor.gain=nan"), ("'nan' is not a number",)),
        (("--set", "tactor.gain=99"), ("gain 99 is out of range; must be -60 to 24",)),
        (("--set", "click.mute=maybe"), ("click.mute=maybe: must be yes or no",)),
        (("--set", "click.gain=1", "--set", "click.gain=2"), ("click.gain occurs twice",)),
    ],
)
def test_a_wrong_setting_gives_a_one_line_error_and_nothing_is_remembered(
    remembered, arguments, words
):
    before = remembered()
    refused(overview("devices", "--listen", 0, *arguments), *words)
    assert remembered() == before


def test_the_callback_is_chosen_by_an_environment_variable(monkeypatch):
    monkeypatch.setenv("OVERVIEW_CALLBACK", "java")
    line = refused(overview(*PLAY, "--seconds", 0.1))
    assert line == "error: OVERVIEW_CALLBACK is java; must be native or python"
    monkeypatch.setenv("OVERVIEW_CALLBACK", "python")
    assert callback_kind() == "python"
    assert overview(*PLAY, "--seconds", 0.1).code == 0
    monkeypatch.setenv("OVERVIEW_CALLBACK", "")
    assert callback_kind() == "native"


@pytest.mark.parametrize("option", [("--screen", "json"), ("--screen=json",)])
def test_with_lines_of_json_an_error_is_a_line_of_json(option):
    done = overview(*PLAY, *option, "--seconds", -1)
    assert json.loads(done.err) == {"error": "--seconds is -1; must be 0 or more", "exit_code": 2}


def test_parts_follow_a_port_whose_name_has_a_comma():
    assert _settings("", "midi", "a, b 1:0,map=x.toml") == ("a, b 1:0", {"map": "x.toml"})
    parts = {"sensor": "imu", "force": "", "baud": "9600"}
    assert _settings("", "serial", "/dev/x,sensor=imu,force,baud=9600") == ("/dev/x", parts)
