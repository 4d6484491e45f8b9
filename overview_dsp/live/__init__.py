"""Live playback of an engine through an audio output; the only package that opens devices.

`ov.live` is for programs that play: output streams whose callback never waits for Python, their
settings and their meters. Importing it needs no PortAudio and no sound card; opening an output
does. Each name is imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> engine = ov.Engine(preset, match)
>>> engine.prepare(sample_rate=8000, max_block_size=256)
>>> with ov.live.NullStream(engine) as stream:  # OutputStream(engine) plays sound
...     engine.control(theta2=1.2, touching=True)
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
