"""The command group `overview presets`."""

from overview_dsp.cli.presets import create, inspect, measure
from overview_dsp.cli.presets.inspect import command

__all__ = ["command", "create", "inspect", "measure"]
