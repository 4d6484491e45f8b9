from __future__ import annotations

import pytest

from overview_dsp.web.static_site import write_site
from tests.web.browser import opened_chromium, opened_firefox


@pytest.fixture(scope="session")
def browser(driver):
    """A page with the kernel's modules."""
    with opened_chromium(driver) as page:
        yield page


@pytest.fixture(scope="session")
def firefox(tmp_path_factory):
    with opened_firefox(tmp_path_factory.mktemp("firefox")) as page:
        yield page


@pytest.fixture(scope="session")
def site(tmp_path_factory, match, springy_football):
    """A folder with the page of the match, whose disk is back in a second."""
    folder = tmp_path_factory.mktemp("export") / "site"
    write_site(match, springy_football, folder, levels=1)
    return folder
