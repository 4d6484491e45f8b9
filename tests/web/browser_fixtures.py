"""One browser for all pages of a worker, of the studies too: two drivers in a process clash."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def driver():
    from tests.web.browser import opened_driver

    with opened_driver() as one:
        yield one


@pytest.fixture(scope="session")
def chromium(driver):
    """A browser as people have it: a page sounds only after a touch."""
    from tests.web.browser import launched

    with launched(driver) as one:
        yield one


@pytest.fixture(scope="session")
def axe():
    folder = os.environ.get("OVERVIEW_AXE")
    if not folder or not (Path(folder) / "axe.min.js").is_file():
        pytest.skip("needs axe-core: npm install axe-core, and its folder in OVERVIEW_AXE")
    return (Path(folder) / "axe.min.js").read_text()
