"""Lines of the feed format: their effects, and the errors of invalid lines."""

from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import MAX_LINE_BYTES, Lines, encode_line
from tests.data.feeds.feeds import apply_all, apply_line, lines_of

HEADER = {"overview_feed": 1, "title": "A - B", "expected_duration_s": 5700}


def timeline_of(*lines):
    live = ov.LiveTimeline()
    for line in lines:
        apply_line(live, encode_line(line))
    return live


def test_each_kind_of_line_has_its_effect():
    live = timeline_of(
        HEADER,
        {"event": {"time_s": 60, "kind": "goal", "label": "1-0", "weight": 2}, "id": 7},
        {"event": {"time_s": 70, "kind": "foul"}},
        {"detail": {"time_s": 65, "kind": "touch"}},
        {"sample": [0, 0.5]},
        {"sample": [[10, 0.6], [20, 0.7]]},
        {"gap": [30, 40], "reason": "no camera"},
        {"retract": {"time_s": 70, "kind": "foul"}},
        {"clock": 100},
        {"subtitle": "of a later version"},
    )
    shown = live.snapshot()
    assert shown.title == "A - B"
    assert shown.events == (ov.Event(60.0, "goal", "1-0", 2.0),)
    assert [event.kind for event in shown.details] == ["touch"]
    assert shown.intensity.count == 3
    assert (30.0, 40.0) in shown.gaps
    assert (shown.duration_s, shown.known_until_s) == (5700.0, 100.0)
    apply_line(live, encode_line({"retract": 7}))
    apply_line(live, encode_line({"end": 90, "title": "A 0-0 B"}))
    assert (live.snapshot().title, live.snapshot().duration_s) == ("A 0-0 B", 90.0)
    assert live.snapshot().events == (ov.Event(60.0, "withdrawn_goal", "1-0", 2.0),)
    assert apply_line(live, '{"subtitle": "of a later version"}') == "later"
    assert repr(live) == "<LiveTimeline 'A 0-0 B': ended, 1 event>"


def test_whoever_sees_the_end_sees_the_final_title(monkeypatch):
    live = timeline_of({"event": {"time_s": 5, "kind": "foul"}})
    titles = []
    end = ov.LiveTimeline.end

    def end_and_look(self, duration_s=None):
        titles.append(self.snapshot().title)
        end(self, duration_s)

    monkeypatch.setattr(ov.LiveTimeline, "end", end_and_look)
    apply_line(live, encode_line({"end": 90, "title": "A 1-0 B"}))
    assert titles == ["A 1-0 B"]


@pytest.mark.parametrize(
    ("line", "word"),
    [
        (b"{", "JSON"),
        (b"\xff\xfe", "JSON"),
        (b"[1]", "object"),
        (b'{"event": {"time_s": 1}}', "kind"),
        (b'{"event": {"time_s": -1, "kind": "foul"}}', "before the start"),
        (b'{"event": {"time_s": NaN, "kind": "foul"}}', "finite"),
        (b'{"event": {"time_s": 1, "kind": "foul", "who": "x"}}', "who"),
        (b'{"event": {"time_s": 1, "kind": "foul"}, "clock": 3}', "both"),
        (b'{"clock": "90:00"}', "clock"),
        (b'{"clock": 1e99}', "0 to"),
        (b'{"sample": [1, 2, 3]}', "sample"),
        (b'{"sample": [1, Infinity]}', "finite"),
        (b'{"gap": [9, 3]}', "before its end"),
        (b'{"retract": null}', "object"),
        (b'{"end": -3}', "above 0"),
        (b'{"end": -3, "title": "A 1-0 B"}', "above 0"),
        (b'{"end": 90, "title": "A 1-0 B", "notes": 3}', "list of strings"),
        (b'{"overview_feed": 2}', "must be 1, the version"),
        (b'{"overview_feed": 1, "layout": "half"}', "whole, so far"),
        (b"[" * 100_000, "JSON"),
    ],
)
def test_an_invalid_line_is_a_one_line_error_and_changes_nothing(line, word):
    live = timeline_of({"event": {"time_s": 5, "kind": "foul"}})
    before = live.snapshot()
    with pytest.raises(ov.InputError, match=word) as raised:
        apply_line(live, line)
    assert "\n" not in str(raised.value)
    assert live.snapshot() is before


@given(st.binary(max_size=300) | st.text(max_size=100).map(json.dumps).map(str.encode))
@settings(max_examples=150)
def test_random_bytes_are_rejected_or_skipped(line):
    live = timeline_of({"event": {"time_s": 5, "kind": "foul"}})
    before = live.snapshot()
    for part in line.split(b"\n"):
        with contextlib.suppress(ov.InputError):
            assert apply_line(live, part) in ("", "later")
    assert live.snapshot() is before


@given(st.data())
@settings(max_examples=50)
def test_the_lines_do_not_depend_on_how_the_bytes_are_split(data):
    lines = [b"a", b"", b"x" * MAX_LINE_BYTES, b"y" * (MAX_LINE_BYTES + 1), b"z" * 1_000_000, b"b"]
    lines = data.draw(st.permutations(lines))
    whole = b"\n".join(lines) + b"\nlast"
    cuts = sorted(data.draw(st.lists(st.integers(0, len(whole)), max_size=8)))
    splitter = Lines()
    found = []
    for start, end in zip([0, *cuts], [*cuts, len(whole)], strict=True):
        found += splitter.cut(whole[start:end])
    found += splitter.last()
    assert found == [*(line for line in lines if len(line) <= MAX_LINE_BYTES), b"last"]
    assert splitter.too_long == 2


def test_an_endless_line_takes_bounded_memory():
    splitter = Lines()
    for _ in range(200):
        assert list(splitter.cut(b"x" * 10_000)) == []
    assert len(splitter._rest) <= MAX_LINE_BYTES
    assert list(splitter.cut(b"\n{}\n")) == [b"{}"]


def test_the_layout_and_duration_of_the_user_take_precedence_over_the_feed(match):
    live = ov.LiveTimeline(expected_duration_s=7000.0, layout="so far")
    apply_line(live, encode_line({**HEADER, "layout": "whole"}))
    assert (live.expected_duration_s, live.layout) == (7000.0, "so far")


def test_a_header_with_the_keys_of_version_0_1_is_read():
    live = timeline_of({"overview_feed": 1, "expect_s": 5700, "map": "so far"})
    assert (live.expected_duration_s, live.layout) == (5700.0, "so far")


def test_a_feed_has_no_score_before_its_end(match):
    assert "4-2" in match.title
    live = ov.LiveTimeline()
    first, *_ = lines_of(match)
    apply_line(live, encode_line(first))
    assert "4-2" not in live.snapshot().title
    assert "France - Croatia" in live.snapshot().title
    apply_all(live, match)
    assert live.snapshot() == match
