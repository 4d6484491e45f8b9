"""Where actuator profiles are: bundled ones and a person's own by name, any other by its path."""

from __future__ import annotations

import os
from pathlib import Path

from overview_dsp.actuators.model import Actuator
from overview_dsp.actuators.validation import parse_actuator
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.files import toml as toml_files
from overview_dsp.files.toml import SUFFIX, names_in, read_text

FOLDER_VARIABLE = "OVERVIEW_ACTUATORS"
"""Environment variable that names the folder of own profiles."""


def bundled_folder() -> Path:
    """The folder of bundled profiles: in the installed package, or the checkout's `actuators/`."""
    here = Path(__file__).resolve().parent
    installed = here / "bundled"
    return installed if installed.is_dir() else here.parent.parent / "actuators"


def own_folder() -> Path:
    """The folder of a person's own profiles, which may not be there yet."""
    return toml_files.own_folder("actuators", FOLDER_VARIABLE)


def actuator_names() -> tuple[str, ...]:
    """List the bundled profiles, then a person's own.

    Returns
    -------
    tuple of str
        Names; a bundled name stays the bundled profile's.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> "c2" in ov.actuators.names()
    True
    """
    bundled = names_in(bundled_folder())
    return (*bundled, *(name for name in names_in(own_folder()) if name not in bundled))


def actuator_path(name: str | Path) -> Path:
    """The file of a profile given by name or path; InputError if there is none."""
    text = str(name)
    for folder in (bundled_folder(), own_folder()):
        if text in names_in(folder):
            return folder / (text + SUFFIX)
    path = Path(text)
    if path.suffix == SUFFIX or path.parent != Path("."):
        # os.path: a name that is too long is no file, where pathlib raises
        if os.path.isfile(path):
            return path
        what = "is a folder" if os.path.isdir(path) else "no such file"
        raise InputError(f"{path}: {what}; give an actuator's .toml file or a name")
    raise InputError(
        f"no actuator is called {text!r}{did_you_mean(text, actuator_names())} "
        "(or give the path of a .toml file)"
    )


def reference(actuator: Actuator) -> str:
    """What `load_actuator` finds it by again, from any folder: its name, else its whole path."""
    source = os.path.abspath(actuator.source)
    known = actuator.name in actuator_names()
    return (
        actuator.name
        if known and source == os.path.abspath(actuator_path(actuator.name))
        else source
    )


def load_actuator(name: str | Path) -> Actuator:
    """Load an actuator's profile, not calibrated.

    Parameters
    ----------
    name : str or path
        A bundled or own name (`c2`), or the path of a TOML file.

    Returns
    -------
    Actuator
        What it can do and may be given.

    Raises
    ------
    InputError
        No such profile, or one that is not valid: names file, line, key and range.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> c2 = ov.actuators.load("c2")
    >>> c2.resonance_hz
    250.0
    """
    path = actuator_path(name)
    return parse_actuator(read_text(path), path.stem, str(path))
