"""The check of a release finds versions that differ and changelogs that are incomplete."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tools import check_release

ROOT = Path(__file__).parents[2]
CHANGELOG = "# Changelog\n\n## Unreleased\n\n## 1.2.3 - 2026-01-01\n\n### Added\n\n- A thing.\n"


@pytest.fixture
def checkout(tmp_path):
    """What the check reads."""
    names = {name for name, _ in (check_release.SOURCE, *check_release.COPIES)}
    for name in (*names, "CHANGELOG.md", "docs/pictures"):
        target = tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, target)
    return tmp_path


def test_this_commit_has_one_version_and_a_complete_changelog():
    assert list(check_release.faults(ROOT)) == []


def test_a_version_that_is_set_stands_everywhere(checkout):
    check_release.set_version(checkout, "1.2.3")
    (checkout / "CHANGELOG.md").write_text(CHANGELOG)
    assert list(check_release.faults(checkout)) == []
    assert check_release.version(checkout) == "1.2.3"


@pytest.mark.parametrize("place", range(len(check_release.COPIES)))
def test_one_other_version_is_found(checkout, place):
    name, _ = check_release.COPIES[place]
    path = checkout / name
    path.write_text(path.read_text().replace(check_release.version(ROOT), "9.9.9"))
    assert any(
        fault.startswith(f"{name}: version is 9.9.9") for fault in check_release.faults(checkout)
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (CHANGELOG.replace("## Unreleased\n\n", ""), "must be Unreleased"),
        (CHANGELOG.replace("1.2.3", "1.2.2"), "no section"),
        (CHANGELOG + "\n### Fixed\n\n- x\n\n### Changed\n\n- y\n", "headings must be"),
        (CHANGELOG + "- " + "x" * 130 + "\n", "entry over"),
        (CHANGELOG + "  continued\n", "one line"),
    ],
)
def test_a_changelog_out_of_form_is_found(text, fault):
    (found,) = check_release.changelog_faults(text, "1.2.3")
    assert fault in found


def test_a_version_that_is_no_number_is_refused(checkout):
    with pytest.raises(SystemExit, match="must be three numbers"):
        check_release.set_version(checkout, "next")
