from __future__ import annotations

import os
from pathlib import Path

import pytest

from overview_dsp.web.static_site import write_site
from tests.web.browser import launched, opened_chromium, opened_driver, opened_firefox


@pytest.fixture(scope="session")
def driver():
    with opened_driver() as one:
        yield one


@pytest.fixture(scope="session")
def browser(driver):
    """A page with the kernel's modules."""
    with opened_chromium(driver) as page:
        yield page


@pytest.fixture(scope="session")
def chromium(driver):
    """A browser as people have it: a page sounds only after a touch."""
    with launched(driver) as one:
        yield one


@pytest.fixture(scope="session")
def firefox(tmp_path_factory):
    with opened_firefox(tmp_path_factory.mktemp("firefox")) as page:
        yield page


@pytest.fixture(scope="session")
def axe():
    folder = os.environ.get("OVERVIEW_AXE")
    if not folder or not (Path(folder) / "axe.min.js").is_file():
        pytest.skip("needs axe-core: npm install axe-core, and its folder in OVERVIEW_AXE")
    return (Path(folder) / "axe.min.js").read_text()


@pytest.fixture(scope="session")
def site(tmp_path_factory, match, springy_football):
    """A folder with the page of the match, whose disk is back in a second."""
    folder = tmp_path_factory.mktemp("export") / "site"
    write_site(match, springy_football, folder, levels=1)
    return folder
