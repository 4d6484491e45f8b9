"""Other people's data, where this machine has them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture
def statsbomb_folder() -> Path:
    """The folder of real StatsBomb files."""
    root = os.environ.get("OVERVIEW_TEST_DATA")
    if not root:
        pytest.skip("needs real StatsBomb files: set OVERVIEW_TEST_DATA to the test data folder")
    return Path(root) / "football" / "statsbomb"
