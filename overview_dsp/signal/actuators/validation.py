"""An actuator file's text to an Actuator; errors name file, line, key and range."""

from __future__ import annotations

from overview_dsp.files.toml import (
    check_head,
    faults_at_their_line,
    parse_toml,
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
