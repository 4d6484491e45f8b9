"""Public names of `ov`, each imported when it is first used."""

from overview_dsp import live as live, measure as measure
from overview_dsp.data.feeds.live_timeline import LiveTimeline as LiveTimeline
from overview_dsp.data.readers.native import save_timeline as save_timeline
from overview_dsp.data.readers.registry import load_timeline as load_timeline
from overview_dsp.data.readers.registry import load_timelines as load_timelines
from overview_dsp.data.timeline.curve_builder import CurveBuilder as CurveBuilder
from overview_dsp.data.timeline.curve_points import RegularTimes as RegularTimes
from overview_dsp.data.timeline.event import Event as Event
from overview_dsp.data.timeline.intensity import Intensity as Intensity
from overview_dsp.data.timeline.model import Timeline as Timeline
from overview_dsp.design import presets as presets
from overview_dsp.design.gestures.model import Gesture as Gesture
from overview_dsp.design.gestures.scripts import (
    arm as arm,
    flick as flick,
    pause as pause,
    scrub as scrub,
    sweep as sweep,
    tap as tap,
)
from overview_dsp.design.gestures.spec import parse_gesture as parse_gesture
from overview_dsp.design.gestures.take import (
    load_gesture as load_gesture,
    save_gesture as save_gesture,
)
from overview_dsp.design.presets.library import (
    bundled_presets as bundled_presets,
    load_preset as load_preset,
)
from overview_dsp.design.presets.model import (
    ClickMode as ClickMode,
    EventKind as EventKind,
    Preset as Preset,
)
from overview_dsp.errors import (
    InputError as InputError,
    NotPreparedError as NotPreparedError,
    OutputError as OutputError,
    OverviewError as OverviewError,
    OverviewWarning as OverviewWarning,
)
from overview_dsp.offline import export as export
from overview_dsp.offline.rendering.many import (
    RenderJob as RenderJob,
    RenderedJob as RenderedJob,
    render_jobs as render_jobs,
    render_many as render_many,
)
from overview_dsp.offline.rendering.offline import (
    RenderFileResult as RenderFileResult,
    RenderResult as RenderResult,
    render as render,
    render_to_file as render_to_file,
)
from overview_dsp.offline.rendering.trace import Trace as Trace
from overview_dsp.signal import actuators as actuators
from overview_dsp.signal.actuators.library import load_actuator as load_actuator
from overview_dsp.signal.actuators.model import Actuator as Actuator
from overview_dsp.signal.engine.engine import Engine as Engine
from overview_dsp.signal.engine.memory_reader import (
    EngineParameter as EngineParameter,
    Meters as Meters,
    Strikes as Strikes,
)
from overview_dsp.signal.surface.build import build_surface as build_surface
from overview_dsp.signal.surface.model import Surface as Surface

__version__: str
