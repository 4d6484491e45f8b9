"""How tests drive the page: sizes, waiting, where a position is.

A page's policy forbids what playwright's own `wait_for_function` needs, so conditions are polled.
"""

from __future__ import annotations

import os
import time
from typing import Any

import pytest

PHONE = {"width": 390, "height": 844}
DESKTOP = {"width": 1280, "height": 800}
PATIENCE_S = 40.0
not_in_firefox = pytest.mark.skipif(
    os.environ.get("OVERVIEW_BROWSER") == "firefox",
    reason="in Firefox playwright has no touch, sensors or downloads, and evaluates as a user",
)


def until(page: Any, condition: str) -> None:
    """Wait for a JavaScript expression; `p` is the page's object."""
    end = time.monotonic() + PATIENCE_S
    # a function, since only what is sent as one may be evaluated under the policy
    asked = f"async () => {{ const p = window.overview; return Boolean(p && ({condition})); }}"
    while not page.evaluate(asked):
        if time.monotonic() > end:
            fault = page.text_content("#fault")
            raise AssertionError(f"waited in vain for {condition}; the page says {fault!r}")
        page.wait_for_timeout(20)


def watch(page: Any, position: float, starts: list[float]) -> None:
    """Keep how near the disk comes to a position, `nearest`, and its `furthest` from the start.

    A disk that arrives after a release recoils at once, between two looks at the page. No strike
    is missed: the disk was where the event that it struck starts, at `starts`.
    """
    page.evaluate(
        """([position, starts]) => {
            window.nearest = 1;
            window.furthest = 0;
            const take = overview.update.bind(overview);
            overview.update = (state) => {
                const struck = state.newStrikes.map(({ event }) => starts[event]);
                for (const at of [state.cursor, ...struck]) {
                    nearest = Math.min(nearest, Math.abs(at - position));
                    furthest = Math.max(furthest, at);
                }
                take(state);
            };
        }""",
        [position, starts],
    )


def at(page: Any, position: float) -> tuple[float, float]:
    """Where a position of the timeline is on the screen."""
    box = page.locator("#canvas").bounding_box()
    left, right = page.evaluate("[overview.picture.geometry.left, overview.picture.geometry.right]")
    return box["x"] + left + (right - left) * position, box["y"] + 120


def violations(page: Any, axe: str) -> list[tuple[str, str]]:
    """What axe-core finds: rules, and the first element of each."""
    found = page.evaluate(axe + "\n;axe.run().then(({violations}) => violations)")
    return [(one["id"], one["nodes"][0]["html"]) for one in found]
