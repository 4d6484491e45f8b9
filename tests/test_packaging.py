from __future__ import annotations

import importlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import types
from pathlib import Path

import pytest

import overview_dsp as ov
from overview_dsp.kernels.compiling import NUMBA
from overview_dsp.live.output.portaudio_library import SOUNDDEVICE, import_sounddevice

ROOT = Path(__file__).resolve().parents[1]
LATE = (
    "numba", "llvmlite", "sounddevice", "serial", "matplotlib", "soundfile", "scipy", "vqf",
    "rtmidi", "pythonosc", "numpy", "pydantic", "pyarrow", "fsspec", "distributed", "dask",
    "asyncio",
)  # fmt: skip


def python(code: str, folder: Path, path: Path = ROOT, *arguments: str, **variables: str) -> str:
    """What a fresh interpreter prints that finds the package in `path` and stands in `folder`."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(path), **variables},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


SERVER = {
    f"overview_dsp.{name}"
    for name in (
        *("web.certificate", "web.control"),
        *("web.data", "web.live_data", "web.media", "web.static_publisher"),
        *("web.security.middleware", "web.server"),
    )
}
"""Modules that `overview serve` and its like import once they know that their extra is there."""

WITHOUT_EXTRAS = """
import importlib, json, pkgutil, sys
import overview_dsp

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in set(sys.argv[1:]):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Refuse())
failed = []
for module in pkgutil.walk_packages(overview_dsp.__path__, "overview_dsp."):
    try:
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    except ModuleNotFoundError:
        failed.append(module.name)
print(json.dumps(failed))
"""


def test_without_extras_all_but_the_server_can_be_imported(tmp_path):
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"][
        "optional-dependencies"
    ]
    asked = [re.split(r"[^\w.-]", line)[0] for lines in extras.values() for line in lines]
    modules = {name.replace("-", "_").lower() for name in asked} - {"overview_dsp"}
    modules |= {"h11", "pythonosc", "rtmidi", "hid", "dask", "starlette"}
    found = set(json.loads(python(WITHOUT_EXTRAS, tmp_path, ROOT, *sorted(modules))))
    assert found <= SERVER
    assert "overview_dsp.web.server" in found


FIND = """
import json, warnings
import overview_dsp as ov
warnings.simplefilter("error")
timeline = ov.load_timeline("world-cup-final-2018")
preset = ov.load_preset("football")
surface = ov.build_surface(timeline, preset)
print(json.dumps([ov.__file__, ov.bundled_presets(), timeline.title, surface.friction.sum()]))
"""


def test_importing_the_package_imports_nothing_heavy_and_no_device(tmp_path):
    names = json.loads(
        python("import sys, json, overview_dsp; print(json.dumps(list(sys.modules)))", tmp_path)
    )
    assert "overview_dsp" in names
    assert not {name.partition(".")[0] for name in names} & set(LATE)


def test_the_help_imports_nothing_that_only_commands_need(tmp_path):
    code = """
import json, sys
from overview_dsp.cli import main
sys.argv = ["overview", "--help"]
try:
    main()
except SystemExit:
    print(json.dumps(list(sys.modules)))
"""
    names = json.loads(python(code, tmp_path).splitlines()[-1])
    assert "click" in names
    assert not {name.partition(".")[0] for name in names} & set(LATE)


def test_packages_are_there_without_importing_them_one_by_one(tmp_path):
    code = "import overview_dsp as ov; print(ov.gestures.SOURCES[0], ov.presets.library.__name__)"
    assert python(code, tmp_path) == "touch overview_dsp.design.presets.library\n"


def test_a_timeline_a_preset_and_a_gesture_need_no_compiler(tmp_path):
    code = (
        "import sys\n"
        "for name in ('numba', 'sounddevice', 'serial', 'matplotlib'): sys.modules[name] = None\n"
        f"{FIND}\nov.parse_gesture('sweep:1+tap:0.5')\n"
    )
    assert "football" in python(code, tmp_path)


def test_rendering_needs_neither_a_sound_card_nor_a_serial_port(tmp_path):
    code = """
import sys
for name in ("sounddevice", "serial", "matplotlib"):
    sys.modules[name] = None
