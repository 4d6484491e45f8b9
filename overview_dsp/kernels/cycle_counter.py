"""Cycle counter: a chain of dependent operations with a known number of cycles.

Thread: main.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import entry_point
from overview_dsp.kernels.noise import next_state

CYCLES_PER_LINK = 6  # three shifts and three exclusive ors, of one cycle each on x86


@entry_point
def chain(word, links):
    """Return a uint64 that depends on `links` sequential steps."""
    for _ in range(links):
        word = next_state(word)
    return word
