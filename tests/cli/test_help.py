from __future__ import annotations

import click
import pytest

import overview_dsp as ov
from overview_dsp.cli import COMMANDS, app
from tests.cli.running import overview, overview_process, refused


def commands(
    group: click.Group, path: tuple[str, ...] = ()
) -> dict[tuple[str, ...], click.Command]:
    """Every command by its words, groups too."""
    found: dict[tuple[str, ...], click.Command] = {}
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        found[*path, name] = command
        if isinstance(command, click.Group):
            found |= commands(command, (*path, name))
    return found


ALL = commands(app)

PRINTS_JSON = {("play",), ("feed",), ("presets", "schema")}
"""What they print is JSON already, or on request: `--screen json`."""


def test_the_help_lists_every_command_with_a_sentence():
    outcome = overview("--help")
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out.startswith("Usage: overview ")
    for name, (_, sentence) in COMMANDS.items():
        line = next(line for line in outcome.out.splitlines() if line.split()[:1] == [name])
        assert sentence.split()[0] in line


def test_listing_the_commands_imports_none_of_them():
    code = (
        "import sys; sys.argv = ['overview', '--help']\n"
        "from overview_dsp.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print([m for m in sys.modules if m.startswith('overview_dsp.cli.')], file=sys.stderr)\n"
    )
    import subprocess
    import sys

    from tests.cli.running import environment

    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment()
    )
    # what ends any of them isn't one
    assert done.stderr.strip() == "['overview_dsp.cli.signals']"


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_commands_help_has_a_worked_example(words):
    outcome = overview(*words, "--help")
    assert outcome.code == 0
    assert outcome.out.startswith(f"Usage: overview {' '.join(words)} ")
    assert f"Example: overview {words[0]}" in " ".join(outcome.out.split())


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_command_that_reports_has_a_json_option(words):
    if isinstance(ALL[words], click.Group):
        pytest.skip("a group reports nothing itself")
    shown = overview(*words, "--help").out
    if words in PRINTS_JSON:
        assert "--json" not in shown
        assert "JSON" in shown
    else:
        assert "--json" in shown


@pytest.mark.parametrize(("name", "most"), [("play", 28), ("serve", 31)])
def test_the_options_of_a_live_command_stand_under_headings(name, most):
    command = ALL[name,]
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert 20 < len(options) <= most
    lines = overview(name, "--help").out.splitlines()
    headings = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert headings[:3] == ["Data:", "Preset:", "Live data:"]
    assert headings[-1] == "Options:"  # --help alone
    assert lines[lines.index("Options:") + 1].split()[0] == "-h,"
    assert len(headings) <= 9


def test_one_name_is_one_option_in_all_commands():
    """The same name has the same kind of value everywhere, and `-o` is always an output."""
    kinds: dict[str, dict[str, list[tuple[str, ...]]]] = {}
    for words, command in ALL.items():
        for option in command.params:
            if isinstance(option, click.Option):
                values = "flag" if option.is_flag else option.type.name.removesuffix(" range")
                values = {"file": "text", "directory": "text"}.get(values, values)
                kinds.setdefault(option.opts[-1], {}).setdefault(values, []).append(words)
                assert ("-o" in option.opts) == ("--output" in option.opts), words
    assert not {name: found for name, found in kinds.items() if len(found) > 1}


@pytest.mark.parametrize("words", [(), ("presets",)], ids=["overview", "presets"])
def test_a_group_without_a_command_shows_its_help(words):
    outcome = overview(*words)
    assert outcome.code == 2
    shown = outcome.out + outcome.err
    assert shown.startswith(f"Usage: {' '.join(('overview', *words))} ")
    assert len(shown.splitlines()) > 5


def test_the_version_is_the_packages():
    assert overview("--version").out == f"overview {ov.__version__}\n"


def test_an_unknown_command_or_option_is_one_line_that_points_to_the_help():
    refused(overview("rendr"), "rendr", "overview --help")
    refused(overview("render", "x", "--gestur", "tap:1"), "--gestur", "overview render --help")
    refused(overview("render"), "TIMELINE", "overview render --help")
    refused(overview("render", "x", "--seed", "many"), "--seed", "many")


def test_python_m_is_the_same_program():
    assert overview_process("--version").out == f"overview {ov.__version__}\n"


def test_debug_shows_the_traceback():
    outcome = overview_process("--debug", "presets", "show", "nothing-like-it")
    assert "Traceback" in outcome.err
    assert "InputError" in outcome.err
    refused(overview_process("presets", "show", "nothing-like-it"), "nothing-like-it")
