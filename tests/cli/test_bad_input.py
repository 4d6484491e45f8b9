"""What people get wrong: each time one line that names the place, exit code 2, and no file."""

from __future__ import annotations

import json
import os
import sys

import numpy as np
import pytest

from overview_dsp.data.readers import bundled_timeline, save_timeline
from overview_dsp.design.presets.library import preset_path
from overview_dsp.kernels.layout import MAX_EVENTS
from tests.cli.running import MATCH, QUICK, Outcome, overview, overview_process, refused

NATIVE = {
    "overview_timeline": 1,
    "duration_s": 10,
    "events": [{"time_s": 1, "kind": "goal"}, {"time_s": 4, "kind": "goal"}],
    "intensity": {"time_s": [0, 5, 10], "value": [0, 1, 0]},
}


def native(**changes: object) -> bytes:
    return json.dumps({**NATIVE, **changes}).encode()


def noise(size: int = 1_000_000) -> bytes:
    return np.random.default_rng(1).bytes(size)


def files_of(folder) -> dict[str, bytes]:
    return {
        os.path.relpath(os.path.join(top, name), folder): b""
        for top, _, names in os.walk(folder)
        for name in names
    }


def render(folder, timeline, *options: object) -> Outcome:
    """A render that must leave the folder as it was."""
    before = files_of(folder)
    outcome = overview("render", timeline, *QUICK, *options)
    assert files_of(folder) == before
    return outcome


def test_the_faulty_examples_are_valid_without_their_faults(folder):
    (folder / "good.json").write_bytes(native())
    assert overview("render", "good.json", *QUICK).code == 0


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.json", b"", "empty"),
        ("cut.json", native()[:-30], "cut.json"),
        ("noise.json", noise(), "noise.json"),
        ("noise.csv", noise(), "noise.csv"),
        ("word.csv", b"time_s,kind\n1,goal\nsoon,goal\n", "line 3"),
        ("nan.csv", b"time_s,kind\n1,goal\nnan,goal\n", "line 3"),
        ("minus.csv", b"time_s,kind\n-1,goal\n", "line 2"),
        ("twice.csv", b"time_s,kind\n1,goal\n1,goal\n", "twice.csv"),
        ("nan.json", native(events=[{"time_s": float("nan"), "kind": "goal"}]), "events[0]"),
        ("out.json", native(events=[{"time_s": 11, "kind": "goal"}]), "events[0].time_s is 11.0"),
        ("same.json", native(events=[{"time_s": 1, "kind": "goal"}] * 2), "repeated"),
        ("times.json", native(intensity={"time_s": [0, 5, 5], "value": [0, 1, 2]}), "time_s[2]"),
        ("back.json", native(intensity={"time_s": [0, 5, 4], "value": [0, 1, 2]}), "time_s[2]"),
        ("nothing.json", b'{"overview_timeline": 1, "duration_s": 10}', "nothing.json"),
        ("list.json", b"[1, 2, 3]", "list.json"),
    ],
)
def test_a_bad_timeline_gives_a_one_line_error_that_names_the_file(folder, name, content, words):
    (folder / name).write_bytes(content)
    refused(render(folder, name), name, words)


def test_a_missing_timeline_gives_a_one_line_error(folder):
    refused(render(folder, "no.json"), "no.json", "no such file")
    refused(render(folder, "."), "is a folder")


PRESET = preset_path("football").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("k1 = 0.00036", "k3 = 1.5e-3", ("disk.k3", "unknown key")),
        ("k1 = 0.00036", "k1 = 5", ("disk.k1 = 5", "1e-05 to 1 N·m/rad")),
        ("k1 = 0.00036", "k1 = nan", ("disk.k1 = nan", "1e-05 to 1 N·m/rad")),
        ("k1 = 0.00036", 'k1 = "stiff"', ("disk.k1 = 'stiff'", "1e-05 to 1 N·m/rad")),
        ("k1 = 0.00036", "k1", ("not TOML",)),
    ],
)
def test_a_bad_preset_gives_a_one_line_error_that_names_file_line_key_and_range(
    folder, before, after, words
):
    (folder / "mine.toml").write_text(PRESET.replace(before, after), encoding="utf-8")
    number = 1 + PRESET.splitlines().index(before)
    refused(render(folder, MATCH, "--preset", "mine.toml"), f"mine.toml:{number}:", *words)


