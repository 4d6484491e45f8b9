from __future__ import annotations

import pytest

from tests.web.browser import opened


@pytest.fixture(scope="session")
def browser():
    with opened() as page:
        yield page
