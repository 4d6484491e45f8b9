"""Small TOML files by name: those of the program, then a person's own; any other by its path."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.toml import SUFFIX

_PACKAGE = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Library:
    """The files of a sort.

    Attributes
    ----------
    sort : str
        `presets`: the package in which the bundled ones are, and the folder of a person's own.
    one : str
        One of them, with its article, in messages.
    variable : str
        The environment variable that names another folder of own ones; empty: there are none.
    """

    sort: str
    one: str
    variable: str = ""

    @property
    def bundled_folder(self) -> Path:
        """The bundled ones: in the installed package, or in the checkout."""
        installed = _PACKAGE / "bundled" / self.sort
        return installed if installed.is_dir() else _PACKAGE.parent / self.sort

    @property
    def user_folder(self) -> Path:
        """A person's own, which may not be there yet."""
        given = os.environ.get(self.variable)
        if given:
            return Path(given)
        import platformdirs

        return platformdirs.user_config_path("overview-dsp", appauthor=False) / self.sort

    @property
    def bundled(self) -> tuple[str, ...]:
        """Names of the bundled ones, sorted."""
        return _names_in(self.bundled_folder)

    @property
    def user(self) -> tuple[str, ...]:
        """Names of a person's own, sorted; a bundled name stays the bundled one's."""
        if not self.variable:
            return ()
        return tuple(sorted(set(_names_in(self.user_folder)) - set(self.bundled)))

    def path(self, name: str | Path) -> Path:
        """The file that is named; InputError if there is none."""
        text = str(name)
        if text in self.bundled:
            return self.bundled_folder / (text + SUFFIX)
        if text in self.user:
            return self.user_folder / (text + SUFFIX)
        path = Path(text)
        if path.suffix == SUFFIX or path.parent != Path("."):
            # os.path: a name that is too long is no file, where pathlib raises
            if os.path.isfile(path):
                return path
            what = "is a folder" if os.path.isdir(path) else "no such file"
            raise InputError(f"{path}: {what}; give {self.one}'s {SUFFIX} file or a name")
        raise InputError(
            f"no {self.one.split()[-1]} is called {shown(text)}"
            f"{did_you_mean(text, (*self.bundled, *self.user))} (or give the path of a .toml file)"
        )


def _names_in(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in folder.glob("*" + SUFFIX))) if folder.is_dir() else ()
