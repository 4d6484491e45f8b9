from __future__ import annotations

from importlib import metadata
from pathlib import Path

import pytest

from overview_dsp import installation
from overview_dsp.installation import install_command
from tests.docs.markdown_blocks import ROOT


def test_in_a_checkout_pip_gets_the_working_folder(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert install_command("ecg") == "pip install '.[ecg]'"


def test_in_any_other_folder_pip_gets_the_path_of_the_checkout(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert install_command("ecg") == f"pip install '{ROOT}[ecg]'"


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """A copy in a folder without a source tree; gives the setter of its `direct_url.json`."""
    monkeypatch.setattr(installation, "__file__", str(tmp_path / "lib" / "p" / "installation.py"))

    class Distribution:
        record: str | None = None

        def read_text(self, name: str) -> str | None:
            assert name == "direct_url.json"
            return self.record

    monkeypatch.setattr(metadata, "distribution", lambda name: Distribution())
    return lambda record: monkeypatch.setattr(Distribution, "record", record)


def test_an_installed_copy_is_extended_from_its_source(installed, tmp_path):
    clone = tmp_path / "a clone"
    clone.mkdir()
    (clone / "pyproject.toml").touch()
    installed(f'{{"url": "{clone.as_uri()}", "dir_info": {{}}}}')
    assert install_command("web") == f"pip install '{clone}[web]'"


def test_an_installed_wheel_is_extended_from_its_file(installed, tmp_path):
    wheel = Path(tmp_path, "overview_dsp-1-py3-none-any.whl")
    installed(f'{{"url": "{wheel.as_uri()}", "archive_info": {{}}}}')
    assert install_command("web") == f"pip install '{wheel}[web]'"


@pytest.mark.parametrize("record", [None, "{}", "not JSON", '{"url": "file:///nowhere/at/all"}'])
def test_without_a_known_source_pip_runs_in_a_clone(installed, record):
    installed(record)
    assert install_command("web") == "pip install '.[web]' in a clone of the project"
