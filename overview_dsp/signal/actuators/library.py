"""Where actuator profiles are: bundled ones and a person's own by name, any other by its path.

An actuator file's text to an Actuator; errors name file, line, key and range.
"""

from __future__ import annotations

import os
from pathlib import Path

from overview_dsp import validation
from overview_dsp.files.library import Library
from overview_dsp.files.toml import (
    check_head,
    faults_at_their_line,
    parse_toml,
    read_text,
    sections_of,
    values_in,
)
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS, Actuator

SCHEMA = 1


def parse_actuator(text: str, name: str, source: str) -> Actuator:
    """An actuator from a file's text.

    Raises
    ------
    InputError
        Not TOML, an unknown key, a wrong type, a value out of range or one that doesn't fit the
        others: names file, line, key and range.
    """
    data = parse_toml(text, source)
    with faults_at_their_line(text, source):
        check_head(data, sections_of(ACTUATOR_PARAMETERS), SCHEMA, needs_texts=True)
        values = values_in(data, ACTUATOR_PARAMETERS)
        return Actuator(name, data["title"], data["description"], values, source)


LIBRARY = Library("actuators", "an actuator", "OVERVIEW_ACTUATORS")


def actuator_names() -> tuple[str, ...]:
    """List the bundled profiles, then a person's own.

    Returns
    -------
    tuple of str
        Names; a bundled name stays the bundled profile's.

    Examples
    --------
    >>> "c2" in ov.actuators.names()
    True
    """
    return (*LIBRARY.bundled, *LIBRARY.user)


def reference(actuator: Actuator) -> str:
    """What `load_actuator` finds it by again, from any folder: its name, else its whole path."""
    validation.instance(actuator, Actuator, "actuator", "ov.load_actuator gives one")
    source = os.path.abspath(actuator.source)
    known = actuator.name in actuator_names()
    return (
        actuator.name
        if known and source == os.path.abspath(LIBRARY.path(actuator.name))
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
    >>> c2 = ov.actuators.load("c2")
    >>> c2.resonance_hz
    250.0
    """
    path = LIBRARY.path(name)
    return parse_actuator(read_text(path), path.stem, str(path))
