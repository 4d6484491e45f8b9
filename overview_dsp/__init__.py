"""overView DSP: feel a timeline.

Temporal data becomes a surface with friction; a disk on a spring is pulled over it by the hand;
its torque is heard as friction clicks and felt as a 250 Hz vibration.

    import overview_dsp as ov

    timeline = ov.load_timeline("match.json")
    result = ov.render(timeline, ov.load_preset("football"), ov.sweep(4.0))
    result.save("out.wav")

`ov.presets`, `ov.measure`, `ov.export`, `ov.live` and `ov.actuators` hold what designers, sound
people and performers need besides. What isn't in the reference is private.

Importing this package compiles nothing and needs no sound card: each name is imported when it is
first used.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

from overview_dsp.errors import (
    InputError,
    NotPreparedError,
    OutputError,
    OverviewError,
    OverviewWarning,
)

if TYPE_CHECKING:
    from overview_dsp import actuators, export, live, measure, presets
    from overview_dsp.actuators import Actuator, load_actuator
    from overview_dsp.engine import Engine, EngineParameter, Meters, Strikes
    from overview_dsp.gestures import (
        Gesture,
        load_gesture,
        parse_gesture,
        pause,
        save_gesture,
        sweep,
        tap,
    )
    from overview_dsp.presets import ClickMode, EventKind, Preset, bundled_presets, load_preset
    from overview_dsp.readers import load_timeline, save_timeline
    from overview_dsp.rendering import (
        RenderedJob,
        RenderJob,
        Result,
        Trace,
        render,
        render_jobs,
        render_many,
        render_to_file,
    )
    from overview_dsp.surface import Surface, build_surface
    from overview_dsp.timeline import Event, Intensity, Timeline

__version__ = "0.1.0"

_EXPORTS = {
    "actuators": ("Actuator", "load_actuator"),
    "engine": ("Engine", "EngineParameter", "Meters", "Strikes"),
    "gestures": (
        "Gesture",
        "load_gesture",
        "parse_gesture",
        "pause",
        "save_gesture",
        "sweep",
        "tap",
    ),
    "presets": ("ClickMode", "EventKind", "Preset", "bundled_presets", "load_preset"),
    "readers": ("load_timeline", "save_timeline"),
    "rendering": (
        "RenderJob",
        "RenderedJob",
        "Result",
        "Trace",
        "render",
        "render_jobs",
        "render_many",
        "render_to_file",
    ),
    "surface": ("Surface", "build_surface"),
    "timeline": ("Event", "Intensity", "Timeline"),
}
_FACES = ("actuators", "export", "live", "measure", "presets")
_PACKAGE_OF = {name: package for package, names in _EXPORTS.items() for name in names}
# old name: where it is now; to go with the release after 0.2
_RENAMED = {
    "Kind": "EventKind",
    "Mode": "ClickMode",
    "PARAMETERS": "presets.PARAMETERS",
    "Parameter": "presets.Parameter",
    "Setting": "EngineParameter",
    "Voice": "RenderJob",
    "VoiceResult": "RenderedJob",
    "bundled_names": "bundled_presets",
    "rest": "pause",
    "voices": "render_jobs",
}

__all__ = [
    "Actuator",
    "ClickMode",
    "Engine",
    "EngineParameter",
    "Event",
    "EventKind",
    "Gesture",
    "InputError",
    "Intensity",
    "Meters",
    "NotPreparedError",
    "OutputError",
    "OverviewError",
    "OverviewWarning",
    "Preset",
    "RenderJob",
    "RenderedJob",
    "Result",
    "Strikes",
    "Surface",
    "Timeline",
    "Trace",
    "actuators",
    "build_surface",
    "bundled_presets",
    "export",
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
    "sweep",
    "tap",
]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS or name in _FACES:
        return import_module(f"{__name__}.{name}")
    if name in _RENAMED:
        now = _RENAMED[name]
        warnings.warn(f"ov.{name} is ov.{now} now", DeprecationWarning, stacklevel=2)
        value: Any = import_module(__name__)
        for part in now.split("."):
            value = getattr(value, part)
        return value
    if name not in _PACKAGE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_PACKAGE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
