"""The page sounds as the native engine does: the same float32 samples in a real Chromium."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live.output_settings import OutputSettings, SignalSettings
from overview_dsp.units import db_to_gain
from overview_dsp.web.encoding import encode_change, encode_engine
from tests.web.schedule import BLOCK, FRAMES, RATE, RELEASE, change, engine, events, played

SOURCE_EVENTS = [
    {"sampleTime": sample, "theta2": theta2, "touching": touching, "source": source}
    for sample, theta2, touching, source in events()
]


def rendered(browser, **given):
    out, told = browser.render(rate=RATE, frames=FRAMES, **given)
    assert told["faults"] == []
    return out, told


def test_drag_tap_and_release_are_the_native_samples(browser, match, football):
    expected = played(engine(match, football))
    browser.give(image=encode_engine(engine(match, football, hands=False)))
    out, told = rendered(browser, image="image", events=SOURCE_EVENTS)
    assert len(out) > 3 * RATE
    assert np.abs(out[:RELEASE]).max(axis=0).min() > 0.1
    assert np.abs(out[RELEASE + 100 :]).max() > 0.001
    assert np.array_equal(out, expected)
    per_block = told["seconds"] / (FRAMES / BLOCK)
    budget = BLOCK / RATE
    print(
        f"\na quantum of {BLOCK} frames: {per_block * 1e6:.1f} us, {per_block / budget:.1%} of its "
        f"budget (an OfflineAudioContext's whole rendering)"
    )
