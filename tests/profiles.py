"""Hypothesis' profiles: `ci`, loaded, and `nightly` (`pytest --hypothesis-profile nightly`).

A test takes its number of examples from here, so that the long profile lengthens all of them.
"""

from __future__ import annotations

from hypothesis import settings


def load() -> None:
    """Register both and load `ci`; an option of pytest's loads another one over it."""
    # how long an example takes is the machine's, not the code's
    settings.register_profile("ci", max_examples=50, deadline=None)
    settings.register_profile("nightly", max_examples=1000, deadline=None)
    settings.load_profile("ci")


def share(part: float) -> int:
    """This part of the profile's examples, for a test each of whose examples plays or compiles."""
    return max(1, round(part * settings.default.max_examples))
