"""overView DSP: feel a timeline.

Temporal data becomes a surface with friction; a disk on a spring is pulled over it by the hand;
its torque is heard as friction clicks and felt as a 250 Hz vibration.

    import overview_dsp as ov

    timeline = ov.load_timeline("match.json")
    result = ov.render(timeline, ov.load_preset("football"), ov.sweep(4.0))
    result.save("out.wav")

Importing this package compiles nothing and needs no sound card: each name is imported when it is
first used.
"""

from __future__ import annotations

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
    from overview_dsp.actuators import Actuator, load_actuator
    from overview_dsp.engine.engine import Engine
    from overview_dsp.engine.meters import Meters, Setting, Strikes
    from overview_dsp.gestures import (
        Gesture,
        load_gesture,
        parse_gesture,
        rest,
        save_gesture,
        sweep,
        tap,
    )
    from overview_dsp.presets import PARAMETERS, Kind, Mode, Parameter, Preset, bundled_names
    from overview_dsp.presets.library import load_preset
    from overview_dsp.readers import load_timeline, save_timeline
    from overview_dsp.rendering.many import Voice, VoiceResult, render_many, voices
    from overview_dsp.rendering.offline import Result, render, render_to_file
    from overview_dsp.rendering.trace import Trace
    from overview_dsp.surface.build import build_surface
    from overview_dsp.surface.model import Surface
    from overview_dsp.timeline import Event, Intensity, Timeline

__version__ = "0.1.0"

_ROOMS = {
    "actuators": ("Actuator", "load_actuator"),
    "engine": ("Engine", "Meters", "Setting", "Strikes"),
    "gestures": (
        "Gesture",
        "load_gesture",
        "parse_gesture",
        "rest",
        "save_gesture",
        "sweep",
        "tap",
    ),
    "presets": ("PARAMETERS", "Kind", "Mode", "Parameter", "Preset", "bundled_names"),
    "presets.library": ("load_preset",),
    "rendering": (
        "Result",
        "Trace",
        "Voice",
        "VoiceResult",
        "render",
        "render_many",
        "render_to_file",
        "voices",
    ),
    "surface": ("Surface", "build_surface"),
    "readers": ("load_timeline", "save_timeline"),
    "timeline": ("Event", "Intensity", "Timeline"),
}
_ROOM_OF = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = [
    "PARAMETERS",
    "Actuator",
    "Engine",
    "Event",
    "Gesture",
    "InputError",
    "Intensity",
    "Kind",
    "Meters",
    "Mode",
    "NotPreparedError",
    "OutputError",
    "OverviewError",
    "OverviewWarning",
    "Parameter",
    "Preset",
    "Result",
    "Setting",
    "Strikes",
    "Surface",
    "Timeline",
    "Trace",
    "Voice",
    "VoiceResult",
    "build_surface",
    "bundled_names",
    "load_actuator",
    "load_gesture",
    "load_preset",
    "load_timeline",
    "parse_gesture",
    "render",
    "render_many",
    "render_to_file",
    "rest",
    "save_gesture",
    "save_timeline",
    "sweep",
    "tap",
    "voices",
]


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name not in _ROOM_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_ROOM_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
