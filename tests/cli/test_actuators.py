"""Actuators on the command line: what they are, and renders that are driven for one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.signal.actuators import calibration
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
from tests.cli.running import MATCH, QUICK, overview, refused


@pytest.fixture(autouse=True)
def thresholds(tmp_path, monkeypatch):
    """A file of thresholds of one's own."""
    path = tmp_path / "config" / "actuators.json"
    monkeypatch.setattr(calibration, "calibration_file", lambda: path)
    return path


def test_a_render_uses_an_actuator_and_reports_it(folder, match, football):
    told = overview("render", MATCH, *QUICK, "--subtype", "FLOAT", "--actuator", "c2")
    assert told.code == 0, told.err
    assert told.out.splitlines()[1].startswith("driven for C-2 tactor: reduced by up to ")
    result = ov.render(
        match, football, ov.tap(0.2, 0.05), 8000, tail=0.05, actuator=load_actuator("c2")
    )
    samples, _ = soundfile.read(folder / "out.wav", dtype="float32")
    assert np.array_equal(samples, result.samples)
    report = json.loads(overview("render", MATCH, *QUICK, "--actuator", "c2", "--json").out)
    assert report["actuator"]["name"] == "c2"
    assert report["actuator"]["calibration_db"] == 0.0
    assert report["actuator"]["samples_at_peak"] == result.protected.at_peak


def test_without_an_actuator_a_render_is_unchanged(folder, match, football):
    expected = ov.render(match, football, ov.tap(0.2, 0.05), 8000, tail=0.05).samples
    for option in ((), ("--actuator", "none")):
        done = overview("render", MATCH, *QUICK, "--subtype", "FLOAT", *option, "--json")
        assert json.loads(done.out)["actuator"] is None
        samples, _ = soundfile.read(folder / "out.wav", dtype="float32")
        assert np.array_equal(samples, expected)


def test_an_unknown_actuator_gives_a_one_line_error_and_writes_nothing(folder):
    words = ("no actuator is called 'headphone'", "headphones")
    refused(overview("render", MATCH, *QUICK, "--actuator", "headphone"), *words)
    assert list(folder.iterdir()) == []


def test_a_carrier_beside_the_resonance_is_a_note(folder):
    done = overview("render", MATCH, *QUICK, "--actuator", "lra")
    assert done.code == 0
    assert "note: lra is felt" in done.err


def test_a_device_keeps_its_actuator_until_another_or_none_is_named(tmp_path, monkeypatch):
    from overview_dsp.cli.options.output import output_changes
    from overview_dsp.live.output import settings as kept

    path = tmp_path / "outputs.json"
    monkeypatch.setattr(kept, "settings_file", lambda: path)

    def played(actuator, *settings):
        chosen = kept.resolve_output("pad", **output_changes(settings), actuator=actuator)
        if chosen.differ(chosen.settings):
            kept.save_settings("pad", chosen.settings)
        return chosen.settings

    assert played(None).actuator is None
    assert not path.exists()
    assert played("c2").actuator == load_actuator("c2")
    again = played(None, "tactor.gain=-3")
    assert again.actuator == load_actuator("c2")
    assert played(None) == again
    assert played("none").actuator is None
    assert played(None).actuator is None
    assert played(None).tactor.gain_db == -3.0
    path.write_text(path.read_text().replace('"actuator": null', '"actuator": "gone"'))
    with pytest.raises(ov.InputError, match=r"outputs\.json: actuator of 'pad': no actuator"):
        played(None)
    assert played("none").actuator is None
    assert kept.resolve_output(None, {}, {}, None).settings == kept.OutputSettings()


def test_the_list_names_every_actuator_and_leaves_out_a_broken_one(tmp_path, monkeypatch):
    monkeypatch.setenv("OVERVIEW_ACTUATORS", str(tmp_path))
    (tmp_path / "mine.toml").write_text("schema = 1\n", encoding="utf-8")
    done = overview("actuators", "list")
    assert done.code == 0
    assert [line.split()[0] for line in done.out.splitlines()] == list(actuator_names())[:-1]
    assert "note: not listed: " in done.err
    assert "mine.toml" in done.err
    report = json.loads(overview("actuators", "list", "--json").out)
    assert "c2" in [entry["name"] for entry in report]


