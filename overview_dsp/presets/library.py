"""Where presets are: the bundled ones by name, any other by its path."""

from __future__ import annotations

import os
from pathlib import Path

from overview_dsp.errors import InputError
from overview_dsp.presets.model import Preset
from overview_dsp.presets.parameters import did_you_mean
from overview_dsp.presets.validation import parse_preset

SUFFIX = ".toml"
MAX_BYTES = 1_000_000


def bundled_folder() -> Path:
    """The folder of bundled presets: in the installed package, or the checkout's `presets/`."""
    here = Path(__file__).resolve().parent
    installed = here / "bundled"
    return installed if installed.is_dir() else here.parent.parent / "presets"


def bundled_names() -> tuple[str, ...]:
    """Names of the bundled presets, sorted."""
    return tuple(sorted(path.stem for path in bundled_folder().glob("*" + SUFFIX)))


def preset_path(name: str | Path) -> Path:
    """The file of a preset given by name or path.

    Raises
    ------
    InputError
        There is no such preset or file.
    """
    text = str(name)
    if text in bundled_names():
        return bundled_folder() / (text + SUFFIX)
    path = Path(text)
    if path.suffix == SUFFIX or path.parent != Path("."):
        # os.path: a name that is too long is no file, where pathlib raises
        if os.path.isfile(path):
            return path
        what = "is a folder" if os.path.isdir(path) else "no such file"
        raise InputError(f"{path}: {what}; give a preset's .toml file or one of the bundled names")
    raise InputError(
        f"no preset is called {text!r}{did_you_mean(text, bundled_names())} "
        "(or give the path of a .toml file)"
    )


def load_preset(name: str | Path) -> Preset:
    """A preset: a bundled name (`football`) or the path of a TOML file.

    Raises
    ------
    InputError
        No such preset, or one that is not valid: names file, line, key and range.
    """
    path = preset_path(name)
    try:
        data = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    if data is None:
        raise InputError(f"{path}: larger than {MAX_BYTES:,} bytes; a preset is a short TOML file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: not UTF-8 text (byte {error.start}); a preset is a TOML file"
        ) from None
    return parse_preset(text, path.stem, str(path))
