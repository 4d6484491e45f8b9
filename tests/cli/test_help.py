from __future__ import annotations

import importlib.util
import os
import re

import click
import pytest

import overview_dsp as ov
from overview_dsp.cli import COMMANDS
from overview_dsp.cli.options.declaring import MAX_OPTIONS, GroupedCommand, GroupOption
from tests.cli.commands import ALL
from tests.cli.running import ROOT, overview, overview_process, refused
from tests.docs.markdown_blocks import PAGES, blocks_of

REFERENCE = ROOT / "docs" / "reference" / "cli.md"
SCREEN_LINES = 40

PRINTS_JSON = {("play",), ("feed",), ("presets", "schema")}
"""What they print is JSON already, or on request: `--screen json`."""


def test_the_help_lists_every_command_with_a_sentence():
    outcome = overview("--help")
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out.startswith("Usage: overview ")
    for name, sentence in COMMANDS.items():
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


def reference() -> str:
    """The help of every command, with its exit code, as the page of the reference has it."""
    text = "# Command line\n\nExit codes: 0 done, 1 failed, 2 bad input, 130 Ctrl-C.\n"
    for words in ((), *ALL):
        name = " ".join(("overview", *words))
        text += f"\n## {name}\n"
        for option in ("--help", "--help-all"):
            if option == "--help-all" and not getattr(ALL.get(words), "first", ()):
                continue
            outcome = overview(*words, option)
            assert outcome.err == ""
            text += f"\n`{name} {option}`, exit code {outcome.code}:\n"
            text += f"\n```text\n{outcome.out}```\n"
    return text


def test_the_help_of_every_command_is_that_of_the_reference(monkeypatch):
    """To renew the page: OVERVIEW_RENEW=1 pytest tests/cli/test_help.py."""
    monkeypatch.setenv("COLUMNS", "80")
    found = reference()
    if os.environ.get("OVERVIEW_RENEW") == "1":
        REFERENCE.write_text(found, encoding="utf-8")
    stored = REFERENCE.read_text(encoding="utf-8")
    if not importlib.util.find_spec("overview_studies"):
        found, stored = without_studies(found), without_studies(stored)
    assert found == stored


def without_studies(text: str) -> str:
    """The page of the reference without the commands of a distribution that is not installed."""
    own = r"overview (study|learn)\b"
    text = re.sub(rf"\n## {own}.*?(?=\n## (?!{own})|\Z)", "", text, flags=re.S)
    return re.sub(r"(?m)^  (study|learn) .*\n", "", text)


def test_every_command_stands_in_a_block_of_the_documentation_which_runs_as_a_test():
    pages = [page for page in PAGES if page.name != REFERENCE.name]
    blocks = [
        " ".join(block.text.split())
        for page in pages
        for block in blocks_of(page, (ROOT / page).read_text(encoding="utf-8"))
        if block.language == "sh"
    ]
    for words, command in ALL.items():
        if not isinstance(command, click.Group):
            assert any(f"overview {' '.join(words)}" in block for block in blocks), words


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_help_fits_a_screen_with_a_sentence_an_example_and_few_options(words):
    outcome = overview(*words, "--help")
    assert outcome.code == 0
    lines = outcome.out.splitlines()
    assert len(lines) <= SCREEN_LINES
    assert lines[0].startswith(f"Usage: overview {' '.join(words)} ")
    assert f"Example: overview {words[0]}" in " ".join(outcome.out.split())
    command = ALL[words]
    if isinstance(command, GroupedCommand):
        options = [one for one in command.params if isinstance(one, GroupOption)]
        listed = [one for one in options if any(f" {one.opts[-1]}" in line for line in lines)]
        assert len(listed) <= MAX_OPTIONS
        # all or, with --help-all, those used first
        assert listed == options if not command.first else len(options) > MAX_OPTIONS
        assert set(command.first) <= {one.name for one in options}
        shown = overview(*words, "--help-all").out if command.first else outcome.out
        assert all(one.opts[-1] in shown for one in options)


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_every_command_that_reports_has_a_json_option(words):
    command = ALL[words]
    if isinstance(command, click.Group):
        pytest.skip("a group reports nothing itself")
    assert ("--json" in [name for one in command.params for name in one.opts]) == (
        words not in PRINTS_JSON
    )
    if words in PRINTS_JSON:
        assert "JSON" in overview(*words, "--help").out + (command.help or "")


@pytest.mark.parametrize(("name", "most"), [("play", 28), ("serve", 31)])
def test_the_options_of_a_live_command_stand_under_headings(name, most):
    command = ALL[name,]
    options = [one for one in command.params if isinstance(one, GroupOption)]
    assert 20 < len(options) <= most
    lines = overview(name, "--help-all").out.splitlines()
    headings = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert headings[:3] == ["Data:", "Preset:", "Live data:"]
    assert headings[-1] == "Options:"  # --help alone
    last = lines[lines.index("Options:") + 1 :]
    assert [line.split()[0] for line in last] == ["--help-all", "-h,"]
    assert len(headings) <= 9


MEANINGS = {
    "--output": "[Ff]ile|[Ff]older|list|[Rr]eport|Copy|profile|answers",
    "--json": "Report .*JSON",
    "--sample-rate": "Sample rate",
    "--seed": "[Ss]eed|chance",
    "--preset": "^Preset: name or .toml file",
    "--seconds": "seconds|Duration",
    "--plot": "Plot|Draw",
    "--to": "[Ff]ormat",
    "--study": "folder",
    "--timeline": "^Timeline",
}
"""What the help of options has in common that isn't the same in all commands."""


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


def test_one_option_has_one_meaning_in_all_commands():
    helps: dict[str, set[str]] = {}
    for command in ALL.values():
        for option in command.params:
            if isinstance(option, click.Option):
                helps.setdefault(option.opts[-1], set()).add(option.help or "")
    differing = {name: found for name, found in helps.items() if len(found) > 1}
    assert set(differing) <= set(MEANINGS)
    for name, found in differing.items():
        for text in found:
            assert re.search(MEANINGS[name], text), (name, text)


@pytest.mark.parametrize("words", [(), ("presets",)], ids=["overview", "presets"])
def test_a_group_without_a_command_shows_its_help(words):
    outcome = overview(*words)
    assert outcome.code == 2
    shown = outcome.out + outcome.err
    assert shown.startswith(f"Usage: {' '.join(('overview', *words))} ")
    assert len(shown.splitlines()) > 5


def test_the_version_is_the_packages():
    assert overview("--version").out == f"overview {ov.__version__}\n"


def test_an_unknown_command_or_option_gives_a_one_line_error_that_points_to_the_help():
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
