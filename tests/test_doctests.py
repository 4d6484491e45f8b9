"""The reference's examples run, in a folder of their own, without a device.

A page or a module says all that it needs. The example of a function or a class begins where the
reference's first page ends: with `np`, `ov`, `match`, `football`, `plain`, and `engine`, which is
made and prepared anew for each.
"""

from __future__ import annotations

import doctest
import inspect

import numpy as np
import pytest

import overview_dsp as ov
from tests.public_names import FACES, members, public_objects


def examples():
    found = dict(FACES)
    for name, value in public_objects().items():
        found[name] = value
        if inspect.isclass(value):
            own = members(value).items()
            # what several classes have from one base, once
            found |= {f"{name}.{key}": one for key, one in own if one not in found.values()}
    return {name: value for name, value in found.items() if ">>>" in (value.__doc__ or "")}


@pytest.fixture(scope="module")
def known():
    return {
        "np": np,
        "ov": ov,
        "match": ov.load_timeline("world-cup-final-2018"),
        "football": ov.load_preset("football"),
        "plain": ov.load_preset("plain"),
    }


def given(known, text):
    names = dict(known)
    if "engine." in text and "engine = " not in text:
        names["engine"] = ov.Engine(names["football"], names["match"])
        names["engine"].prepare(sample_rate=8000, max_block_size=256)
    return names


@pytest.mark.parametrize("name", EXAMPLES := examples())
def test_an_example_shows_what_happens(name, known, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # where a threshold is kept
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    text = EXAMPLES[name].__doc__
    names = {} if inspect.ismodule(EXAMPLES[name]) else given(known, text)
    parsed = doctest.DocTestParser().get_doctest(text, names, name, None, 0)
    said = []
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(parsed, out=said.append)
    assert result.failed == 0, "".join(said)
