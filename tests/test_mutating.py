"""The mutation run's own part: decorators as mutmut can change them, names, the plan."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def mutate():
    spec = importlib.util.spec_from_file_location("mutate", ROOT / "tools/mutate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SOURCE = """
import functools
from functools import cache

def doubled(function):
    return lambda *given: 2 * function(*given)

@doubled
def one():
    return 1

@functools.lru_cache(maxsize=3)
def two():
    '''Kept.'''
    return 2

@cache
def five():
    return 5

class Class:
    @property
    def three(self):
        return 3

    @three.setter
    def three(self, value):
        self.set = value

    @classmethod
    def four(cls):
        return 4
"""


def test_decorators_become_assignments_and_caches_go(mutate):
    changed = mutate.decorators_as_assignments(SOURCE)
    assert changed.count("@") == 1
    names = {}
    exec(changed, names)
    assert names["one"]() == 2
    assert names["two"]() == 2
    assert names["five"]() == 5
    assert not any(hasattr(names[name], "cache_info") for name in ("two", "five"))
    one = names["Class"]()
    one.three = 5
    assert (one.three, one.set) == (3, 5)
    assert names["Class"].four() == 4


def test_a_mutants_name_says_its_module_and_function(mutate):
    module = "overview_dsp/signal/surface/build.py"
    dotted = "overview_dsp.signal.surface.build"
    assert mutate.module_and_function(f"{dotted}.x__place__mutmut_12") == (module, "_place")
    assert mutate.module_and_function(f"{dotted}.xǁ_Placedǁof__mutmut_1") == (
        module,
        "_Placed.of",
    )


def test_what_the_plan_names_is_there_and_every_survivor_has_a_reason(mutate):
    plan = tomllib.loads((ROOT / "tools/mutation.toml").read_text())
    known = tomllib.loads((ROOT / "tools/surviving_mutants.toml").read_text())["mutant"]
    patterns = [pattern for part in plan["part"] for pattern in part["modules"]]
    modules = [module for pattern in patterns for module in mutate.matched(pattern)]
    assert len(set(modules)) == len(modules)
    tests = [test.partition("::") for part in plan["part"] for test in part["tests"]]
    assert all((ROOT / module).is_file() for module in modules)
    assert all((ROOT / file).exists() for file, _, _ in tests)
    assert all(f"def {name}(" in (ROOT / file).read_text() for file, _, name in tests if name)
    surface = {
        str(path.relative_to(ROOT)) for path in (ROOT / "overview_dsp/signal/surface").glob("*.py")
    }
    assert surface - {"overview_dsp/signal/surface/__init__.py"} <= set(modules)
    for one in known:
        assert one["module"] in modules
        assert one["was"] in " ".join((ROOT / one["module"]).read_text().split())
        assert len(one["why"]) > 10
