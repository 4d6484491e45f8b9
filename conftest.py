"""Number of test workers, and a folder per example for `pytest --doctest-modules`.

The tests of the studies, a distribution of their own, are skipped where it is not installed.
"""

from __future__ import annotations

import gc
import importlib.util
import os
from pathlib import Path

import pytest

pytest_plugins = ["tests.web.browser_fixtures"]

STUDIES = Path(__file__).parent / "studies" / "tests"


class SkippedFolder(pytest.Dir):
    """A folder whose tests need what isn't installed."""

    def collect(self):
        """Skip them all."""
        pytest.skip("needs the studies: pip install ./studies")


def pytest_collect_directory(path, parent):
    """Collect the tests of the studies only where these are installed."""
    if path == STUDIES and importlib.util.find_spec("overview_studies") is None:
        return SkippedFolder.from_parent(parent, path=path)
    return None


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Leave what is collected out of Python's garbage collection.

    The collector would look through ten thousand tests again and again: a tenth of the time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """One more than there are cores: what plays waits for its sound more than it computes."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) + 1
    return (os.cpu_count() or 1) + 1


@pytest.fixture(autouse=True)
def _folder_of_examples(request, tmp_path_factory, monkeypatch):
    if type(request.node).__name__ == "DoctestItem":
        folder = tmp_path_factory.mktemp("example")
        monkeypatch.chdir(folder)
        # where a calibration is kept
        monkeypatch.setenv("XDG_CONFIG_HOME", str(folder))
