from __future__ import annotations

import pytest

import overview_dsp as ov
from overview_dsp.kernels import precompiled
from overview_dsp.signal.engine import coefficients
from overview_dsp.signal.engine.coefficients import announce_compile
from tests.examples import plain_preset, timeline_of


@pytest.fixture(autouse=True)
def _nothing_announced(monkeypatch):
    monkeypatch.setattr(coefficients, "_announced", set())


@pytest.mark.parametrize("outdated", [False, True])
def test_a_first_compilation_is_announced_once_on_stderr(tmp_path, monkeypatch, capsys, outdated):
    """Where no machine code is shipped for a processor, or it is of other sources."""
    monkeypatch.setattr(precompiled, "usable", lambda kernel: None)
    monkeypatch.setattr(coefficients, "is_outdated", lambda: outdated)
    engine = ov.Engine(plain_preset(), timeline_of())
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    engine.prepare()
    engine.prepare()
    announce_compile("process")
    said = capsys.readouterr()
    assert said.out == ""
    assert len(said.err.splitlines()) == 1
    assert "compiling" in said.err
    assert ("build_kernels.py" in said.err) == outdated


def test_nothing_is_announced_where_nothing_will_be_compiled(capsys):
    ov.render(timeline_of(), plain_preset(), ov.tap(0.2, 0.01), 1000, tail="none")
    capsys.readouterr()
    announce_compile("process")
    assert capsys.readouterr().err == ""
