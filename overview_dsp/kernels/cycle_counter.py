"""A chain of operations that wait for each other, to count a processor's cycles by.

Thread: main.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import entry_point
from overview_dsp.kernels.noise import next_state

CYCLES_A_LINK = 6  # three shifts and three exclusive ors, of one cycle each on x86


@entry_point
def chain(word, links):
    """A uint64 that isn't known before so many links have been gone through."""
    for _ in range(links):
        word = next_state(word)
    return word
