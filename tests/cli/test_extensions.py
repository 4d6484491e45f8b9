"""Commands of other distributions: listed, imported when called, and what they may use."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import subprocess
import sys
from pathlib import Path

import pytest

from overview_dsp.cli import COMMANDS, GROUP, SEPARATE_COMMANDS, added_commands, extensions
from tests.cli.running import environment, overview, refused

COMMAND = """
import click

@click.command(epilog="Example: overview stir soup")
@click.argument("what")
def command(what):
    click.echo(f"stirred {what}")
"""


@pytest.fixture
def other(tmp_path, monkeypatch):
    """A function that installs a distribution with the command `stir` for this test."""
    site = tmp_path / "site"

    def install(code: str, name: str = "stir", summary: str = "Stir what is given.") -> None:
        site.mkdir()
        (site / "stirring_of_a_test.py").write_text(code)
        info = site / "stirring-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: stirring\nVersion: 1.0\nSummary: {summary}\n"
        )
        (info / "entry_points.txt").write_text(f"[{GROUP}]\n{name} = stirring_of_a_test:command\n")

    monkeypatch.syspath_prepend(str(site))
    yield install
    sys.modules.pop("stirring_of_a_test", None)


@pytest.fixture
def alone(monkeypatch):
    """No other distribution is installed."""
    monkeypatch.setattr("overview_dsp.cli.added_commands", dict)


def test_a_command_of_another_distribution_runs_with_its_help(other):
    other(COMMAND)
    outcome = overview("stir", "soup")
    assert (outcome.code, outcome.out) == (0, "stirred soup\n")
    assert overview("stir", "--help").out.startswith("Usage: overview stir ")
    refused(overview("stirr", "soup"), "stirr", "did you mean 'stir'")


def test_help_lists_an_extension_command_without_importing_it(other):
    other(COMMAND)
    lines = overview("--help").out.splitlines()
    assert "  stir       Stir what is given." in lines
    assert "stirring_of_a_test" not in sys.modules


def test_a_command_of_this_package_cannot_be_replaced(other):
    other(COMMAND, name="devices")
    assert "Usage: overview devices " in overview("devices", "--help").out
    assert "stir what" not in overview("--help").out.lower()


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import nothing_like_it", "No module named 'nothing_like_it'"),
        ("other = 1", "no attribute 'command'"),
        ("command = print", "not a click.Command"),
    ],
)
def test_a_broken_extension_command_gives_a_one_line_error_that_names_its_distribution(
    other, code, said
):
    other(code)
    refused(overview("stir", "soup"), "the command stir of stirring", said)
    assert "stir" in overview("--help").out


@pytest.mark.parametrize("name", SEPARATE_COMMANDS)
@pytest.mark.parametrize("more", [(), ("--help",), ("check", "x.toml")])
def test_what_is_installed_apart_gives_a_one_line_error_that_says_how(alone, name, more):
    refused(overview(name, *more), f"overview {name}", "pip install ./")


@pytest.mark.parametrize("name", SEPARATE_COMMANDS)
def test_what_is_installed_apart_is_listed_and_suggested(alone, name):
    line = next(line for line in overview("--help").out.splitlines() if line.split()[:1] == [name])
    assert "Not installed" in line
    refused(overview(f"{name}x"), f"did you mean {name!r}")


def test_a_command_of_this_package_asks_for_no_others():
    """What is installed takes time to look through."""
    code = (
        "import sys; sys.argv = ['overview', 'timeline', '--help']\n"
        "from overview_dsp.cli import main\n"
        "sys.modules['importlib.metadata'] = None\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment(), check=False)
    assert done.returncode == 0


def test_every_name_of_the_list_is_there_and_described():
    names = extensions.__all__
    assert len(names) > 30
    described = inspect.getdoc(extensions)
    for name in names:
        assert f"`{name}`" in described, name
    stub = ast.parse(Path(extensions.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    homes = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    for name, module in ((one.asname, node.module) for node in homes for one in node.names):
        if name is not None:
            assert getattr(extensions, name) is getattr(importlib.import_module(module), name)
    assert extensions.plot_style.new_figure
    with pytest.raises(AttributeError, match="sho"):
        extensions.sho  # noqa: B018


def test_importing_the_names_imports_no_module():
    code = (
        "import sys, json\nfrom overview_dsp.cli import extensions\n"
        "print(json.dumps([m for m in sys.modules if m.startswith('overview_dsp.')]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment()
    )
    own = {name for name in json.loads(done.stdout) if name.startswith("overview_dsp.cli.")}
    assert own == {"overview_dsp.cli.extensions", "overview_dsp.cli.signals"}


def test_no_command_is_listed_twice():
    assert not set(COMMANDS) & set(SEPARATE_COMMANDS)
    assert not set(COMMANDS) & set(added_commands())
