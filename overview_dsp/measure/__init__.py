"""Perceptual measurements: feel reports, levels, onsets, an observer, and tuning of presets.

`ov.measure` is for designers of presets and for research. Each name is imported on first use.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> sweeps = {"fast": ov.sweep(1.0)}
>>> report = ov.measure.feel_report(preset, match, sweeps, sample_rate=8000)
>>> [stroke.name for stroke in report.strokes]
['fast', 'fast recoil']
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
