from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

import overview_dsp as ov

# how long an example takes is the machine's, not the code's
settings.register_profile("overview", deadline=None)
settings.load_profile("overview")


@pytest.fixture(scope="session")
def match():
    """The bundled match."""
    return ov.load_timeline("world-cup-final-2018")


@pytest.fixture(scope="session")
def football():
    return ov.load_preset("football")


@pytest.fixture(scope="session")
def data_folder():
    """Other people's data, which the project may not contain."""
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs other people's data: set OVERVIEW_TEST_DATA to its folder")
    return Path(folder)
