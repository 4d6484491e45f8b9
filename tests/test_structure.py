"""Where things are: what a newcomer relies on when looking for a part by its path."""

from __future__ import annotations

import re
from pathlib import Path

import overview_dsp

PACKAGE = Path(overview_dsp.__file__).parent
STUDIES = PACKAGE.parent / "studies" / "overview_studies"
ROOT_FILES = {
    "__init__.py",
    "__init__.pyi",
    "__main__.py",
    "arrays.py",
    "errors.py",
    "public.py",
    "installation.py",
    "units.py",
    "validation.py",
    "py.typed",
}


def test_the_root_holds_packages_and_the_shared_files_only():
    found = {path.name for path in PACKAGE.iterdir() if path.is_file()}
    assert found == ROOT_FILES
    folders = [path for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"]
    assert all((folder / "__init__.py").is_file() for folder in folders)
    assert len(folders) + len(found) <= 30


def test_every_package_says_what_it_is_for():
    for init in (*PACKAGE.rglob("__init__.py"), *STUDIES.rglob("__init__.py")):
        text = init.read_text(encoding="utf-8")
        assert re.match(r'"""[\w`][^\n]{15,}\.', text), init


def test_no_capacity_of_the_kernels_is_typed_a_second_time():
    layout = (PACKAGE / "kernels" / "layout.py").read_text(encoding="utf-8")
    capacities = re.findall(r"^([A-Z_]+) = \d+", layout.partition("# --- coefficients")[0], re.M)
    assert "CELLS" in capacities
    for path in (*PACKAGE.rglob("*.py"), *STUDIES.rglob("*.py")):
        if path.name == "layout.py" or "bundled" in path.parts:
            continue
        text = path.read_text(encoding="utf-8")
        for name in ("CELLS", "MAX_KINDS", "MAX_MODES", "BANKS", "HOST_RING", "STRIKE_LOG"):
            assert not re.search(rf"^{name} = [\d(]", text, re.M), (path, name)
