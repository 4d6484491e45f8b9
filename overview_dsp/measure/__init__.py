"""What a finger or an ear gets: felt levels by stroke and event, onsets in the clicks."""

from overview_dsp.measure.feel_report import FeelReport, feel_report

__all__ = ["FeelReport", "feel_report"]
