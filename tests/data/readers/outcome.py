"""The only two ways a reader may end."""

from __future__ import annotations

from collections.abc import Callable

from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError


def timeline_or_one_line(decode: Callable[[], Timeline]) -> Timeline | None:
    """Return the Timeline, or None if there was an InputError of one printable line instead.

    Any other exception, and any other return value, fails the test.
    """
    try:
        timeline = decode()
    except InputError as error:
        words = str(error)
    else:
        assert isinstance(timeline, Timeline)
        return timeline
    assert words.encode()
    assert words.count("\n") <= 1  # what is wrong; and how to mend it, where that needs a line
    return None
