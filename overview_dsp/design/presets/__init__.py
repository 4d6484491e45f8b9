"""Presets: TOML files that say how a surface feels and sounds, and one table of parameters.

`ov.presets` is for who designs with them: load, change, mix, compare and save. Each name is
imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> football, heart = ov.presets.load("football"), ov.presets.load("heart")
>>> [preset.name for preset in ov.presets.morph(football, heart, steps=3)]
['football-heart-1', 'football-heart-2', 'football-heart-3']
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__, ["design.presets.library"])
