"""Engine: block processor, its meters and strikes, saved state and replay."""

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.memory_reader import EngineParameter, Meters, Strikes

__all__ = ["Engine", "EngineParameter", "Meters", "Strikes"]
