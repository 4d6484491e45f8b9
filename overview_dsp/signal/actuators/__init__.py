"""Actuators: profiles of tactors, voice coils and headphones, with the limits of their drive.

`ov.actuators` loads profiles, drives actuators within their limits and stores the threshold of the
user's sensation. Each name is imported when it is first used.

Examples
--------
>>> import overview_dsp as ov
>>> c2 = ov.actuators.load("c2")
>>> round(c2.resonance_hz), round(c2.rise_ms)
(250, 33)
"""

from overview_dsp.public import stub_names

__getattr__, __dir__, __all__ = stub_names(__name__)
