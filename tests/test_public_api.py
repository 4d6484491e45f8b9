"""What programs may rely on: the names, where they are found, what they say of themselves."""

from __future__ import annotations

import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import overview_dsp as ov
from tests.public_names import listed

FACES = {face.__name__: face for face in (ov.actuators, ov.export, ov.live, ov.measure, ov.presets)}


@pytest.mark.parametrize("module", [ov, *FACES.values()], ids=lambda module: module.__name__)
def test_what_a_face_lists_is_what_it_has(module):
    assert dir(module) == sorted(module.__all__)
    assert len(set(module.__all__)) == len(module.__all__)
    for name in module.__all__:
        assert getattr(module, name) is not None


@pytest.mark.parametrize("face", FACES.values(), ids=lambda face: face.__name__)
def test_no_module_would_take_the_place_of_a_public_name_when_it_is_imported(face):
    modules = {module.name for module in pkgutil.iter_modules(face.__path__)}
    assert not modules & set(face.__all__)


def test_no_public_name_comes_or_goes_unnoticed():
    kept = Path(__file__).with_name("public_names.txt").read_text(encoding="utf-8")
    # python -m tests.public_names > tests/public_names.txt, and a line in the changelog
    assert listed() == kept


def test_the_faces_are_the_only_modules_among_the_public_names():
    modules = [name for name in ov.__all__ if isinstance(getattr(ov, name), ModuleType)]
    assert modules == ["actuators", "export", "live", "measure", "presets"]


def test_a_name_that_two_faces_have_is_one_thing():
    assert ov.presets.load is ov.load_preset
    assert ov.presets.bundled is ov.bundled_presets
    assert ov.presets.Preset is ov.Preset
    assert ov.actuators.load is ov.load_actuator
    assert ov.actuators.Actuator is ov.Actuator


def fresh(code):
    """What a new interpreter prints; warnings are errors in it."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("face", ["presets", "actuators", "live", "measure", "export"])
def test_a_face_is_imported_without_a_compiler_or_a_device(face):
    code = f"""
import sys
for name in ("numba", "sounddevice", "serial", "rtmidi", "scipy", "matplotlib"):
    sys.modules[name] = None
import overview_dsp as ov
print(ov.{face}.__name__)
"""
    assert fresh(code).endswith(f".{face}\n")


def test_the_names_of_live_are_there_without_portaudio():
    code = """
import sys
sys.modules["sounddevice"] = None
import overview_dsp as ov
print(all(hasattr(ov.live, name) for name in ov.live.__all__))
"""
    assert fresh(code) == "True\n"


@pytest.mark.parametrize("module", [ov, ov.timeline, *FACES.values()], ids=lambda m: m.__name__)
def test_a_name_that_never_was_is_an_attribute_error(module):
    with pytest.raises(AttributeError, match="rendr"):
        module.rendr  # noqa: B018


def test_the_error_tree_is_drawn_as_it_is():
    from overview_dsp import errors
    from overview_dsp.live.ports.port import PortLostError

    drawn = dict(re.findall(r"── (\w+Error) .* (\d)$", errors.__doc__, re.M))
    classes = {"PortLostError": PortLostError, **vars(errors)}
    assert {name: classes[name].exit_code for name in drawn} == {
        name: int(code) for name, code in drawn.items()
    }
    assert set(drawn) == {
        "OverviewError", "InputError", "OutputError", "NotPreparedError", "PortLostError"
    }  # fmt: skip
    assert all(issubclass(classes[name], errors.OverviewError) for name in drawn)
    assert issubclass(errors.InputError, ValueError)
    assert issubclass(errors.NotPreparedError, RuntimeError)
    assert issubclass(errors.OverviewWarning, UserWarning)
