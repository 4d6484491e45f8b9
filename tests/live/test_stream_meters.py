"""What the meters of a stream say of callbacks whose times are known."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.kernels import layout
from overview_dsp.live.output.stream import read_meters, record_callback

FIFTH = 2.0 ** (1 / layout.BINS_PER_OCTAVE)  # from one bin to the next


@given(st.lists(st.floats(1e-5, 0.1), min_size=1, max_size=200))
def test_quantiles_are_to_a_fifth_and_never_beyond_the_longest(seconds):
    memory = np.zeros(layout.TOTAL)
    memory[layout.S_SAMPLE_RATE] = 48_000.0
    for one in seconds:
        record_callback(memory, 256, one)
    meters = read_meters(memory, 0.0)
    assert meters.callbacks == len(seconds)
    assert meters.late == sum(one * 48_000.0 > 256 for one in seconds)
    assert meters.median_s <= meters.p99_s <= meters.longest_s == max(seconds)
    for part, told in ((0.5, meters.median_s), (0.99, meters.p99_s)):
        true = np.quantile(seconds, part, method="inverted_cdf")
        assert true * (1 - 1e-9) <= told <= true * FIFTH * (1 + 1e-9)