def test_an_unknown_preset_gives_a_one_line_error_with_the_nearest(folder):
    refused(render(folder, MATCH, "--preset", "footbal"), "'footbal'", "'football'")
    refused(render(folder, MATCH, "--preset", "no.toml"), "no.toml", "no such file")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"time_s,theta2_rad,touching\n0,0.5,1\n1,up,1\n", "take.csv:3: theta2_rad = 'up'"),
        (b"time_s,theta2_rad,touching\nnan,0.5,1\n", "take.csv:2: time_s"),
        (b"time_s,theta2_rad,touching\n1,0.5,1\n0.5,0.5,1\n", "take.csv:3: time_s goes back"),
        (b"time_s,theta2_rad,touching\n1,9,1\n", "0 to pi"),
        (b"time_s,theta2_rad,touching\n1e300,1,1\n", "take.csv:2: time_s = 1e+300"),
        (noise(), "take.csv"),
    ],
)
def test_a_bad_take_gives_a_one_line_error_that_names_the_file(folder, content, words):
    (folder / "take.csv").write_bytes(content)
    refused(render(folder, MATCH, "--gesture", "take.csv"), "take.csv", words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--gesture", "swipe:3"), ("'swipe:3'", "sweep:SECONDS")),
        (("--gesture", "sweep:0"), ("more than 0",)),
        (("--gesture", "tap:1.5"), ("0 (start) to 1 (end)",)),
        (("--gesture", "no.csv"), ("no.csv",)),
        (("--sample-rate", "0"), ("0 Hz", "1000 to 768000 Hz")),
        (("--sample-rate", "nan"), ("nan Hz", "1000 to 768000 Hz")),
        (("--sample-rate", "inf"), ("1000 to 768000 Hz",)),
        (("--sample-rate", "-48000"), ("1000 to 768000 Hz",)),
        (("--sample-rate", "8000.5"), ("8000.5 Hz", "whole number")),
        (("--sample-rate", "fast"), ("--sample-rate", "fast")),
        (("--tail", "soon"), ("'soon'", "rest, none or seconds")),
        (("--tail", "-1"), ("'-1'", "0 to 86400")),
        (("--tail", "nan"), ("'nan'", "0 to 86400")),
        (("--subtype", "PCM_17"), ("out.wav", "'PCM_17'", "PCM_16")),
        (("-o", "a.xyz"), ("a.xyz", "wav, flac")),
        (("-o", "a"), ("a: ", "wav, flac")),
        (("-o", "a.mp3", "--sample-rate", "767999"), ("a.mp3", "767999 Hz")),
        (("--trace", "t.txt"), ("t.txt", ".npz or .csv")),
        (("--window", "5", "5"), ("from 5.0 to 5.0", "end <= ")),
        (("--window", "50", "5"), ("window",)),
        (("--window", "0", "1e9"), ("window", "0 <= start < end <= ")),
        (("--window", "nan", "5"), ("window start",)),
        (("--window", "a", "5"), ("--window", "'a' is not a moment", "m:ss")),
        (("--window", "2018-07-15", "end"), ("--window", "no calendar")),
        (("--window", "goal:9", "end"), ("--window", "goal number 9", "has 5")),
        (("--zoom-to", "goal"), ("--zoom-to", "goal:1:90")),
        (("--zoom-to", "dog:1"), ("--zoom-to", "'dog'", "it has period")),
        (("--zoom-to", "goal:1", "--window", "0", "5"), ("--zoom-to", "exclude each other")),
        (("--seed", "1.5"), ("--seed",)),
    ],
)
def test_a_bad_option_gives_a_one_line_error_with_what_is_allowed(folder, options, words):
    refused(render(folder, MATCH, *options), *words)


def test_a_sample_rate_too_low_for_the_carrier_gives_a_one_line_error(folder):
    text = PRESET.replace("[tactor]", "[tactor]\nfrequency_hz = 900")
    (folder / "high.toml").write_text(text, encoding="utf-8")
    refused(
        render(folder, MATCH, "--preset", "high.toml", "--sample-rate", "2000"),
        "tactor.frequency_hz is 900",
        "900 Hz",
    )


