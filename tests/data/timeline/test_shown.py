"""A timeline and a preset in a notebook, as a picture, as a DataFrame."""

from __future__ import annotations

from datetime import datetime
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

import overview_dsp as ov

NASTY = '<script>alert("a")</script>'


def page(shown: object) -> ElementTree.Element:
    """The page of an object, parsed; no text of the data is markup."""
    text = shown._repr_html_()  # type: ignore[attr-defined]
    assert "<script" not in text
    assert len(text) < 30_000
    return ElementTree.fromstring(text)


def test_a_timelines_page_has_its_curve_gaps_and_events() -> None:
    curve = ov.Intensity(np.arange(11.0), np.linspace(-4.0, 6.0, 11) ** 3, f"°C{NASTY}")
    events = (ov.Event(2.0, "goal", NASTY), ov.Event(9.0, "foul"))
    timeline = ov.Timeline(NASTY, 10.0, events, curve, ((3.0, 5.0),), start=datetime(2020, 1, 2))
    root = page(timeline)
    words = " ".join(root.itertext())
    assert NASTY in words
    assert "goal 1, foul 1" in words
    assert "1 gap" in words
    assert "2020-01-02" in words
    assert "-64 °C" in words
    assert len(root.findall(".//{*}rect")) == 1
    # the line is broken by the gap
    line = root.findall(".//{*}path")[-1].attrib["d"]
    assert line.count("M") == 2
    assert page(ov.load_timeline("made-up-share")) is not None
    assert page(ov.Timeline("", 5.0, (ov.Event(1.0, "a"),))) is not None


def test_a_presets_page_has_a_row_a_kind(football: ov.Preset) -> None:
    rows = page(football).findall(".//tbody/tr")
    names = [(row.find("td").text or "").strip() for row in rows]  # type: ignore[union-attr]
    assert names == list(football.kinds)


def test_timeline_result_and_preset_draw_themselves(football: ov.Preset) -> None:
    result = ov.render("world-cup-final-2018", football, "sweep:0.5", sample_rate=8000)
    for shown in (result.engine.timeline, result, football):
        assert isinstance(shown.plot(), Figure)
    silent = ov.render(result.engine.timeline, football, "tap:0.1", 8000, tail="none", trace=False)
    with pytest.raises(ov.InputError, match="trace=True"):
        silent.plot()


def test_dataframes_hold_what_the_objects_do(football: ov.Preset) -> None:
    result = ov.render("world-cup-final-2018", football, "sweep:0.5", sample_rate=8000)
    trace = result.trace.to_dataframe()
    assert list(trace) == list(result.trace)
    np.testing.assert_array_equal(trace["torque"], result.trace.torque)
    np.testing.assert_array_equal(result.strikes.to_dataframe()["event"], result.strikes.event)
    match = result.engine.timeline
    assert ov.load_timeline(match.to_dataframe(), match.duration_s).events == match.events
    share = ov.load_timeline("made-up-share")
    frame = share.to_dataframe("curve")
    assert share.intensity is not None
    assert frame["moment"].iloc[0].to_pydatetime() == share.start
    np.testing.assert_array_equal(frame["value"], share.intensity.value)
    with pytest.raises(ov.InputError, match="'events' or 'curve'"):
        share.to_dataframe("all")  # type: ignore[call-overload,arg-type]


def test_names_and_specs_render_as_the_objects_do(football: ov.Preset) -> None:
    match = ov.load_timeline("world-cup-final-2018")
    expected = ov.render(match, football, ov.sweep(4.0), sample_rate=8000, tail="none").samples
    for arguments in (("world-cup-final-2018",), (match, "football", "sweep:4"), (match, football)):
        found = ov.render(*arguments, sample_rate=8000, tail="none")
        np.testing.assert_array_equal(found.samples, expected)
    series = ov.render("made-up-share", sample_rate=8000, tail="none")
    assert series.engine.preset.name == "series"
    for wrong, words in (((match, "futball"), "football"), ((match, football, "swep:1"), "swep")):
        with pytest.raises(ov.InputError, match=words):
            ov.render(*wrong)
