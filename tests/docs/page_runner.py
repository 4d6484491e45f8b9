"""Runs a page's blocks in order: one folder and one set of Python names for each page."""

from __future__ import annotations

import re
import shlex
import sys
import tomllib
from pathlib import Path
from typing import Any

import click

from overview_dsp.cli import app
from tests.cli.running import overview
from tests.docs.markdown_blocks import ROOT, Block

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]


OTHER_PROGRAMS = {
    "your-sensor", "pytest", "ruff", "mypy", "lint-imports", ".", "make", "voice/example",
}  # fmt: skip


class Page:
    """A page that is being followed from its first block on."""

    def __init__(self, folder: Path, blocks: list[Block]) -> None:
        self.folder, self.blocks, self.done = folder, blocks, 0
        self.names: dict[str, Any] = {"__name__": "__main__"}

    def run_up_to(self, block: Block, runs: Any) -> None:
        """Run this block, and first those before it; `runs(block)` says which can run."""
        last = self.blocks.index(block)
        while self.done <= last:
            one = self.blocks[self.done]
            self.done += 1
            if runs(one):
                self._run(one)

    def _run(self, block: Block) -> None:
        if block.file:
            (self.folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            code = compile(block.text, block.name, "exec")
            exec(code, self.names)
        elif block.language == "sh":
            for line in block.text.splitlines():
                self._run_line(line)

    def _run_line(self, line: str) -> None:
        words = shlex.split(line, comments=True)
        if not words:
            return
        target = None
        if ">" in words:
            words, (target,) = words[: words.index(">")], words[words.index(">") + 1 :]
        assert words[0] == "overview", f"this runs `overview` only, not {line!r}"
        outcome = overview(*words[1:])
        assert outcome.code == 0, f"{line}\n{outcome.err}"
        if target is not None:
            (self.folder / target).write_text(outcome.out, encoding="utf-8")


def understood(line: str) -> None:
    """AssertionError unless a line that can't be run here is one this project understands.

    The options of `overview` are parsed, extras and tools looked up.
    """
    for part in re.split(r"\s(?:&&|\|)\s", line.split("  #")[0]):
        words = shlex.split(part, comments=True)
        if not words or words[0] in OTHER_PROGRAMS:
            continue
        if words[0] == "overview":
            parsed(words[1:])
        elif words[:2] == ["pip", "install"]:
            for word in words[2:]:
                named = re.search(r"\[(.+)\]", word)
                for extra in named[1].split(",") if named else ():
                    assert extra in EXTRAS, f"no extra is called {extra!r}: {line}"
                if word.startswith("./"):
                    assert (ROOT / word / "pyproject.toml").is_file(), f"not there: {line}"
        elif words[0] == "python":
            assert words[1] == "-m" or (ROOT / words[1]).is_file(), f"no such tool: {line}"
        else:
            raise AssertionError(f"not understood: {line}")


def parsed(words: list[str]) -> None:
    """Parse a command's options and arguments without running it."""
    command = app
    # with the names of the option for help, which a command keeps from its first context
    context = click.Context(app, info_name="overview", **app.context_settings)
    while isinstance(command, click.Group):
        name, words = words[0], words[1:]
        found = command.get_command(context, name)
        assert found is not None, f"no command is called {name!r}"
        command = found
        context = click.Context(command, info_name=name, parent=context)
    try:
        command.make_context(context.info_name, list(words), parent=context.parent)
    except click.UsageError as error:
        raise AssertionError(f"overview {' '.join(words)}: {error.format_message()}") from error


def without_modules(names: tuple[str, ...]) -> list[str]:
    """Those of the modules that are not installed."""
    import importlib.util

    return [n for n in names if n not in sys.modules and importlib.util.find_spec(n) is None]
