"""What a notebook shows of a render."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import soundfile

import overview_dsp as ov


@pytest.fixture(scope="module")
def result(match, football):
    return ov.render(match, football, ov.tap(0.5, 0.3), sample_rate=8000)


def test_the_player_has_the_samples(result):
    data = re.search(r'src="data:audio/flac;base64,([^"]+)"', result._repr_html_())
    samples, rate = soundfile.read(io.BytesIO(base64.b64decode(data[1])), dtype="float32")
    assert rate == 8000
    np.testing.assert_allclose(samples, result.samples, atol=1.0 / 32768.0)


def test_the_picture_has_a_curve_a_row_with_its_extremes(result):
    page = result._repr_html_()
    svg = ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])
    space = "{http://www.w3.org/2000/svg}"
    assert len(svg.findall(f"{space}polyline")) == 4
    texts = [text.text for text in svg.findall(f"{space}text")]
    top = 1e3 * result.trace.torque.max()
    assert any(text.startswith("torque") and text.endswith(f"{top:.3g}") for text in texts)
    for line in svg.findall(f"{space}polyline"):
        heights = [float(point.split(",")[1]) for point in line.get("points").split()]
        assert 0.0 <= min(heights) < max(heights) <= 296.0


def test_the_page_loads_no_resources_and_names_are_escaped(match, football):
    named = replace(match, title='<img src="http://x"> & co')
    page = ov.render(named, football, ov.tap(0.5, 0.1), tail="none")._repr_html_()
    assert "<img" not in page
    assert re.findall(r'(?:src|href)="(?!data:)', page) == []


def test_a_render_without_a_trace_or_of_nothing_is_shown_too(match, football):
    bare = ov.render(match, football, ov.tap(0.5, 0.1), tail="none", trace=False)
    assert "<audio" in bare._repr_html_()
    nothing = ov.render(match, football, ov.pause(0.0), tail="none")
    assert "0.00 s" in nothing._repr_html_()


def test_the_transcript_has_the_strongest_events_in_order_with_their_level(match, football):
    shown = ov.render(match, football, ov.sweep(2.0))
    page = shown._repr_html_()
    strikes = shown.strikes.of_events()
    lines = re.findall(r"<li>([\d.]+) s: ([^<]+)</li>", page)
    times = [float(time) for time, _ in lines]
    held = shown.trace.engaged[(strikes.time_s * shown.sample_rate).astype(int)] > 0.5
    order = np.argsort(-strikes.level, kind="stable")
    strongest = np.concatenate([order[held[order]][:8], order[~held[order]][:8]])
    np.testing.assert_allclose(times, np.sort(strikes.time_s[strongest]), atol=0.006)
    # those within half a decibel of it are called so too
    loudest = [
        words for _, words in lines if words.endswith("the strongest") and " dB" not in words
    ]
    near = strikes.level >= strikes.level[order[0]] * 10 ** (-0.5 / 20)
    assert len(loudest) == near.sum()
    kind = match.events[strikes.event[order[0]]].kind.replace("_", " ")
    assert any(words.startswith(kind) for words in loudest)
    for time, words in lines:
        released = shown.trace.engaged[int(float(time) * shown.sample_rate)] < 0.5
        assert ("on the way back" in words) == released
    assert f"{len(strikes)} events passed, the strongest of each way" in page


def test_the_player_and_the_picture_have_names_and_a_silent_render_says_so(match, football):
    quiet = ov.render(match, football, ov.pause(0.1), tail="none")._repr_html_()
    assert "Transcript: no event is passed." in quiet
    assert re.search(r'<audio controls aria-label="Sound of [^"]+, 0.10 s"', quiet)
    assert re.search(r'<svg [^>]+aria-label="Curves of [^"]+"', quiet)
