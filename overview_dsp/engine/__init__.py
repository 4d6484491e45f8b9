"""The engine: prepare, control, process, reset; what it reports, saves and replays."""

from overview_dsp.engine.engine import Engine
from overview_dsp.engine.meters import Meters, Setting, Strikes

__all__ = ["Engine", "Meters", "Setting", "Strikes"]
