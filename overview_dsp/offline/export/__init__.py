"""Export of gestures to haptic formats, and of engines to browsers, C and plugins.

`ov.export` writes renders for other devices, and reads haptic clips. Each name is
imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> result = ov.render(match, preset, ov.sweep(0.5), sample_rate=8000, tail="none")
>>> [path.name for path in ov.export.export(result, "haptic", "match.haptic").files]
['match.haptic']
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
