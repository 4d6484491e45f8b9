from __future__ import annotations

import json
import os

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from tests.cli.running import MATCH, QUICK, overview, overview_process


def test_render_writes_the_samples_of_ov_render(folder, match, football):
    outcome = overview(
        *("render", MATCH, "--gesture", "sweep:0.2+tap:0.5:0.1", "--sample-rate", "8000"),
        *("--seed", "3", "--subtype", "FLOAT", "-o", "a.wav", "--trace", "a.npz"),
    )
    assert outcome.code == 0, outcome.err
    gesture = ov.sweep(0.2) + ov.tap(0.5, 0.1)
    result = ov.render(match, football, gesture, 8000, 3)
    samples, rate = soundfile.read(folder / "a.wav", dtype="float32")
    assert rate == 8000
    assert np.array_equal(samples, result.samples)
    with np.load(folder / "a.npz") as trace:
        assert result.trace is not None
        for name, column in result.trace.items():
            assert np.array_equal(trace[name], column)
    assert sorted(os.listdir(folder)) == ["a.npz", "a.wav"]


def test_render_reports_its_file(folder):
    outcome = overview("render", MATCH, *QUICK, "-o", "a.flac", "--trace", "a.csv")
    lines = outcome.out.splitlines()
    assert lines[0].startswith("a.flac: football, 0:00.1, ")
    assert "dBFS click" in lines[0]
    assert "FLAC PCM_24, no dither" in lines[0]
    assert lines[1].startswith("a.csv: ")
    assert outcome.errors == []


def test_dither_is_reported_for_sixteen_bits(folder):
    outcome = overview("render", MATCH, *QUICK, "--subtype", "pcm_16")
    assert "WAV PCM_16, TPDF dither at 16 bits" in outcome.out


def test_the_json_report_agrees_with_the_file(folder):
    outcome = overview("render", MATCH, *QUICK, "--trace", "t.csv", "--json")
    report = json.loads(outcome.out)
    samples, rate = soundfile.read(folder / "out.wav")
    assert report["file"] == "out.wav"
    assert report["trace"] == "t.csv"
    assert report["duration_s"] == len(samples) / rate
    peaks = 20.0 * np.log10(np.abs(samples).max(axis=0))
    assert report["peak_click_dbfs"] == pytest.approx(peaks[0], abs=0.06)
    assert report["peak_tactor_dbfs"] == pytest.approx(peaks[1], abs=0.06)


def test_silence_is_reported_as_silent_and_not_as_minus_infinity(folder):
    quiet = ("--gesture", "rest:0.1", "--sample-rate", "8000", "--tail", "none")
    assert "silent click and silent tactor" in overview("render", MATCH, *quiet).out
    report = json.loads(overview("render", MATCH, *quiet, "--json").out)
    assert report["peak_click_dbfs"] is None


def test_a_window_is_a_part_of_the_timeline(folder, match, football):
    outcome = overview("render", MATCH, *QUICK, "--window", 600, 1200.5, "--subtype", "FLOAT")
    assert outcome.code == 0, outcome.err
    part = match.window(600.0, 1200.5)
    result = ov.render(part, football, ov.tap(0.2, 0.05), 8000, tail=0.05)
    samples, _ = soundfile.read(folder / "out.wav", dtype="float32")
    assert np.array_equal(samples, result.samples)


def test_a_take_and_a_preset_file_are_given_by_their_paths(folder):
    ov.save_gesture(ov.tap(0.6, 0.2), folder / "take.csv")
    from overview_dsp.design.presets.library import preset_path

    (folder / "mine.toml").write_bytes(preset_path("football").read_bytes())
    arguments = ("--sample-rate", "8000", "--tail", "0", "--subtype", "FLOAT")
    for number, given in enumerate(
        [("tap:0.6:0.2", "football"), ("take.csv", "mine.toml")],
    ):
        outcome = overview(
            *("render", MATCH, "--gesture", given[0], "--preset", given[1]),
            *("-o", f"{number}.wav", *arguments),
        )
        assert outcome.code == 0, outcome.err
    one, _ = soundfile.read("0.wav")
    other, _ = soundfile.read("1.wav")
    assert np.array_equal(one, other)


def test_unknown_kinds_are_a_note_and_no_error(folder):
    (folder / "e.csv").write_text("time_s,kind\n1,goal\n2,streaker\n3,goal\n")
    outcome = overview("render", "e.csv", *QUICK)
    assert outcome.code == 0
    notes = [line for line in outcome.err.splitlines() if line.startswith("note: ")]
    assert any("streaker" in note for note in notes)
    assert outcome.errors == []


def test_render_works_as_a_separate_process_and_loads_nothing_slow(folder, monkeypatch):
    monkeypatch.setenv("PYTHONPROFILEIMPORTTIME", "1")
    outcome = overview_process("render", MATCH, *QUICK, "--json", cwd=folder)
    assert outcome.code == 0, outcome.err
    assert "overview_dsp.offline.rendering" in outcome.err
    assert "scipy.signal" not in outcome.err
    assert json.loads(outcome.out)["file"] == "out.wav"
    assert os.listdir(folder) == ["out.wav"]


def test_figures_writes_six_pictures_and_names_them(folder):
    (folder / "e.csv").write_text("time_s,kind\n1,goal\n2,foul\n3,goal\n")
    report = json.loads(overview("figures", "--timeline", "e.csv", "--output", "p", "--json").out)
    assert len(report["files"]) == 6
    for name in report["files"]:
        assert (folder / name).stat().st_size > 1000


