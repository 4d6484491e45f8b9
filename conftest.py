"""For `pytest --doctest-modules`: each example runs in a folder of its own."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _folder_of_examples(request, tmp_path_factory, monkeypatch):
    if type(request.node).__name__ == "DoctestItem":
        folder = tmp_path_factory.mktemp("example")
        monkeypatch.chdir(folder)
        # where a calibration is kept
        monkeypatch.setenv("XDG_CONFIG_HOME", str(folder))
