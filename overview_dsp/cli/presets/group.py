"""`overview presets`: the group, to which the modules beside it add their commands."""

from __future__ import annotations

import click


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """Read, make, compare and hear presets."""
