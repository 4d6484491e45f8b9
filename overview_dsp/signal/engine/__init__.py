"""The engine: prepare, control, process, reset; what it reports, saves and replays."""

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import EngineParameter, Meters, Strikes

__all__ = ["Engine", "EngineParameter", "Meters", "Strikes"]
