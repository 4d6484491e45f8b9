"""Check that a commit can be released, or set its version: see RELEASING.md.

python tools/check_release.py [--set VERSION]
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCE = ("overview_dsp/__init__.py", r'__version__ = "([^"]+)"')
COPIES = (
    ("CITATION.cff", r"(?m)^version: (\S+)$"),
    ("README.md", r"Alpha, version (\d[\w.]*\w)"),
    ("studies/pyproject.toml", r'(?m)^version = "([^"]+)"'),
    ("studies/pyproject.toml", r'"overview-dsp==([^"]+)"'),
    ("studies/pyproject.toml", r'"overview-dsp\[web\]==([^"]+)"'),
)
"""Files and patterns of the version; pyproject.toml takes it from SOURCE when a wheel is built."""
HEADINGS = ("Added", "Changed", "Fixed", "Removed")
LONGEST_ENTRY = 130


def version(root: Path) -> str:
    """Return the version in the package."""
    name, pattern = SOURCE
    found = re.search(pattern, (root / name).read_text(encoding="utf-8"))
    if found is None:
        raise SystemExit(f"{name}: no __version__")
    return found[1]


def set_version(root: Path, new_version: str) -> None:
    """Write a version to every file that has one."""
    if not re.fullmatch(r"\d+\.\d+\.\d+", new_version):
        raise SystemExit(f"version is {new_version!r}; must be three numbers such as 0.2.0")
    for name, pattern in (SOURCE, *COPIES):
        path = root / name
        text = path.read_text(encoding="utf-8")
        path.write_text(
            re.sub(pattern, lambda match: match[0].replace(match[1], new_version), text),
            encoding="utf-8",
        )


def faults(root: Path) -> Iterator[str]:
    """Yield one line per fault: versions that differ, a changelog that is incomplete."""
    current = version(root)
    for name, pattern in COPIES:
        found = re.search(pattern, (root / name).read_text(encoding="utf-8"))
        if found is None or found[1] != current:
            yield f"{name}: version is {found[1] if found else 'missing'}; must be {current}"
    yield from changelog_faults((root / "CHANGELOG.md").read_text(encoding="utf-8"), current)
    for name in ("film.gif", "sweeps.png", "play.svg"):
        if not (root / "docs" / "pictures" / name).is_file():
            yield f"docs/pictures/{name}: missing; see RELEASING.md, step 4"


def changelog_faults(text: str, current: str) -> Iterator[str]:
    """Yield the faults of a changelog."""
    sections = re.split(r"(?m)^## ", text)[1:]
    titles = [section.partition("\n")[0] for section in sections]
    if not titles or titles[0] != "Unreleased":
        yield "CHANGELOG.md: the first section must be Unreleased"
    dated = re.compile(rf"{re.escape(current)} - \d{{4}}-\d\d-\d\d")
    if not any(dated.fullmatch(title) for title in titles):
        yield f"CHANGELOG.md: no section '{current} - YYYY-MM-DD'"
    for title, section in zip(titles, sections, strict=True):
        headings = re.findall(r"(?m)^### (.*)$", section)
        if headings != [one for one in HEADINGS if one in headings]:
            yield f"CHANGELOG.md: {title}: headings must be {', '.join(HEADINGS)}, in this order"
        for line in section.splitlines()[1:]:
            if line.startswith("- ") and len(line) > LONGEST_ENTRY:
                yield f"CHANGELOG.md: {title}: entry over {LONGEST_ENTRY} characters: {line[:55]}"
            elif line.startswith(" "):
                yield f"CHANGELOG.md: {title}: an entry is one line: {line.strip()[:55]}"


def main() -> None:
    """Set the version, or print every fault and end with 1 if there is one."""
    parser = argparse.ArgumentParser(description="Check that this commit can be released.")
    parser.add_argument("--set", metavar="VERSION", help="write this version to every file")
    options = parser.parse_args()
    if options.set:
        set_version(ROOT, options.set)
    found = list(faults(ROOT))
    print("\n".join(found) or f"version {version(ROOT)}: no fault")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