import overview_dsp as ov
timeline = ov.Timeline("t", 10.0, (ov.Event(5.0, "goal"),), None)
result = ov.render(timeline, ov.load_preset("football"), ov.tap(0.8, 0.1), 8000)
result.save("a.wav")
print(len(result.samples))
"""
    assert int(python(code, tmp_path)) > 800
    assert os.listdir(tmp_path) == ["a.wav"]


def test_every_public_name_is_there():
    for name in ov.__all__:
        assert getattr(ov, name) is not None
    assert len(set(ov.__all__)) == len(ov.__all__)
    assert dir(ov) == sorted(ov.__all__)


def test_the_public_names_are_the_contracts():
    wanted = (
        "load_timeline load_preset load_gesture sweep tap render Engine Timeline Preset Gesture"
    )
    assert set(wanted.split()) <= set(ov.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="rendr"):
        ov.rendr  # noqa: B018


def test_render_is_the_function_after_its_module_was_imported():
    importlib.import_module("overview_dsp.offline.rendering.offline")
    importlib.import_module("overview_dsp.signal.engine.engine")
    assert callable(ov.render)
    assert ov.render.__module__ == "overview_dsp.offline.rendering.offline"
    assert ov.Engine.__module__ == "overview_dsp.signal.engine.engine"


def test_the_package_says_that_it_is_typed():
    assert (Path(ov.__file__).parent / "py.typed").is_file()


def test_the_checkout_finds_its_presets_and_its_match_from_any_folder(tmp_path):
    where, names, title, _ = json.loads(python(FIND, tmp_path))
    assert Path(where).is_relative_to(ROOT)
    assert sorted(names) == sorted(path.stem for path in (ROOT / "presets").glob("*.toml"))
    assert title


@pytest.mark.parametrize(
    "missing",
    ["config.CACHE_DIR", "extending.register_model", "core.base.BaseContext.make_tuple"],
)
def test_a_numba_with_another_inside_is_one_clear_line(tmp_path, missing):
    code = f"""
import sys, numba, numba.core.base
del numba.{missing}
from overview_dsp.cli import main
sys.argv[1:] = "render world-cup-final-2018 --gesture tap:0.5:0.01".split()
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    wanted = rf"numba [\d.]+ has no numba\.{missing}; .*pip install '{re.escape(NUMBA)}'"
    assert re.search(wanted, done.stderr)
    assert os.listdir(tmp_path) == []


def test_a_sounddevice_with_another_inside_is_one_clear_line(monkeypatch):
    changed = types.ModuleType("sounddevice")
    changed._StreamBase = changed._initialize = object
    changed._ffi = types.SimpleNamespace(cast=None)
    monkeypatch.setitem(sys.modules, "sounddevice", changed)
    wanted = rf"sounddevice\._ffi\.dlopen; .*pip install '{re.escape(SOUNDDEVICE)}'"
    with pytest.raises(ov.OverviewError, match=wanted):
        import_sounddevice()


def dependencies():
    with (ROOT / "pyproject.toml").open("rb") as file:
        return tomllib.load(file)["project"]["dependencies"]


def test_the_versions_that_are_said_to_work_are_those_that_are_installed():
    assert {NUMBA, SOUNDDEVICE} <= set(dependencies())


RENDER = """
import hashlib, warnings
import overview_dsp as ov
warnings.simplefilter("ignore")
timeline = ov.load_timeline("world-cup-final-2018")
preset = ov.load_preset("football")
gesture = ov.parse_gesture("sweep:0.5+tap:0.7:0.2")
print(hashlib.sha256(ov.render(timeline, preset, gesture, tail="none").samples).hexdigest())
# side by side: numba's and llvmlite's inside
jobs = [ov.RenderJob(timeline, preset, gesture, seed) for seed in range(4)]
for one in ov.render_many(jobs, tail="none"):
    print(hashlib.sha256(one.samples).hexdigest())
"""


