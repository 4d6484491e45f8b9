"""The project's English stays plain: `tools/plain_english.py` counts what is not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tools import plain_english

ROOT = Path(__file__).parent.parent

LIMITS = {"summary": 0, "idiom": 0, "help": 0, "name": 0, "docs": 0}
"""Findings per category. A lower count lowers its limit; a limit is never raised."""


def counted(root: Path) -> tuple[dict[str, int], str]:
    """Return the findings per category and what the program printed."""
    ran = subprocess.run(
        [sys.executable, str(ROOT / "tools" / "plain_english.py"), str(root)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    rows = ran.stdout.splitlines()[-len(plain_english.CATEGORIES) - 1 : -1]
    return {row.split()[0]: int(row.split()[1]) for row in rows}, ran.stdout


def test_no_category_has_more_findings_than_its_limit():
    counts, printed = counted(ROOT)
    assert counts == LIMITS, f"more: mend them; fewer: lower the limit\n{printed}"


@pytest.mark.parametrize(
    ("name", "text", "category"),
    [
        ("a.py", 'def f():\n    """Whether it is so."""\n', "summary"),
        ("a.py", 'raise ValueError("the disk is told of it")\n', "idiom"),
        ("a.py", 'option("--x", help="Of the noise.")\n', "help"),
        ("a.py", "def told(x):\n    pass\n", "name"),
        ("a.md", "```sh\nls\n```\n\nlists the files.\n", "docs"),
    ],
)
def test_each_category_is_found(tmp_path, name, text, category):
    (tmp_path / name).write_text(text)
    counts, _ = counted(tmp_path)
    assert counts[category] == 1