def test_the_demo_writes_three_sounds_and_the_pictures(folder):
    outcome = overview("demo", "--output", "d", "--json")
    assert outcome.code == 0, outcome.err
    report = json.loads(outcome.out)
    for sound in report["sounds"]:
        assert soundfile.info(sound["file"]).duration == pytest.approx(sound["duration_s"])
        assert sound["listen_for"]
    assert [sound["gesture"] for sound in report["sounds"]] == ["fast sweep", "slow sweep", "tap"]
    files = {sound["file"] for sound in report["sounds"]} | set(report["pictures"])
    assert {os.path.join("d", name) for name in os.listdir("d")} == files


def test_a_window_is_given_as_a_clock_an_event_or_a_length(folder, match, football):
    goal = match.event("goal", 1).time_s
    for number, (options, window) in enumerate(
        [
            (("--window", "10:00", "20:00.5"), (600.0, 1200.5)),
            (("--window", "goal:1-60", "goal:1+5"), (goal - 60.0, goal + 5.0)),
            (("--window", "end-5min", "end"), (match.duration_s - 300.0, match.duration_s)),
            (("--zoom-to", "goal:1:100"), (goal - 75.0, goal + 25.0)),
        ]
    ):
        name = f"{number}.wav"
        outcome = overview("render", MATCH, *QUICK, *options, "--subtype", "FLOAT", "-o", name)
        assert outcome.code == 0, outcome.err
        part = match.window(*window)
        result = ov.render(part, football, ov.tap(0.2, 0.05), 8000, tail=0.05)
        samples, _ = soundfile.read(folder / name, dtype="float32")
        assert np.array_equal(samples, result.samples)


def test_the_preset_follows_the_data_unless_it_is_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beats.csv").write_text("time_s,kind\n1,beat\n2,beat\n3,premature\n4,beat\n")
    quick = ("--gesture", "tap:0.5:0.1", "--tail", "none")
    assert overview("render", "beats.csv", *quick).out.startswith("out.wav: heart, ")
    given = overview("render", "beats.csv", "--preset", "series", *quick)
    assert given.out.startswith("out.wav: series, ")


def test_a_kind_too_dense_to_be_felt_is_noted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{i},beat\n" for i in range(1, 200))
    (tmp_path / "beats.csv").write_text(f"time_s,kind\n{rows}")
    done = overview("render", "beats.csv", "--gesture", "tap:0.5:0.1", "--tail", "none")
    assert "omitted: 199 beat" in done.out
    near = overview(
        "render", "beats.csv", "--gesture", "tap:0.5:0.1", "--tail", "none", "--window", "10", "60"
    )
    assert "omitted" not in near.out


def test_render_names_the_events_that_were_not_reached(folder):
    command = ("render", MATCH, "--gesture", "tap:0.9:0.2", "--sample-rate", "8000", "-o", "a.wav")
    assert "not reached" not in overview(*command).out  # a short tap goes all the way
    command = (*command, "--tail", "none")
    line = overview(*command).out.splitlines()[-1]
    assert line.startswith("not reached: ")
    assert line.endswith("hold it longer, render a longer tail, or move more slowly")
    missed = json.loads(overview(*command, "--json").out)["unreached"]
    assert missed[0].keys() == {"time_s", "kind", "label"}
    assert f" and {len(missed) - 6} more; " in line
    whole = ("render", MATCH, "--gesture", "sweep:0.5", "--sample-rate", "8000", "-o", "b.wav")
    assert json.loads(overview(*whole, "--json").out)["unreached"] == []
    assert "not reached" not in overview(*whole[:-1], "c.wav").out


def test_linear_renders_without_the_angle_map(folder, match, football):
    outcome = overview(
        *("render", MATCH, "--linear", "--gesture", "sweep:0.2", "--sample-rate", "8000"),
        *("--subtype", "FLOAT", "-o", "a.wav"),
    )
    assert outcome.code == 0, outcome.err
    samples, _ = soundfile.read(folder / "a.wav", dtype="float32")
    linear = football.with_value("surface.angle_map", 0.0)
    assert np.array_equal(samples, ov.render(match, linear, ov.sweep(0.2), 8000).samples)
    assert not np.array_equal(samples, ov.render(match, football, ov.sweep(0.2), 8000).samples)


@pytest.mark.parametrize(
    "command",
    [
        ("render", "match.csv", *QUICK, "-o", "match.wav"),
        ("play", "match.csv", "--device", "none", "--seconds", "0.1"),
        ("serve", "match.csv", "--port", "0", "--seconds", "0.1"),
        ("feed", "match.csv", "--speed", "1e6"),
        ("timeline", "convert", "match.csv"),
        ("timeline", "show", "match.csv"),
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_rows_that_are_no_football_events_are_noted_once(folder, command):
    if command[0] == "serve":
        pytest.importorskip("starlette", reason="needs the page: pip install '.[web]'")
    (folder / "match.csv").write_text(
        "minute,event\n8,Foul by Smith on Jones\n17,streaker\n30,Yellow card\n88,Red card Smith\n"
    )
    outcome = overview(*command)
    assert outcome.code == 0, outcome.err
    line = "omitted, not a football event kind: 1 streaker"
    shows = command[1] == "show"
    assert outcome.err.count(f"note: {line}") == (not shows)
    assert outcome.out.count(line) == (shows or command[0] == "feed")
