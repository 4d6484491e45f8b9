from __future__ import annotations

import pytest

from tests.web.browser import opened_chromium, opened_firefox


@pytest.fixture(scope="session")
def browser():
    with opened_chromium() as page:
        yield page


@pytest.fixture(scope="session")
def firefox(tmp_path_factory):
    with opened_firefox(tmp_path_factory.mktemp("firefox")) as page:
        yield page
