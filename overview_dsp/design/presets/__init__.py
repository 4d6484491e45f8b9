"""Presets: TOML files that say how a surface feels and sounds, and one table of parameters.

`ov.presets` is for who designs with them: load, change, mix, compare and save.

Examples
--------
>>> import overview_dsp as ov
>>> football, heart = ov.presets.load("football"), ov.presets.load("heart")
>>> [preset.name for preset in ov.presets.morph(football, heart, steps=3)]
['football-heart-1', 'football-heart-2', 'football-heart-3']
"""

from typing import TYPE_CHECKING

from overview_dsp.design.presets.comparing import Difference, differences
from overview_dsp.design.presets.library import bundled_presets as bundled
from overview_dsp.design.presets.library import load_preset as load
from overview_dsp.design.presets.library import user_presets
from overview_dsp.design.presets.model import ClickMode, EventKind, Preset, Tags
from overview_dsp.design.presets.morphing import morph, randomize
from overview_dsp.design.presets.parameter import Parameter
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS, PARAMETERS
from overview_dsp.design.presets.writing import save_preset as save
from overview_dsp.public import lazy_names

__all__ = [
    "KIND_PARAMETERS",
    "MODE_PARAMETERS",
    "PARAMETERS",
    "ClickMode",
    "Difference",
    "EventKind",
    "Parameter",
    "Preset",
    "Tags",
    "bundled",
    "differences",
    "load",
    "morph",
    "randomize",
    "save",
    "user_presets",
]

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(__name__, {})
