"""Presets tuned by search: kinds ordered by strength, or just made distinguishable."""

from overview_dsp.measure.tuning.in_crowd import tuned_on
from overview_dsp.measure.tuning.moves import Tuned
from overview_dsp.measure.tuning.ordering import tuned
from overview_dsp.measure.tuning.separating import separated

__all__ = ["Tuned", "separated", "tuned", "tuned_on"]
