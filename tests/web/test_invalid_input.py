"""Whatever a page gives as a preset, a window or a rate is taken, or refused in one line."""

from __future__ import annotations

import contextlib
import copy
import json
import warnings

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.web import preset_data, sound_data

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=6,
)


def paths(node, before=()):
    """The ways to every place of nested dicts and lists."""
    found = [before]
    items = node.items() if isinstance(node, dict) else enumerate(node)
    if isinstance(node, dict | list):
        for key, inner in items:
            if isinstance(inner, dict | list):
                found += paths(inner, (*before, key))
            else:
                found.append((*before, key))
    return found


FOOTBALL = json.loads(json.dumps(preset_data.preset_data(ov.load_preset("football"))["preset"]))
PLACES = [path for path in paths(FOOTBALL) if path]


@given(st.data())
@settings(suppress_health_check=list(HealthCheck))
def test_a_preset_that_was_tampered_with_is_a_preset_or_a_one_line_error(match, football, data):
    given_preset = copy.deepcopy(FOOTBALL)
    for path in data.draw(st.lists(st.sampled_from(PLACES), min_size=1, max_size=3)):
        node = given_preset
        try:
            for key in path[:-1]:
                node = node[key]
            how = data.draw(st.sampled_from(["put", "drop", "add"]))
            if how == "put":
                node[path[-1]] = data.draw(values)
            elif how == "drop":
                del node[path[-1]]
            else:
                node[data.draw(st.text(max_size=5))] = data.draw(values)
        except (KeyError, IndexError, TypeError):
            continue
    body = {"sample_rate": 48000, "before": "football", "after": given_preset, "window": [0, 60]}
    body = json.loads(json.dumps(body))  # as it comes
    found = None
    with contextlib.suppress(ov.InputError), warnings.catch_warnings():
        warnings.simplefilter("ignore", ov.OverviewWarning)
        found = sound_data.change(match, football, body)
    assert found is None or len(found) > 1000


@given(st.dictionaries(st.sampled_from(["sample_rate", "before", "after", "window"]), values))
@settings(suppress_health_check=list(HealthCheck))
def test_any_question_for_a_change_is_refused_in_one_line(match, football, asked):
    rate = asked.get("sample_rate")
    possible = isinstance(rate, int | float) and sound_data.MIN_RATE <= rate <= sound_data.MAX_RATE
    # a rate alone is a question that has an answer
    assume(not possible or any(asked.get(key) is not None for key in ("before", "after", "window")))
    with pytest.raises(ov.InputError):
        sound_data.change(
            match, football, {**asked, "sample_rate": asked.get("sample_rate", "none")}
        )


@given(st.dictionaries(st.sampled_from(["preset", "window"]), values))
@settings(suppress_health_check=list(HealthCheck))
def test_any_question_for_a_window_is_refused_in_one_line(match, football, asked):
    with pytest.raises(ov.InputError):
        sound_data.window(match, football, asked)


@given(st.text(max_size=300), st.text(max_size=80))
@settings(suppress_health_check=list(HealthCheck))
def test_any_text_under_any_name_is_refused_and_leaves_no_file(tmp_path, monkeypatch, text, name):
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path))
    with pytest.raises(ov.InputError):
        preset_data.save_preset(name, text, True)
    assert not list(tmp_path.iterdir())


def test_the_table_of_parameters_is_the_whole_one():
    rows = {row["id"] for row in preset_data.preset_data(ov.load_preset("crowd"))["parameters"]}
    assert set(PARAMETERS) <= rows