def test_an_actuator_is_shown_with_what_its_values_amount_to():
    text = overview("actuators", "show", "c2").out
    for words in ("rise_ms          33 ms", "0.5 A", "Q 11.8", "-3.0 dBFS", "Assumptions"):
        assert words in text
    report = json.loads(overview("actuators", "show", "c2", "--json").out)
    assert report["values"]["drive.peak"] == 0.5
    assert report["rms_limit_dbfs"] == pytest.approx(-6.02)
    refused(overview("actuators", "show", "c"), "no actuator is called 'c'", "c2")


def test_a_sweep_is_written_within_the_rating_and_a_note_says_if_it_is_uneven(folder):
    quick = ("--duration", 2, "--sample-rate", 8000, "-o", "s.flac")
    done = overview("actuators", "sweep", "c2", *quick)
    assert done.code == 0, done.err
    assert "note" not in done.err
    samples, rate = soundfile.read(folder / "s.flac")
    assert rate == 8000
    assert samples.shape == (16_000, 2)
    assert not samples[:, 0].any()
    nominal = 10 ** (-9 / 20) * load_actuator("c2").nominal
    assert np.abs(samples[:, 1]).max() == pytest.approx(nominal, rel=1e-3)
    loud = overview("actuators", "sweep", "c2", *quick, "--level", 0, "--json")
    assert "the rating reduces the sweep by up to" in loud.err
    assert json.loads(loud.out)["actuator"]["reduction_db"] > 0.5


def test_a_shaped_sweep_is_what_presets_are_driven_with(folder):
    c2 = Path(load_actuator("c2").source).read_text().replace("overdrive = 1", "overdrive = 4")
    Path("my.toml").write_text(c2.replace("rise_ms = 33", "rise_ms = 33\ntolerance_percent = 0.5"))
    plain, shaped = (
        overview("actuators", "sweep", "my.toml", "--duration", 2, "-o", name, *option).code
        for name, option in (("a.wav", ()), ("b.wav", ("--apply-shaping",)))
    )
    assert plain == shaped == 0
    a, b = (np.abs(soundfile.read(folder / name)[0][:, 1]) for name in ("a.wav", "b.wav"))
    # beside the resonance, a drive for a lower q gives more
    assert b[: len(b) // 2].max() > 2.0 * a[: len(a) // 2].max()


@pytest.mark.parametrize("option", [("--low-frequency", 2000), ("--duration", 0), ("--level", 1)])
def test_an_invalid_sweep_writes_no_file(folder, option):
    refused(overview("actuators", "sweep", "c2", *option))
    assert list(folder.iterdir()) == []


def test_an_actuator_changes_the_wav4_export_only(folder, match, football):
    tap = ("--gesture", "tap:0.5:0.2")
    both = ("export", MATCH, *tap, "--to", "ahap", "--to", "wav4", "-o")
    assert overview(*both, "plain").code == 0
    done = overview(*both, "driven", "--actuator", "c2")
    assert done.code == 0, done.err
    assert "driven for C-2 tactor" in done.out
    assert (folder / "plain.ahap").read_bytes() == (folder / "driven.ahap").read_bytes()
    result = ov.render(match, football, ov.tap(0.5, 0.2), actuator=load_actuator("c2"))
    samples, _ = soundfile.read(folder / "driven.wav")
    plain, _ = soundfile.read(folder / "plain.wav")
    for channel in (2, 3):
        assert np.abs(samples[:, channel] - result.samples[:, 1]).max() < 1e-4
    shared = min(len(samples), len(plain))
    assert np.abs(samples[:shared, 2] - plain[:shared, 2]).max() > 0.01
    report = json.loads(overview(*both, "again", "--actuator", "c2", "--json").out)
    assert report[1]["actuator"]["name"] == "c2"


def test_an_export_that_an_actuator_would_not_change_is_refused(folder):
    words = ("applies only to wav4", "--to wav4")
    refused(overview("export", MATCH, "--to", "ahap", "--actuator", "c2"), *words)
    assert list(folder.iterdir()) == []
