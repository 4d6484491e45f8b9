from __future__ import annotations

import pytest

from overview_dsp.offline.export import c_code


@pytest.fixture
def unoptimised(monkeypatch):
    """Plugins compiled in a sixth of the time, for tests of their names and parameters.

    Their bits are those of optimised ones (test_c.py).
    """
    flags = tuple("-O0" if flag == "-O2" else flag for flag in c_code._FLAGS)
    assert flags != c_code._FLAGS
    monkeypatch.setattr(c_code, "_FLAGS", flags)
