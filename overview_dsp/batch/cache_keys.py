"""What a case is made of, as a key: the same contents give the same key on every machine.

A changed file, value or program gives another key, so what is finished is never mistaken for what
is asked.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from overview_dsp import __version__
from overview_dsp.batch.grid import Case, Study
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.sources import sources_digest

KEY_DIGITS = 24

PROGRAM = f"{__version__}+{sources_digest()}"
"""What makes the bits: this program's version and its kernels."""


def digest(*values: Any) -> str:
    """Hexadecimal digest of plain values, arrays and dataclasses, by their contents."""
    found = hashlib.sha256()
    for value in values:
        _feed(found, value)
    return found.hexdigest()


def _feed(found: Any, value: Any) -> None:
    if isinstance(value, np.ndarray):
        found.update(f"array{value.dtype.str}{value.shape}".encode())
        found.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value):
        found.update(type(value).__name__.encode())
        for part in fields(value):
            if part.init:
                _feed(found, getattr(value, part.name))
    elif isinstance(value, Mapping):
        found.update(f"mapping{len(value)}".encode())
        for key in value:
            _feed(found, key)
            _feed(found, value[key])
    elif isinstance(value, tuple | list):
        found.update(f"list{len(value)}".encode())
        for item in value:
            _feed(found, item)
    elif value is None or isinstance(value, bool | int | float | str):
        text = repr(value).encode()
        found.update(f"{len(text)}:".encode() + text)
    else:
        raise TypeError(f"no digest of a {type(value).__name__}")


def _of_timeline(timeline: Timeline) -> str:
    """Words for a person (title, provenance, notes) make no other sound."""
    return digest(
        timeline.duration_s, timeline.events, timeline.details, timeline.intensity, timeline.gaps
    )


def preset_digest(preset: Preset) -> str:
    """Of all that is felt and heard of a preset: how a timeline grows under a hand is no sound."""
    felt = {id: value for id, value in preset.values.items() if not id.startswith("follow.")}
    return digest(felt, preset.kinds)


class Keys:
    """The keys of a study's cases."""

    def __init__(self, study: Study) -> None:
        """Digest the study's inputs, once."""
        self._timelines = [_of_timeline(timeline) for timeline in study.timelines.values()]
        self._presets = [preset_digest(preset) for preset in study.presets.values()]
        self._gestures = [digest(gesture) for gesture in study.gestures.values()]
        self._ids = tuple(study.parameters)
        self._common = digest(PROGRAM, study.settings)
        self._before_seed: dict[Any, Any] = {}

    def key(self, case: Case) -> str:
        """The key of a case: `KEY_DIGITS` hexadecimal digits, the name of its file."""
        parts = (case.timeline, case.preset, case.gesture, case.values)
        # seeds change fastest: what comes before them is hashed once
        if parts not in self._before_seed:
            found = hashlib.sha256()
            _feed(found, self._common)
            _feed(found, self._timelines[case.timeline])
            _feed(found, self._presets[case.preset])
            _feed(found, self._gestures[case.gesture])
            _feed(found, sorted(zip(self._ids, case.values, strict=True)))
            self._before_seed = {parts: found}
        found = self._before_seed[parts].copy()
        _feed(found, case.seed)
        return str(found.hexdigest())[:KEY_DIGITS]
