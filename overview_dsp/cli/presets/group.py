"""Command group to which the other modules of this package add commands."""

from __future__ import annotations

import click


@click.group(name="presets", epilog="Example: overview presets show football")
def command() -> None:
    """List, make, compare and measure presets."""
