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
    """Lists the tests that were skipped, as `pytest @FILE` takes them.

    One that ran with other parameters is named with its own. One that never ran is named without:
    with what it needs, its parameters may be others.
    """

    def __init__(self, path):
        self.path, self.skipped, self.ran = Path(path), {}, set()

    def pytest_runtest_logreport(self, report):
        function = report.nodeid.partition("[")[0]
        if report.skipped and not hasattr(report, "wasxfail"):
            self.skipped[report.nodeid] = function
        elif report.when == "call":
            self.ran.add(function)

    def pytest_collectreport(self, report):
        if report.skipped:
            self.skipped[report.nodeid] = report.nodeid

    def pytest_sessionfinish(self):
        names = {name if of in self.ran else of: None for name, of in self.skipped.items()}
        self.path.write_text("".join(f"{name}\n" for name in names), encoding="utf-8")


def pytest_configure(config):
    # a shell ignores SIGINT for what it starts in the background, nohup SIGHUP: the commands that
    # tests start and end by signals would inherit that
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if os.name == "posix" and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
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
def rigid_football():
    """Football whose disk is pulled at once, where a tap would unfold over two seconds."""
    return ov.load_preset("football").with_value("clutch.max_speed_ratio", 0.0)


@pytest.fixture(scope="session")
def springy_football(football):
    """Football with a disk that is back in a second."""
    return football.with_value("disk.k1", 5.0 * football.number("disk.k1"))


@pytest.fixture(scope="session")
def springy_file(tmp_path_factory, springy_football):
    """The same in a file: a session lasts as long as its disk."""
    path = tmp_path_factory.mktemp("springy") / "springy.toml"
    ov.presets.save(springy_football, path)
    return path


@pytest.fixture(scope="session")
def data_folder():
    """Other people's data, which the project may not contain."""
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs other people's data: set OVERVIEW_TEST_DATA to its folder")
    return Path(folder)
