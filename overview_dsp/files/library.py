"""Small TOML files by name: bundled files, then files of the user; any other by its path."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from overview_dsp.errors import InputError, did_you_mean, quoted
from overview_dsp.files.toml import SUFFIX

_PACKAGE = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Library:
    """Files of one sort.

    `sort`: name of the folders: `presets`.
    `one`: name of one file, with its article, for messages: `a preset`.
    `variable`: environment variable that names another user folder; empty: only bundled files.
    """

    sort: str
    one: str
    variable: str = ""

    @property
    def bundled_folder(self) -> Path:
        """Folder of the bundled files, in the installed package or in the checkout."""
        installed = _PACKAGE / "bundled" / self.sort
        return installed if installed.is_dir() else _PACKAGE.parent / self.sort

    @property
    def user_folder(self) -> Path:
        """Folder of the user, which may not exist yet."""
        if folder := os.environ.get(self.variable):
            return Path(folder)
        import platformdirs

        return platformdirs.user_config_path("overview-dsp", appauthor=False) / self.sort

    @property
    def bundled(self) -> tuple[str, ...]:
        """Sorted names of the bundled files."""
        return _names_in(self.bundled_folder)

    @property
    def user(self) -> tuple[str, ...]:
        """Sorted names of the files of the user, without those that are bundled too."""
        if not self.variable:
            return ()
        return tuple(sorted(set(_names_in(self.user_folder)) - set(self.bundled)))

    def path(self, name: str | Path) -> Path:
        """Return the path of a file by its name or path; InputError if it doesn't exist."""
        text = str(name)
        if text in self.bundled:
            return self.bundled_folder / (text + SUFFIX)
        if text in self.user:
            return self.user_folder / (text + SUFFIX)
        path = Path(text)
        if path.suffix == SUFFIX or path.parent != Path("."):
            # os.path: pathlib raises for a name that is too long
            if os.path.isfile(path):
                return path
            what = "is a folder" if os.path.isdir(path) else "no such file"
            raise InputError(f"{path}: {what}; give {self.one}'s {SUFFIX} file or a name")
        raise InputError(
            f"no {self.one.split()[-1]} is called {quoted(text)}"
            f"{did_you_mean(text, (*self.bundled, *self.user))} (or give the path of a .toml file)"
        )


def _names_in(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in folder.glob("*" + SUFFIX))) if folder.is_dir() else ()
