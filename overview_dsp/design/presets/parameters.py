"""Table of all preset parameters: id, unit, range, default and description.

It is read from `parameters.toml`. Files, command line, page, engine and tests all use it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from overview_dsp.design.presets.parameter import Parameter, read_parameters
from overview_dsp.errors import InputError, did_you_mean

MAX_POINTS = 256  # most points of a kind's own profile
MAX_ALIASES = 64  # most aliases of a kind
_KNOWN = read_parameters(Path(__file__).with_name("parameters.toml"))


def _members(section: str) -> Mapping[str, Parameter]:
    """Return the parameters of a section's entries by key; all are part of the friction table."""
    return MappingProxyType(
        {
            known.key: replace(known, id=known.key, surface=True)
            for id, known in _KNOWN.items()
            if id.startswith(f"{section}.")
        }
    )


KIND_PARAMETERS = _members("kinds")
"""Parameters of an event kind by key."""

MODE_PARAMETERS = _members("modes")
"""Parameters of a modal resonator by key."""

PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        id: replace(known, surface=id.startswith("surface.") or id == "tactor.routing")
        for id, known in _KNOWN.items()
        if not id.startswith(("kinds.", "modes."))
    }
)
"""Parameters of a preset by id, without those of event kinds."""

SECTIONS: Mapping[str, Mapping[str, Parameter]] = MappingProxyType(
    {
        section: {one.key: one for id, one in PARAMETERS.items() if id.startswith(f"{section}.")}
        for section in dict.fromkeys(id.partition(".")[0] for id in PARAMETERS)
    }
)
"""The same parameters by section and key."""

SHAPES = KIND_PARAMETERS["shape"].choices
PATTERNS = PARAMETERS["surface.pattern"].choices
MATERIALS = PARAMETERS["surface.material"].choices


def parameter(id: str) -> Parameter:
    """Return the parameter with that id; InputError with the nearest id if there is none."""
    found = PARAMETERS.get(id)
    if found is None:
        raise InputError(f"no parameter is called {id!r}{did_you_mean(id, PARAMETERS)}")
    return found
