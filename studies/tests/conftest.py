from __future__ import annotations

from types import SimpleNamespace

import pytest

from tests.cli.running import overview


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """A study as the command line builds it, with simulated answers."""
    # not at the top: this file is read where the studies aren't installed, too
    from studies.tests.files import IDENTIFY, written

    home = tmp_path_factory.mktemp("built")
    # enough people for an interval
    toml = written(home, IDENTIFY.replace("participants = 4", "participants = 12"))
    folder, answers = home / "folder", home / "simulated.sqlite"
    outcome = overview("study", "build", toml, "-o", folder)
    assert outcome.code == 0, outcome.err
    outcome = overview(
        "study", "simulate", folder, "--d-prime", "3", "--effect", "mapping.static=-2",
        "-o", answers,
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    return SimpleNamespace(toml=toml, folder=folder, answers=answers)
