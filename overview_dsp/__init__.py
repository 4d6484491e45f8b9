"""overView DSP: feel a timeline.

Temporal data becomes a surface with friction; a disk on a spring is pulled over it by the hand;
its torque is heard as friction clicks and felt as a 250 Hz vibration.

`ov.presets`, `ov.measure`, `ov.export`, `ov.live` and `ov.actuators` hold what designers, sound
people and performers need besides. What isn't in the reference (the `__all__` of these six) is
private and may move.

Importing this package compiles nothing and needs no sound card: each name is imported when it is
first used.

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
    from overview_dsp import actuators, export, live, measure, presets
    from overview_dsp.actuators.library import load_actuator
    from overview_dsp.actuators.model import Actuator
    from overview_dsp.engine.engine import Engine
    from overview_dsp.engine.meters import EngineParameter, Meters, Strikes
    from overview_dsp.following.live_timeline import LiveTimeline
    from overview_dsp.gestures.model import Gesture
    from overview_dsp.gestures.scripts import arm, flick, pause, scrub, sweep, tap
    from overview_dsp.gestures.spec import parse_gesture
    from overview_dsp.gestures.take import load_gesture, save_gesture
    from overview_dsp.presets.library import bundled_presets, load_preset
    from overview_dsp.presets.model import ClickMode, EventKind, Preset
    from overview_dsp.readers.native import save_timeline
    from overview_dsp.readers.registry import load_timeline
    from overview_dsp.rendering.many import RenderedJob, RenderJob, render_jobs, render_many
    from overview_dsp.rendering.offline import Rendered, Result, render, render_to_file
    from overview_dsp.rendering.trace import Trace
    from overview_dsp.surface.build import build_surface
    from overview_dsp.surface.model import Surface
    from overview_dsp.timeline.curve_builder import CurveBuilder
    from overview_dsp.timeline.even_times import EvenTimes
    from overview_dsp.timeline.event import Event
    from overview_dsp.timeline.intensity import Intensity
    from overview_dsp.timeline.model import Timeline

__version__ = "0.1.0"

__all__ = [
    "Actuator",
    "ClickMode",
    "CurveBuilder",
    "Engine",
    "EngineParameter",
    "EvenTimes",
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
    "RenderJob",
    "Rendered",
    "RenderedJob",
    "Result",
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


if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "Actuator": "actuators.model",
            "ClickMode": "presets.model",
            "CurveBuilder": "timeline.curve_builder",
            "Engine": "engine.engine",
            "EngineParameter": "engine.meters",
            "EvenTimes": "timeline.even_times",
            "Event": "timeline.event",
            "EventKind": "presets.model",
            "Gesture": "gestures.model",
            "Intensity": "timeline.intensity",
            "LiveTimeline": "following.live_timeline",
            "Meters": "engine.meters",
            "Preset": "presets.model",
            "RenderJob": "rendering.many",
            "Rendered": "rendering.offline",
            "RenderedJob": "rendering.many",
            "Result": "rendering.offline",
            "Strikes": "engine.meters",
            "Surface": "surface.model",
            "Timeline": "timeline.model",
            "Trace": "rendering.trace",
            "actuators": "",
            "arm": "gestures.scripts",
            "build_surface": "surface.build",
            "bundled_presets": "presets.library",
            "export": "",
            "flick": "gestures.scripts",
            "live": "",
            "load_actuator": "actuators.library",
            "load_gesture": "gestures.take",
            "load_preset": "presets.library",
            "load_timeline": "readers.registry",
            "measure": "",
            "parse_gesture": "gestures.spec",
            "pause": "gestures.scripts",
            "presets": "",
            "render": "rendering.offline",
            "render_jobs": "rendering.many",
            "render_many": "rendering.many",
            "render_to_file": "rendering.offline",
            "save_gesture": "gestures.take",
            "save_timeline": "readers.native",
            "scrub": "gestures.scripts",
            "sweep": "gestures.scripts",
            "tap": "gestures.scripts",
            # private, but there
            **dict.fromkeys(
                ("engine", "gestures", "readers", "rendering", "surface", "timeline"), ""
            ),
        },
    )
