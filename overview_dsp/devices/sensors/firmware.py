"""The kit's firmware: one folder per board, with wiring and commands at the top of its sketch."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.files.library import Library

LIBRARY = Library("firmware", "a firmware")
_HEAD = re.compile(r"/\* ?(.*?)\*/|((?:#[^\n]*\n)+)", re.S)


def firmware_names() -> tuple[str, ...]:
    """Return the names of all firmware, sorted."""
    return tuple(sorted(path.name for path in LIBRARY.bundled_folder.iterdir() if path.is_dir()))


def firmware_head(name: str) -> str:
    """Return purpose, wiring and commands of a firmware: its first comment; InputError."""
    found = _HEAD.match(_program(name).read_text(encoding="utf-8"))
    assert found is not None
    block, lines = found.groups()
    return (block or re.sub(r"^# ?", "", lines, flags=re.M)).strip()


def copy_firmware(name: str, folder: Path) -> Path:
    """Copy a firmware to a new folder of its name in `folder`, for the Arduino IDE; InputError."""
    source, to = _program(name).parent, folder / name
    if to.exists():
        raise InputError(f"{to} already exists; move it away or choose another folder (-o)")
    try:
        shutil.copytree(source, to)
    except OSError as error:
        raise InputError(f"{to}: can't be written ({error.strerror or error})") from None
    return to


def _program(name: str) -> Path:
    names = firmware_names()
    if name not in names:
        raise InputError(f"no firmware is called {name!r}{did_you_mean(name, names)}")
    folder = LIBRARY.bundled_folder / name
    return next(path for path in (folder / f"{name}.ino", folder / "main.py") if path.is_file())