@pytest.mark.soak
def test_the_oldest_versions_that_are_allowed_render_the_same_bits(tmp_path):
    if os.environ.get("OVERVIEW_INSTALLS") != "1":
        pytest.skip("installs packages: set OVERVIEW_INSTALLS=1 where there is a package index")
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "old")], check=True)
    old = tmp_path / "old" / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [str(old), "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    oldest = [one.partition(",")[0].replace(">=", "==") for one in dependencies()]

    def install(*arguments):
        return subprocess.run([*pip, "--only-binary", ":all:", *arguments], check=False).returncode

    if install(*oldest):
        # newer than some of them, this Python has wheels of later ones only
        there = [
            one if install("--dry-run", "--no-deps", one) == 0 else allowed
            for one, allowed in zip(oldest, dependencies(), strict=True)
        ]
        assert install(*there) == 0, there
    renders = [
        subprocess.run(
            [python, "-c", RENDER],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        for python in (str(old), sys.executable)
    ]
    assert [done.returncode for done in renders] == [0, 0], renders[0].stderr
    assert renders[0].stdout == renders[1].stdout
    assert len(set(renders[0].stdout.splitlines())) >= 4


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder into which a wheel of this tree is installed."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("needs hatchling to build a wheel: pip install hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input"]
    for arguments in (
        ["wheel", str(ROOT), "--no-deps", "--no-build-isolation", "-w", str(folder)],
        ["install", "--no-deps", "--no-index", "--target", str(folder / "site")],
    ):
        wheels = [str(path) for path in folder.glob("*.whl")]
        done = subprocess.run(
            [*pip, *arguments, *wheels],
            capture_output=True,
            text=True,
            check=False,
            # in this checkout the build would find itself
            cwd=folder,
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


def test_a_wheel_finds_its_presets_and_its_match_from_any_folder(installed, tmp_path):
    where, names, title, friction = json.loads(python(FIND, tmp_path, installed))
    assert Path(where).is_relative_to(installed)
    checkout = json.loads(python(FIND, tmp_path))
    assert [names, title, friction] == checkout[1:]


def test_a_wheel_finds_its_actuators_from_any_folder(installed, tmp_path):
    code = """
import json
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
print(json.dumps([[name, load_actuator(name).source] for name in actuator_names()]))
"""
    found = json.loads(python(code, tmp_path, installed, OVERVIEW_ACTUATORS=str(tmp_path)))
    expected = sorted(path.stem for path in (ROOT / "actuators").glob("*.toml"))
    assert [name for name, _ in found] == expected
    assert all(Path(source).is_relative_to(installed) for _, source in found)


def test_a_wheel_has_what_the_page_loads(installed):
    for file in (ROOT / "overview_dsp" / "web").rglob("*"):
        if file.suffix in (".js", ".wasm", ".html", ".css") or file.name == "LICENSE.txt":
            assert (installed / file.relative_to(ROOT)).read_bytes() == file.read_bytes()


def test_a_wheel_finds_its_sensors_from_any_folder(installed, tmp_path):
    code = """
import json
from overview_dsp.devices.sensors.profile import LIBRARY, load_sensor
print(json.dumps([[name, load_sensor(name).source] for name in LIBRARY.bundled]))
"""
    found = json.loads(python(code, tmp_path, installed))
    assert [name for name, _ in found] == sorted(p.stem for p in (ROOT / "sensors").glob("*.toml"))
    assert all(Path(source).is_relative_to(installed) for _, source in found)


def test_a_wheel_has_the_firmware_of_the_checkout(installed, tmp_path):
    code = """
import json
from overview_dsp.devices.sensors.firmware import LIBRARY, firmware_names
print(json.dumps([str(LIBRARY.bundled_folder), firmware_names()]))
"""
    folder, names = json.loads(python(code, tmp_path, installed))
    assert Path(folder).is_relative_to(installed)
    assert names == sorted(one.name for one in (ROOT / "firmware").iterdir() if one.is_dir())


def test_a_wheel_has_the_command_line_and_renders(installed, tmp_path):
    assert (installed / "bin").is_dir() or (installed / "Scripts").is_dir()
    python(
        "import sys; sys.argv[1:] = 'render world-cup-final-2018 --gesture tap:0.5:0.01 "
        "--sample-rate 1000 --tail none'.split()\n"
        "from overview_dsp.cli import main\n"
        "main()",
        tmp_path,
        installed,
        # ten samples: compiling would take longer
        NUMBA_DISABLE_JIT="1",
    )
    assert os.listdir(tmp_path) == ["out.wav"]


def test_a_wheel_has_every_stub_and_a_missing_one_is_named(installed, tmp_path):
    stubs = [path.relative_to(ROOT) for path in (ROOT / "overview_dsp").rglob("*.pyi")]
    assert len(stubs) > 3
    for stub in stubs:
        assert (installed / stub).read_bytes() == (ROOT / stub).read_bytes()
    shutil.copytree(installed / "overview_dsp", tmp_path / "overview_dsp")
    (tmp_path / "overview_dsp" / "__init__.pyi").unlink()
    done = subprocess.run(
        [sys.executable, "-c", "import overview_dsp"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    line = done.stderr.strip().splitlines()[-1]
    assert line.startswith("ImportError: ")
    assert "__init__.pyi: No such file or directory; " in line
    assert line.endswith("reinstall overview-dsp")


def test_a_wheel_holds_the_package_and_nothing_else(installed):
    names = {path.name for path in installed.iterdir()} - {"bin", "Scripts"}
    assert len(names) == 2
    assert "overview_dsp" in names
    assert any(name.endswith(".dist-info") for name in names)
