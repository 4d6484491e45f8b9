"""The options of an observer: what it gets, whose hands move, which random numbers."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

MODALITIES = ("touch", "sound", "both")
HANDS = ("all", "steady", "arm", "mixed")


def observer_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options to a command, which gets those that were given as the argument `asked`.

    They are arguments of `measure.observe`.
    """

    @functools.wraps(function)
    def collected(
        *arguments: Any,
        modality: tuple[str, ...],
        hands: str | None,
        seed: int | None,
        **named: Any,
    ) -> Any:
        given = {"modalities": modality or None, "hands": hands, "seed": seed}
        asked = {name: value for name, value in given.items() if value is not None}
        return function(*arguments, asked=asked, **named)

    for decorate in (
        click.option("--seed", type=click.IntRange(min=0), help="Of the observer.  [default: 0]"),
        click.option(
            "--hands",
            type=click.Choice(HANDS),
            help="An observer's strokes: steady (sweeps, a tap, the recoil), arm (releases early), "
            "all of these, or mixed (speeds up, hesitates, turns back).  [default: all]",
        ),
        click.option(
            "--modality",
            multiple=True,
            type=click.Choice(MODALITIES),
            help="What an observer gets; may be repeated.  [default: all three]",
        ),
    ):
        collected = decorate(collected)
    return collected
