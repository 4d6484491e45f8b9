"""The voice in C, written by hand, gives the kernels' bits: a second reading of them."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.bench.building import SAME_BITS, UNTRAPPED, MissingError, built, source
from overview_dsp.bench.same_voice import SameVoice, controls
from tests.examples import preset_with, timeline_of

RATE = 48_000
GESTURE = ov.sweep(0.8) + ov.pause(0.3) + ov.tap(0.95, 0.4) + ov.pause(0.4)


@pytest.fixture(scope="module", params=[SAME_BITS, UNTRAPPED], ids=["plain", "untrapped"])
def library(request, tmp_path_factory):
    try:
        return built(source("same_voice.c"), request.param, tmp_path_factory.mktemp("c"))
    except MissingError as missing:
        pytest.skip(f"needs a C compiler and a clone: {missing}")


def both(library, preset, timeline, rate=RATE, block=None):
    engine = ov.Engine(preset, timeline, seed=3)
    frames = round(GESTURE.duration_s * rate)
    engine.prepare(rate, frames)
    events = controls(GESTURE, rate)
    for event in events:
        engine.control(event["theta2"], bool(event["touching"]), int(event["sample"]))
    ours = np.full((frames, 2), np.nan, dtype=np.float32)
    theirs = np.full((frames, 2), np.nan, dtype=np.float32)
    engine.process(ours)
    voice = SameVoice(library, engine)
    for start in range(0, frames, block or frames):
        voice.render(events, theirs[start : start + (block or frames)])
    return ours, theirs


@pytest.mark.parametrize("rate", [8_000, RATE, 192_000])
def test_a_match_has_the_same_bits_in_c(library, match, football, rate):
    ours, theirs = both(library, football, match, rate)
    assert np.abs(ours).max(axis=0).min() > 0.1
    assert np.array_equal(ours, theirs)


def test_the_block_size_changes_no_bit_in_c(library, match, football):
    ours, theirs = both(library, football, match, block=64)
    assert np.array_equal(ours, theirs)


def test_the_limiter_and_dense_events_have_the_same_bits_in_c(library):
    loud = preset_with(height=50.0, click__gain_db=12.0, tactor__gain_db=12.0, texture__gain_db=0.0)
    ours, theirs = both(library, loud, timeline_of(*np.linspace(1.0, 99.0, 600)))
    assert np.abs(ours).max(axis=0).min() > 0.6
    assert np.array_equal(ours, theirs)
