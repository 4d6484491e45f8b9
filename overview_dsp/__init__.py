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

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.errors import (
    InputError,
    NotPreparedError,
    OutputError,
    OverviewError,
    OverviewWarning,
)
from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp import live, measure
    from overview_dsp.data.feeds.live_timeline import LiveTimeline
    from overview_dsp.data.readers.native import save_timeline
    from overview_dsp.data.readers.registry import load_timeline, load_timelines
    from overview_dsp.data.timeline.curve_builder import CurveBuilder
    from overview_dsp.data.timeline.curve_points import RegularTimes
    from overview_dsp.data.timeline.event import Event
    from overview_dsp.data.timeline.intensity import Intensity
    from overview_dsp.data.timeline.model import Timeline
    from overview_dsp.design import presets
    from overview_dsp.design.gestures.model import Gesture
    from overview_dsp.design.gestures.scripts import arm, flick, pause, scrub, sweep, tap
    from overview_dsp.design.gestures.spec import parse_gesture
    from overview_dsp.design.gestures.take import load_gesture, save_gesture
    from overview_dsp.design.presets.library import bundled_presets, load_preset
    from overview_dsp.design.presets.model import ClickMode, EventKind, Preset
    from overview_dsp.offline import export
    from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_jobs, render_many
    from overview_dsp.offline.rendering.offline import (
        RenderFileResult,
        RenderResult,
        render,
        render_to_file,
    )
    from overview_dsp.offline.rendering.trace import Trace
    from overview_dsp.signal import actuators
    from overview_dsp.signal.actuators.library import load_actuator
    from overview_dsp.signal.actuators.model import Actuator
    from overview_dsp.signal.engine.engine import Engine
    from overview_dsp.signal.engine.memory_reader import EngineParameter, Meters, Strikes
    from overview_dsp.signal.surface.build import build_surface
    from overview_dsp.signal.surface.model import Surface

__version__ = "0.2.0"

__all__ = [
    "Actuator",
    "ClickMode",
    "CurveBuilder",
    "Engine",
    "EngineParameter",
    "Event",
    "EventKind",
    "Gesture",
    "InputError",
    "Intensity",
    "LiveTimeline",
    "Meters",
    "NotPreparedError",
    "OutputError",
    "OverviewError",
    "OverviewWarning",
    "Preset",
    "RegularTimes",
    "RenderFileResult",
    "RenderJob",
    "RenderResult",
    "RenderedJob",
    "Strikes",
    "Surface",
    "Timeline",
    "Trace",
    "actuators",
    "arm",
    "build_surface",
    "bundled_presets",
    "export",
    "flick",
    "live",
    "load_actuator",
    "load_gesture",
    "load_preset",
    "load_timeline",
    "load_timelines",
    "measure",
    "parse_gesture",
    "pause",
    "presets",
    "render",
    "render_jobs",
    "render_many",
    "render_to_file",
    "save_gesture",
    "save_timeline",
    "scrub",
    "sweep",
    "tap",
]


if not TYPE_CHECKING:  # type checkers know only the names above
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "Actuator": "signal.actuators.model",
            "ClickMode": "design.presets.model",
            "CurveBuilder": "data.timeline.curve_builder",
            "Engine": "signal.engine.engine",
            "EngineParameter": "signal.engine.memory_reader",
            "RegularTimes": "data.timeline.curve_points",
            "Event": "data.timeline.event",
            "EventKind": "design.presets.model",
            "Gesture": "design.gestures.model",
            "Intensity": "data.timeline.intensity",
            "LiveTimeline": "data.feeds.live_timeline",
            "Meters": "signal.engine.memory_reader",
            "Preset": "design.presets.model",
            "RenderJob": "offline.rendering.many",
            "RenderFileResult": "offline.rendering.offline",
            "RenderedJob": "offline.rendering.many",
            "RenderResult": "offline.rendering.offline",
            "Strikes": "signal.engine.memory_reader",
            "Surface": "signal.surface.model",
            "Timeline": "data.timeline.model",
            "Trace": "offline.rendering.trace",
            "actuators": "signal.actuators:",
            "arm": "design.gestures.scripts",
            "build_surface": "signal.surface.build",
            "bundled_presets": "design.presets.library",
            "export": "offline.export:",
            "flick": "design.gestures.scripts",
            "live": "live:",
            "load_actuator": "signal.actuators.library",
            "load_gesture": "design.gestures.take",
            "load_preset": "design.presets.library",
            "load_timeline": "data.readers.registry",
            "load_timelines": "data.readers.registry",
            "measure": "measure:",
            "parse_gesture": "design.gestures.spec",
            "pause": "design.gestures.scripts",
            "presets": "design.presets:",
            "render": "offline.rendering.offline",
            "render_jobs": "offline.rendering.many",
            "render_many": "offline.rendering.many",
            "render_to_file": "offline.rendering.offline",
            "save_gesture": "design.gestures.take",
            "save_timeline": "data.readers.native",
            "scrub": "design.gestures.scripts",
            "sweep": "design.gestures.scripts",
            "tap": "design.gestures.scripts",
            # private modules
            "engine": "signal.engine:",
            "gestures": "design.gestures:",
            "readers": "data.readers:",
            "rendering": "offline.rendering:",
            "surface": "signal.surface:",
            "timeline": "data.timeline:",
        },
    )
