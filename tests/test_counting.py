"""The instruction log: read back, grown counts found."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[1] / "tools"


@pytest.fixture
def counting(monkeypatch, tmp_path):
    spec = importlib.util.spec_from_file_location("counting", TOOLS / "count_instructions.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "LOG", tmp_path / "instructions.txt")
    monkeypatch.setattr(module.shutil, "which", lambda name: name)
    monkeypatch.setattr(module, "HEADER", tmp_path)
    monkeypatch.setattr(module.Path, "is_file", lambda self: True)
    return module


def test_the_log_names_every_work_and_its_last_count(counting, monkeypatch):
    monkeypatch.setattr(counting, "LOG", TOOLS / "instructions.txt")
    logged = counting.last_counts()
    assert "viscous, one call" in logged
    assert all(100.0 < count < 10_000.0 for count in logged.values())


def test_a_count_that_grew_fails_until_a_line_says_why(counting, monkeypatch, capsys):
    counts = {"a work": 100.0, "another": 200.0}
    monkeypatch.setattr(counting, "counted", lambda: counts)
    assert counting.main(None) == 1  # not in the log
    assert counting.main("the first count") == 0
    counts["a work"] = 102.9
    assert counting.main(None) == 0
    counts["a work"] = 103.1
    assert counting.main(None) == 1
    assert "a work" in capsys.readouterr().out.splitlines()[-1]
    assert counting.main("bought something") == 0
    assert counting.main(None) == 0
    lines = counting.LOG.read_text().splitlines()
    assert len(lines) == 3
    assert "bought something" in lines[-1]


def test_without_valgrind_it_says_so_and_passes(counting, monkeypatch, capsys):
    monkeypatch.setattr(counting.shutil, "which", lambda name: None)
    assert counting.main(None) == 0
    assert "valgrind" in capsys.readouterr().out
