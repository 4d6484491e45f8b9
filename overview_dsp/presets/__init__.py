"""Presets: TOML files that say how a surface feels and sounds, and one table of parameters."""

from overview_dsp.presets.library import bundled_names, load_preset, preset_path
from overview_dsp.presets.model import Kind, Mode, Preset
from overview_dsp.presets.parameter import Parameter
from overview_dsp.presets.parameters import PARAMETERS

__all__ = [
    "PARAMETERS",
    "Kind",
    "Mode",
    "Parameter",
    "Preset",
    "bundled_names",
    "load_preset",
    "preset_path",
]
