"""A person's threshold becomes a gain that stays."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.actuators import calibration
from overview_dsp.signal.actuators.calibration import (
    apply_calibration,
    forget_threshold,
    gain_for,
    save_threshold,
)
from overview_dsp.signal.actuators.library import LIBRARY
from tests.signal.actuators.driving import burst, driven

C2 = ov.load_actuator("c2")


@pytest.fixture(autouse=True)
def kept(tmp_path, monkeypatch):
    path = tmp_path / "config" / "actuators.json"
    monkeypatch.setattr(calibration, "calibration_file", lambda: path)
    return path


def test_who_needs_more_gets_so_much_more():
    assert gain_for(-40.0) == 0.0
    assert gain_for(-34.0) == 6.0
    assert gain_for(-55.5) == -15.5


@pytest.mark.parametrize("threshold", [-70.1, -9.9, float("nan"), float("inf")])
def test_a_threshold_that_no_gain_makes_up_for_is_an_error_of_one_line(threshold, kept):
    with pytest.raises(ov.InputError, match=r"dB; must be -70 to -10 dB"):
        save_threshold(C2, threshold)
    assert not kept.exists()


def test_a_threshold_is_kept_used_and_forgotten():
    assert apply_calibration("c2").gain_db == 0.0
    save_threshold(C2, -46.0)
    save_threshold(ov.load_actuator("lra"), -30.0)
    assert apply_calibration("c2").gain_db == -6.0
    assert apply_calibration("lra").gain_db == 10.0
    tone = burst(250.0, 0.2, 0.0, 0.1)
    plain, _ = driven(C2, tone)
    softer, _ = driven(apply_calibration("c2"), tone)
    assert np.std(softer) / np.std(plain) == pytest.approx(10 ** (-6 / 20), rel=0.01)
    assert forget_threshold(C2)
    assert not forget_threshold(C2)
    assert apply_calibration("c2").gain_db == 0.0
    assert apply_calibration("lra").gain_db == 10.0


def test_a_file_of_the_same_name_has_a_threshold_of_its_own(tmp_path):
    mine = tmp_path / "c2.toml"
    mine.write_bytes((LIBRARY.bundled_folder / "c2.toml").read_bytes())
    save_threshold(ov.load_actuator(mine), -50.0)
    assert apply_calibration("c2").gain_db == 0.0
    assert apply_calibration(mine).gain_db == -10.0


def test_a_loud_calibration_stays_within_the_rating():
    save_threshold(C2, -10.0)
    drive, stage = driven(apply_calibration("c2"), burst(250.0, 2.0, 0.0))
    assert np.abs(drive).max() <= C2.peak
    assert stage.protected.reduction_db > 1.0


@pytest.mark.parametrize(
    "text", ["[]", "{", '{"c2": 3}', '{"c2": {"gain_db": "6"}}', '{"c2": {"gain_db": 31}}',
             '{"c2": {"gain_db": NaN}}', '{"c2": {"gain_db": true}}', "\xff"],
)  # fmt: skip
def test_a_damaged_file_is_an_error_of_one_line_that_names_it(kept, text):
    kept.parent.mkdir()
    kept.write_bytes(text.encode("latin-1"))
    with pytest.raises(ov.InputError, match=r"actuators\.json: .*delete") as error:
        apply_calibration("c2")
    assert "\n" not in str(error.value)


def test_the_file_holds_what_was_felt(kept):
    save_threshold(C2, -46.0)
    assert json.loads(kept.read_text()) == {"c2": {"threshold_db": -46.0, "gain_db": -6.0}}
