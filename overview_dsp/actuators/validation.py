"""An actuator file's text to an Actuator; errors name file, line, key and range."""

from __future__ import annotations

from overview_dsp.actuators.model import ACTUATOR_PARAMETERS, Actuator
from overview_dsp.files.toml import check_head, faults_at_their_line, given_in, parse_toml
from overview_dsp.presets.parameter import Value

SCHEMA = 1
_SECTIONS = tuple(dict.fromkeys(id.split(".")[0] for id in ACTUATOR_PARAMETERS))


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
        check_head(data, _SECTIONS, SCHEMA, needs_texts=True)
        values: dict[str, Value] = {}
        for section in _SECTIONS:
            keys = (id.split(".")[1] for id in ACTUATOR_PARAMETERS if id.split(".")[0] == section)
            for key, value in given_in(data, section, keys).items():
                values[f"{section}.{key}"] = value
        return Actuator(name, data["title"], data["description"], values, source)
