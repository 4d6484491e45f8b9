"""The modal bank a run of samples at a time: the bits of one sample at a time."""

from __future__ import annotations

import numba
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import ring, ring_chunk

END = layout.LIVE


@numba.njit
def one_by_one(m, w, frames):
    for n in range(frames):
        m[layout.D_CLICK + n] = ring(m, w)


@numba.njit
def at_once(m, w, frames):
    ring_chunk(m, w, frames)


@settings(max_examples=200, deadline=None)
@given(
    kinds=st.lists(
        st.tuples(st.integers(0, layout.BANKS - 1), st.integers(1, 6), st.integers(1, 150)),
        unique_by=lambda kind: kind[0],
        max_size=8,
    ),
    chunks=st.lists(st.integers(1, layout.CHUNK), min_size=1, max_size=4),
    seed=st.integers(0, 1000),
)
def test_what_rings_has_the_bits_of_one_sample_at_a_time(kinds, chunks, seed):
    m = np.zeros(END)
    w = m.view(np.int64)
    random = np.random.default_rng(seed)
    w[layout.RINGING] = len(kinds)
    for i, (kind, modes, left) in enumerate(kinds):
        w[layout.RINGING_KIND + i] = kind
        w[layout.BANK_LEFT + kind] = left
        w[layout.BANK_MODES + kind] = modes
        for j in range(kind * layout.MAX_MODES, kind * layout.MAX_MODES + modes):
            radius, angle = random.uniform(0.9, 1.0), random.uniform(0.0, 3.0)
            m[layout.BANK_RE + j], m[layout.BANK_IM + j] = random.normal(size=2)
            m[layout.BANK_COS + j] = radius * np.cos(angle)
            m[layout.BANK_SIN + j] = radius * np.sin(angle)
    again = m.copy()
    for frames in chunks:
        one_by_one(m, w, frames)
        at_once(again, again.view(np.int64), frames)
        np.testing.assert_array_equal(again.view(np.int64), w)
        sounding = any(left > sum(chunks) for _, _, left in kinds)
        assert m[layout.D_CLICK : layout.D_CLICK + frames].any() or not sounding
