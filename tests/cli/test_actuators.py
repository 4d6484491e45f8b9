"""Actuators on the command line: what they are, and renders that are driven for one."""

from __future__ import annotations

import json

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.actuators import calibration, load_actuator

from .running import MATCH, QUICK, overview, refused


@pytest.fixture(autouse=True)
def thresholds(tmp_path, monkeypatch):
    """A file of thresholds of one's own."""
    path = tmp_path / "config" / "actuators.json"
    monkeypatch.setattr(calibration, "calibration_file", lambda: path)
    return path


def test_a_render_is_driven_for_an_actuator_and_says_so(folder, match, football):
    told = overview("render", MATCH, *QUICK, "--subtype", "FLOAT", "--actuator", "c2")
    assert told.code == 0, told.err
    assert told.out.splitlines()[1].startswith("driven for C-2 tactor: up to ")
    result = ov.render(
        match, football, ov.tap(0.2, 0.05), 8000, tail=0.05, actuator=load_actuator("c2")
    )
    samples, _ = soundfile.read(folder / "out.wav", dtype="float32")
    assert np.array_equal(samples, result.samples)
    report = json.loads(overview("render", MATCH, *QUICK, "--actuator", "c2", "--json").out)
    assert report["actuator"]["name"] == "c2"
    assert report["actuator"]["calibration_db"] == 0.0
    assert report["actuator"]["samples_at_peak"] == result.protected.at_peak


def test_no_actuator_leaves_a_render_as_it_was(folder, match, football):
    expected = ov.render(match, football, ov.tap(0.2, 0.05), 8000, tail=0.05).samples
    for option in ((), ("--actuator", "none")):
        done = overview("render", MATCH, *QUICK, "--subtype", "FLOAT", *option, "--json")
        assert json.loads(done.out)["actuator"] is None
        samples, _ = soundfile.read(folder / "out.wav", dtype="float32")
        assert np.array_equal(samples, expected)


def test_an_unknown_actuator_is_one_line_and_writes_nothing(folder):
    words = ("no actuator is called 'headphone'", "headphones")
    refused(overview("render", MATCH, *QUICK, "--actuator", "headphone"), *words)
    assert list(folder.iterdir()) == []


def test_a_carrier_beside_the_resonance_is_a_note(folder):
    done = overview("render", MATCH, *QUICK, "--actuator", "lra")
    assert done.code == 0
    assert "note: lra moves" in done.err


def test_a_device_keeps_its_actuator_until_another_or_none_is_named(tmp_path, monkeypatch):
    from overview_dsp.cli.output_options import output_settings
    from overview_dsp.live import output_settings as kept

    path = tmp_path / "outputs.json"
    monkeypatch.setattr(kept, "settings_file", lambda: path)
    nothing = {
        f"{signal}_{key}": None
        for signal in ("click", "tactor")
        for key in ("channel", "gain", "mute", "delay", "ceiling")
    }

    def played(actuator, **options):
        chosen = output_settings("pad", {**nothing, **options}, actuator)
        if chosen.differ(chosen.settings):
            kept.save_settings("pad", chosen.settings)
        return chosen.settings

    assert played(None).actuator is None
    assert not path.exists()
    assert played("c2").actuator == load_actuator("c2")
    again = played(None, tactor_gain=-3.0)
    assert again.actuator == load_actuator("c2")
    assert played(None) == again
    assert played("none").actuator is None
    assert played(None).actuator is None
    assert played(None).tactor.gain_db == -3.0
    path.write_text(path.read_text().replace('"actuator": null', '"actuator": "gone"'))
    with pytest.raises(ov.InputError, match=r"outputs\.json: the actuator of 'pad': no actuator"):
        played(None)
    assert played("none").actuator is None
    assert output_settings(None, nothing, None).settings == kept.OutputSettings()
