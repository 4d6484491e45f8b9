from __future__ import annotations

import copy
import pickle

import pytest

import overview_dsp as ov


@pytest.mark.parametrize("name", ov.bundled_presets())
def test_a_preset_is_itself_after_pickling_and_copying(name):
    preset = ov.load_preset(name)
    for again in (pickle.loads(pickle.dumps(preset)), copy.deepcopy(preset)):
        assert again == preset
        assert {kind: again.kind_for(kind) for kind in ("goal", "nothing")} == {
            kind: preset.kind_for(kind) for kind in ("goal", "nothing")
        }


def test_a_value_is_set_by_its_id():
    preset = ov.load_preset("football")
    assert preset.with_value("tactor.gain_db", -3).number("tactor.gain_db") == -3.0
    higher = preset.with_value("kinds.goal.height", 2.0)
    assert higher.kinds["goal"].height == 2.0
    assert higher.kinds["foul"] == preset.kinds["foul"]
    wide = preset.with_value("kinds.goal.width_ms", 500.0).kinds["goal"]
    assert (wide.width_ms, wide.width_percent) == (500.0, None)


@pytest.mark.parametrize(
    ("id", "value"),
    [
        ("tactor.gain", 1.0),
        ("kinds.goal", 1.0),
        ("kinds.gaol.height", 1.0),
        ("kinds.goal.size", 1.0),
        ("kinds.goal.height", -1.0),
        ("tactor.gain_db", "loud"),
    ],
)
def test_a_wrong_id_or_value_is_refused(id, value):
    with pytest.raises(ov.InputError, match=id.split(".")[-1]):
        ov.load_preset("football").with_value(id, value)
