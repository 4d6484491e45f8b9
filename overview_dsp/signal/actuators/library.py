"""Library of actuator profiles: bundled and user profiles by name, other files by path.

Errors in a profile have the form `file:line: key: message`.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overview_dsp import validation
from overview_dsp.errors import warn
from overview_dsp.files import toml
from overview_dsp.files.library import Library
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS, ONE_OF, Actuator, error_limit

if TYPE_CHECKING:
    from overview_dsp.signal.actuators.resonance import ResonanceFit

SCHEMA = 2
_RENAMED = {"sharpen": "overdrive", "equal_sensation": "perceptual_weighting"}
"""Keys of `[shaping]` in schema 1."""


def parse_actuator(text: str, name: str, source: str) -> Actuator:
    """Parse the text of a profile; InputError names file, line, key and range."""
    data = toml.parse_toml(text, source)
    with toml.faults_at_their_line(text, source):
        if data.get("schema") == 1:
            data["schema"] = SCHEMA
            if isinstance(shaping := data.get("shaping"), dict):
                data["shaping"] = {_RENAMED.get(key, key): value for key, value in shaping.items()}
        toml.check_head(data, toml.sections_of(ACTUATOR_PARAMETERS), SCHEMA, needs_texts=True)
        values = toml.values_in(data, ACTUATOR_PARAMETERS)
        return Actuator(name, data["title"], data["description"], values, source)


LIBRARY = Library("actuators", "an actuator", "OVERVIEW_ACTUATORS")


def actuator_names() -> tuple[str, ...]:
    """List the bundled profiles, then the user's.

    Returns
    -------
    tuple of str
        Names. A bundled name always refers to the bundled profile.

    Examples
    --------
    >>> "c2" in ov.actuators.names()
    True
    """
    return (*LIBRARY.bundled, *LIBRARY.user)


def reference(actuator: Actuator) -> str:
    """Return a name or absolute path by which `load_actuator` finds the profile again."""
    validation.instance(actuator, Actuator, "actuator", "ov.load_actuator gives one")
    source = os.path.abspath(actuator.source)
    known = actuator.name in actuator_names()
    is_listed = known and source == os.path.abspath(LIBRARY.path(actuator.name))
    return actuator.name if is_listed else source


def load_actuator(name: str | Path) -> Actuator:
    """Load an actuator's profile without its calibration.

    Parameters
    ----------
    name : str or path
        Name of a bundled or user profile (`c2`), or path of a TOML file.

    Returns
    -------
    Actuator
        Its resonance and the limits of its drive.

    Raises
    ------
    InputError
        The profile does not exist or is not valid: names file, line, key and range.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> c2.resonance_hz
    250.0
    """
    path = LIBRARY.path(name)
    actuator = parse_actuator(toml.read_text(path), path.stem, str(path))
    if actuator.number("shaping.overdrive") > 1.0 and actuator.overdrive_q == actuator.q:
        warn(
            f"{path}: overdrive is off: it needs resonance.tolerance_percent of at most "
            f"{error_limit(actuator.q):.2g}, not "
            f"{actuator.number('resonance.tolerance_percent'):g}; see 'overview actuators measure'"
        )
    return actuator


MEASURED_OVERDRIVE = 3.0  # of a profile with a measured resonance, up to its Q


def measured_profile(actuator: Actuator, fit: ResonanceFit, recording: str) -> str:
    """Return the text of an actuator's profile with the measured resonance of a recording.

    Overdrive is on if the resonance is known well enough for it.
    """
    import tomlkit

    document = tomlkit.parse(toml.read_text(Path(actuator.source)))
    resonance: Any = document["resonance"]
    for id in ONE_OF:
        resonance.pop(id.rpartition(".")[2], None)
    resonance["frequency_hz"] = round(fit.frequency_hz, 2)
    resonance["q"] = round(fit.q, 3)
    resonance["tolerance_percent"] = fit.tolerance_percent
    document["title"] = f"{actuator.title}, measured"
    shaping: Any = document.setdefault("shaping", tomlkit.table())
    is_exact = fit.tolerance_percent <= error_limit(fit.q)
    overdrive = max(actuator.number("shaping.overdrive"), min(MEASURED_OVERDRIVE, fit.q), 1.0)
    shaping["overdrive"] = round(overdrive, 3) if is_exact else 1.0
    return (
        f"# Resonance measured with {recording}: the response is within {fit.residual_db:.1f} dB "
        f"RMS of the model.\n# The rest is {actuator.name}:\n#\n{tomlkit.dumps(document)}"
    )
