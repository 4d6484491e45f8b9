"""The reference's examples run, in a folder of their own, without a device."""

from __future__ import annotations

import doctest
import inspect

import pytest

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


@pytest.mark.parametrize("name", EXAMPLES := examples())
def test_an_example_shows_what_happens(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # where a threshold is kept
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    parsed = doctest.DocTestParser().get_doctest(EXAMPLES[name].__doc__, {}, name, None, 0)
    said = []
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(parsed, out=said.append)
    assert result.failed == 0, "".join(said)