@pytest.mark.parametrize("option", ["-o", "--trace"])
@pytest.mark.parametrize("where", ["no/a", "file/a", "folder", "x" * 300, "x" * 5000])
def test_an_output_that_cannot_be_written_gives_a_one_line_error(folder, option, where):
    (folder / "file").write_text("")
    suffix = ".wav" if option == "-o" else ".csv"
    (folder / f"folder{suffix}").mkdir()
    refused(render(folder, MATCH, option, where + suffix), where + suffix)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="this system has no /proc")
def test_an_output_in_a_folder_that_takes_no_files_gives_a_one_line_error(folder):
    refused(render(folder, MATCH, "-o", "/proc/a.wav"), "/proc/a.wav", "can't be written")
    refused(render(folder, MATCH, "--trace", "/proc/a.npz"), "/proc/a.npz", "can't be written")
    refused(overview("figures", "--output", "/proc/x"), "/proc/x")
    refused(overview("demo", "--output", "/proc/x"), "/proc/x")


@pytest.mark.parametrize("command", ["demo", "figures"])
def test_a_file_in_the_place_of_the_output_folder_gives_a_one_line_error(folder, command):
    (folder / "file").write_text("")
    refused(overview(command, "--output", "file"), "file", "can't be written")


def test_what_was_there_before_survives_an_error(folder):
    (folder / "out.htk").write_text("old")
    refused(render(folder, MATCH, "-o", "out.htk"), "out.htk")
    assert (folder / "out.htk").read_text() == "old"


def test_a_timeline_with_too_many_events_for_a_surface_is_rendered_with_a_warning(folder):
    lines = "".join(f"{i},goal\n" for i in range(MAX_EVENTS + 1))
    (folder / "many.csv").write_text("time_s,kind\n" + lines)
    outcome = overview("render", "many.csv", *QUICK)
    assert outcome.code == 0
    assert f"{MAX_EVENTS + 1} events" in outcome.err


def test_a_separate_process_gives_the_same_error(folder):
    (folder / "noise.json").write_bytes(noise())
    outcome = overview_process("render", "noise.json", *QUICK, cwd=folder)
    assert refused(outcome, "noise.json") == refused(overview("render", "noise.json", *QUICK))
    assert os.listdir(folder) == ["noise.json"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
def test_a_full_standard_output_gives_a_one_line_error():
    import subprocess

    from tests.cli.running import environment

    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "overview_dsp", "presets", "list"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env=environment(),
        )
    assert done.returncode == 1
    assert "bug of this program" not in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.splitlines()[0].startswith("error: ")


def test_a_title_that_the_terminal_cannot_encode_is_no_error(folder):
    timeline = bundled_timeline()
    from dataclasses import replace

    save_timeline(replace(timeline, title="試合 ⚽"), folder / "t.json")
    import subprocess

    from tests.cli.running import environment

    done = subprocess.run(
        [sys.executable, "-m", "overview_dsp", "render", "t.json", *QUICK, "--json"],
        capture_output=True,
        check=False,
        env={**environment(), "PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["file"] == "out.wav"


def test_an_error_under_json_is_json():
    done = overview("render", "no-such-file.csv", "--json")
    assert done.code == 2
    assert done.out == ""
    report = json.loads(done.errors[-1])
    assert report["exit_code"] == 2
    assert "no-such-file.csv" in report["error"]
    wrong = json.loads(overview("render", MATCH, "--json", "--nonsense").errors[-1])
    assert "No such option" in wrong["error"]


def test_a_mistyped_command_gets_a_hint_with_the_nearest_one():
    refused(overview("rendr", "x"), "'rendr'", "did you mean 'render'?")
    refused(overview("timeline", "shw"), "'shw'", "Did you mean 'show'?")
    assert "mean" not in refused(overview("zzz"), "'zzz'")


def test_a_file_whose_name_begins_like_an_option_gets_a_hint(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-x.json").write_bytes(native())
    refused(overview("timeline", "show", "-x.json"), "./-x.json")
    assert overview("timeline", "show", "./-x.json").code == 0
    assert "./" not in refused(overview("timeline", "show", "-y.json"), "-y")
