"""The distribution: what its wheel holds, what it requires, and the command that it adds."""

from __future__ import annotations

import importlib
import importlib.util
import json
import pkgutil
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest

import overview_dsp as ov
import overview_studies
from overview_studies.cli import command, learn
from tests.cli.commands import commands
from tests.cli.running import overview
from tests.test_packaging import WITHOUT_EXTRAS, python

STUDIES = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((STUDIES / "pyproject.toml").read_text(encoding="utf-8"))["project"]
COMMANDS = {("study", *words): one for words, one in commands(command).items()}
COMMANDS[("learn",)] = learn.command


def test_it_is_of_the_packages_version_and_requires_it():
    assert PROJECT["version"] == ov.__version__
    assert f"overview-dsp=={ov.__version__}" in PROJECT["dependencies"]
    assert PROJECT["optional-dependencies"]["web"] == [f"overview-dsp[web]=={ov.__version__}"]


def test_the_list_of_commands_has_it():
    for name in PROJECT["entry-points"]["overview_dsp.commands"]:
        lines = overview("--help").out.splitlines()
        line = next(line for line in lines if line.startswith(f"  {name} "))
        assert line.split(None, 1)[1] == PROJECT["description"]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_commands_help_has_a_worked_example_and_a_json_option(words):
    outcome = overview(*words, "--help")
    assert outcome.code == 0
    assert outcome.out.startswith(f"Usage: overview {' '.join(words)} ")
    assert f"Example: overview {words[0]}" in " ".join(outcome.out.split())
    if not isinstance(COMMANDS[words], click.Group):
        assert "--json" in outcome.out


def test_without_a_server_all_but_its_routes_can_be_imported(tmp_path):
    """And the type checker's list of what the package gives is enough at run time."""
    code = WITHOUT_EXTRAS.replace("overview_dsp", "overview_studies")
    refused = ("starlette", "uvicorn", "websockets", "cryptography", "segno", "pyarrow", "fsspec")
    found = json.loads(python(code, tmp_path, tmp_path, *refused))
    assert found == ["overview_studies.lesson_routes", "overview_studies.routes"]


def test_every_module_can_be_imported():
    pytest.importorskip("starlette", reason="needs pip install '.[web]'")
    for module in pkgutil.walk_packages(overview_studies.__path__, "overview_studies."):
        importlib.import_module(module.name)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder into which a wheel of this folder is installed."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("needs hatchling to build a wheel: pip install hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input"]
    build = ["wheel", str(STUDIES), "--no-deps", "--no-build-isolation", "-w", str(folder)]
    subprocess.run([*pip, *build], check=True, capture_output=True, cwd=folder)
    wheels = [str(path) for path in folder.glob("*.whl")]
    put = ["install", "--no-deps", "--no-index", "--target", str(folder / "site"), *wheels]
    subprocess.run([*pip, *put], check=True, capture_output=True, cwd=folder)
    return folder / "site"


def test_a_wheel_holds_the_page_the_licences_and_nothing_else(installed):
    for page in ("page", "lesson_page"):
        files = [
            path for path in (STUDIES / "overview_studies" / page).rglob("*") if path.is_file()
        ]
        assert files
        for file in files:
            place = installed / file.relative_to(STUDIES)
            assert place.read_bytes() == file.read_bytes()
    (info,) = installed.glob("*.dist-info")
    assert {path.name for path in installed.iterdir()} == {"overview_studies", info.name}
    assert (info / "licenses" / "LICENSE").is_file()
    assert (installed / "overview_studies" / "py.typed").is_file()


def test_a_wheel_adds_the_command(installed, tmp_path):
    code = (
        "import overview_studies, sys; print(overview_studies.__file__)\n"
        "sys.argv[1:] = ['study', 'check', '--help']\n"
        "from overview_dsp.cli import main\n"
        "main()"
    )
    where, *shown = python(code, tmp_path, installed).splitlines()
    assert Path(where).is_relative_to(installed)
    assert shown[0].startswith("Usage: overview study check ")
