"""Actuators: what a tactor, a coil or a pair of headphones can do, and what it may be given."""

from overview_dsp.actuators.library import actuator_names, load_actuator
from overview_dsp.actuators.model import Actuator
from overview_dsp.actuators.stage import ActuatorStage

__all__ = ["Actuator", "ActuatorStage", "actuator_names", "load_actuator"]
