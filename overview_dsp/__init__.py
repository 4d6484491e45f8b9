"""overView DSP: feel a timeline.

Temporal data become a surface with friction. The user pulls a disk over it by a spring. The torque
of the disk is heard as friction clicks and felt as a 250 Hz vibration.

`ov.presets`, `ov.measure`, `ov.export`, `ov.live` and `ov.actuators` have functions for designers,
sound engineers and performers. The reference lists all public names (the `__all__` of these six
modules). Every other name is private and may change.

The import of this package compiles nothing and needs no sound card. Each name is imported when it
is first used.

Examples
--------
>>> import overview_dsp as ov
>>> timeline = ov.load_timeline("world-cup-final-2018")  # or any supported file
>>> result = ov.render(timeline, ov.load_preset("football"), ov.sweep(4.0))
>>> result.save("out.wav")
"""

from overview_dsp.public import stub_names

__version__ = "0.2.0"

# private packages, which are attributes too
_PRIVATE = (
    "signal.engine design.gestures data.readers offline.rendering signal.surface data.timeline"
)

__getattr__, __dir__, __all__ = stub_names(__name__, _PRIVATE.split())
