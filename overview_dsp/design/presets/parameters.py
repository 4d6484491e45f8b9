"""The one parameter table: id, unit, range, default and a sentence for everything a person sets.

It stands in `parameters.toml`, beside this file. Files, command line, page, engine and tests all
read it, so none of them can disagree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from overview_dsp.design.presets.parameter import Parameter, read_parameters
from overview_dsp.errors import InputError, did_you_mean

MAX_POINTS = 256
"""Points of a kind's own course."""

MAX_ALIASES = 64
"""Other kinds that are felt as one."""

_KNOWN = read_parameters(Path(__file__).with_name("parameters.toml"))


def _members(section: str) -> Mapping[str, Parameter]:
    """What each member of a list or table has, which is always part of the friction table."""
    return MappingProxyType(
        {
            known.key: replace(known, id=known.key, surface=True)
            for id, known in _KNOWN.items()
            if id.startswith(f"{section}.")
        }
    )


KIND_PARAMETERS = _members("kinds")
"""An event kind's parameters, by key."""

MODE_PARAMETERS = _members("modes")
"""A modal resonator's parameters, by key."""

PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        id: replace(known, surface=id.startswith("surface."))
        for id, known in _KNOWN.items()
        if not id.startswith(("kinds.", "modes."))
    }
)
"""Every parameter of a preset that is not an event kind's, by id."""

SECTIONS: Mapping[str, Mapping[str, Parameter]] = MappingProxyType(
    {
        section: {one.key: one for id, one in PARAMETERS.items() if id.startswith(f"{section}.")}
        for section in dict.fromkeys(id.partition(".")[0] for id in PARAMETERS)
    }
)
"""The same by section and key."""

SHAPES = KIND_PARAMETERS["shape"].choices
PATTERNS = PARAMETERS["surface.pattern"].choices
MATERIALS = PARAMETERS["surface.material"].choices


def parameter(id: str) -> Parameter:
    """The parameter with that id; InputError with the nearest name if there is none."""
    found = PARAMETERS.get(id)
    if found is None:
        raise InputError(f"no parameter is called {id!r}{did_you_mean(id, PARAMETERS)}")
    return found
