from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

import overview_dsp as ov
from tests import profiles

profiles.load()


def pytest_addoption(parser):
    parser.addoption("--list-skipped", metavar="FILE", help="write the skipped tests to a file")


class SkippedTests:
    """Lists the tests that were skipped, without their parameters: those may be others then."""

    def __init__(self, path):
        self.path, self.names = Path(path), {}

    def note(self, report):
        if report.skipped and not hasattr(report, "wasxfail"):
            self.names[report.nodeid.partition("[")[0]] = None

    pytest_runtest_logreport = note
    pytest_collectreport = note

    def pytest_sessionfinish(self):
        self.path.write_text("".join(f"{name}\n" for name in self.names))


def pytest_configure(config):
    # a shell ignores SIGINT for what it starts in the background, and the commands that tests
    # start and interrupt would inherit that
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    path = config.getoption("--list-skipped")
    if path and not hasattr(config, "workerinput"):
        config.pluginmanager.register(SkippedTests(path))


@pytest.fixture(scope="session")
def match():
    """The bundled match."""
    return ov.load_timeline("world-cup-final-2018")


@pytest.fixture(scope="session")
def football():
    return ov.load_preset("football")


@pytest.fixture(scope="session")
def springy_file(football, tmp_path_factory):
    """Football in a file, with a disk that is back in a second: a session lasts as long as it."""
    path = tmp_path_factory.mktemp("springy") / "springy.toml"
    ov.presets.save(football.with_value("disk.k1", 5.0 * football.number("disk.k1")), path)
    return path


@pytest.fixture(scope="session")
def data_folder():
    """Other people's data, which the project may not contain."""
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs other people's data: set OVERVIEW_TEST_DATA to its folder")
    return Path(folder)
