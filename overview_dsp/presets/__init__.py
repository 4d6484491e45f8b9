"""Presets: TOML files that say how a surface feels and sounds, and one table of parameters."""

from overview_dsp.presets.blending import morph, randomized
from overview_dsp.presets.library import bundled_presets, load_preset, preset_path
from overview_dsp.presets.model import ClickMode, EventKind, Preset
from overview_dsp.presets.parameter import Parameter
from overview_dsp.presets.parameters import PARAMETERS
from overview_dsp.presets.writing import save_preset as save

__all__ = [
    "PARAMETERS",
    "ClickMode",
    "EventKind",
    "Parameter",
    "Preset",
    "bundled_presets",
    "load_preset",
    "morph",
    "preset_path",
    "randomized",
    "save",
]
