"""Rhythms of WFDB annotations: read by their names, kept by their codes."""

from __future__ import annotations

import pytest

import overview_dsp as ov
from overview_dsp.cli.timeline import describe, describe_json
from overview_dsp.offline.rendering.event_log import as_records, as_text, passed_events, transcript
from overview_dsp.web.site_data import window_json

LABELS = ("rhythm (N", "rhythm (AFIB", "rhythm (XYZ", "rhythm", "rhythm (N and more")
WORDS = ("normal rhythm", "atrial fibrillation", "rhythm XYZ", "rhythm", "rhythm (N and more")


@pytest.fixture(scope="module")
def heart():
    events = [ov.Event(float(10 * n + 10), "rhythm", label) for n, label in enumerate(LABELS)]
    return ov.Timeline("a heart", 60.0, tuple(events))


def test_a_rhythms_code_is_read_as_its_name(heart):
    assert tuple(event.display_label for event in heart.events) == WORDS
    assert ov.Event(1.0, "comment", "rhythm (N").display_label == "rhythm (N"


def test_screen_transcript_and_page_say_the_name(heart):
    surface = ov.build_surface(heart, ov.load_preset("heart"))
    page = window_json(heart, surface, 0.0)
    assert tuple(event["label"] for event in page["events"]) == WORDS
    told = ov.render(heart, "heart", "sweep:2", sample_rate=8000)
    spoken = "\n".join(transcript(told.strikes, heart, None, 8000.0))
    listed = as_text(passed_events(told.strikes, heart))
    for text in (describe(heart, events=True), spoken, listed):
        assert all(words in text for words in WORDS)
        assert "(AFIB" not in text


def test_what_is_written_keeps_the_code(heart, tmp_path):
    ov.save_timeline(heart, tmp_path / "heart.json")
    kept = ov.load_timeline(tmp_path / "heart.json")
    assert tuple(event.label for event in kept.events) == LABELS
    assert describe_json(kept, events=True)["event_list"][1]["label"] == "rhythm (AFIB"
    passed = ov.render(heart, "heart", "sweep:2", sample_rate=8000).strikes
    assert as_records(passed_events(passed, heart))[1]["label"] == "rhythm (AFIB"
