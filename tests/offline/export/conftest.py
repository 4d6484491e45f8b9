from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.offline.export import plugin_bundle, plugins


@pytest.fixture
def unoptimised(monkeypatch):
    """Plugins compiled in a sixth of the time, for tests of their names and parameters.

    Their bits are those of optimised ones (test_c.py).
    """
    flags = tuple("-O0" if flag == "-O2" else flag for flag in plugins._FLAGS)
    assert flags != plugins._FLAGS
    monkeypatch.setattr(plugins, "_FLAGS", flags)


@pytest.fixture
def without_tails(monkeypatch):
    """Plugins whose tails are not measured, which takes seconds, for tests of their names."""
    monkeypatch.setattr(plugin_bundle, "_with_tails", lambda images, *given: images)


@pytest.fixture(scope="session", autouse=True)
def tails_measured_once(tmp_path_factory):
    """An image's tail is measured by the first build of it, for all files and workers.

    Tens of renders: most of a build's time. It depends on nothing but the image, an engine's
    whole memory.
    """
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "tails"
    folder.mkdir(exist_ok=True)
    measured = plugin_bundle._with_tails

    def known(images, timelines, presets, seed):
        pairs = [(timeline, preset) for timeline in timelines for preset in presets]
        for image, (timeline, preset) in zip(images, pairs, strict=True):
            path = folder / hashlib.sha256(image.data).hexdigest()
            if not path.exists():
                (one,) = measured([image], [timeline], [preset], seed)
                written = Path(f"{path}.{os.getpid()}")
                np.array([one.tail_s, one.tail_per_octave_s]).tofile(written)
                written.replace(path)
            tail_s, per_octave_s = np.fromfile(path).tolist()
            yield replace(image, tail_s=tail_s, tail_per_octave_s=per_octave_s)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plugin_bundle, "_with_tails", known)
        yield
