"""What commands that play live share: options of the session, the player, lines of JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from overview_dsp.cli.common import note, say
from overview_dsp.cli.options.declaring import option
from overview_dsp.cli.options.follow import OpenedData
from overview_dsp.cli.options.output import Output, callback_kind, output_changes
from overview_dsp.cli.signals import ended_by_signals
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.session.headless import Passed
    from overview_dsp.live.session.player import Player

BLOCK = 256
"""Frames of a block, if no size is given."""

SEED = option("Seed of the texture noise.", default=0, type=int)


@dataclass(frozen=True)
class Session:
    """Options of a session that plays here."""

    heading: ClassVar[str] = "Session"

    record: str | None = option(
        "Record the session; the take replays bit-identical.", metavar="TAKE.csv"
    )
    seed: int = SEED


def seconds_given(context: Any, parameter: Any, seconds: float | None) -> float | None:
    """Return how long to play; written so that NaN fails."""
    if seconds is not None and not 0.0 <= seconds < math.inf:
        raise InputError(f"--seconds {seconds:g}; it is 0 or more")
    return seconds


SECONDS = option(
    "Stop after S seconds.", heading=Session.heading, metavar="S", callback=seconds_given
)


@contextmanager
def opened_player(
    data: OpenedData,
    output: Output,
    session: Session,
    linear: bool = False,
    compare: str | None = None,
    usual_block: int = BLOCK,
) -> Iterator[tuple[Player, list[int]]]:
    """Open a player on the device that was chosen, and collect the signals that ask for its end.

    It is closed, saved and remembered afterwards. `compare` is a second preset to switch to;
    `linear` leaves the presets' angle maps out.

    Raises
    ------
    OverviewError
        A device, file or value that can't be used.
    """
    from overview_dsp.live.session.opened import OpenedPlayer, PlayerSettings

    settings = PlayerSettings(
        data.preset,
        compare,
        linear,
        data.window,
        data.growth,
        device=output.device,
        block_size=usual_block if output.block_size is None else output.block_size,
        sample_rate=output.sample_rate,
        callback=callback_kind(),
        actuator=output.actuator,
        record=session.record,
        seed=session.seed,
        **output_changes(output.settings),
    )
    opened = OpenedPlayer(data.timeline, settings, note, say)
    with ended_by_signals(opened.player.takes.end) as received, opened as player:
        yield player, received


def print_lines(
    player: Player,
    source: Input | None,
    received: list[int],
    seconds: float | None,
    logged: bool = False,
) -> None:
    """Play with a line of JSON a second; the last one lists the events, unless it is `logged`."""
    from overview_dsp.live.session.headless import run

    def describe(passed: list[Passed]) -> dict[str, Any]:
        from overview_dsp.offline.rendering.event_log import as_records, of_events

        times, events, levels = zip(*passed, strict=True) if passed else ((), (), ())
        timeline = player.engine.timeline
        return {"events": as_records(of_events(times, levels, events, timeline))}

    for report in run(
        player, source, lambda: bool(received), note, seconds, None if logged else describe
    ):
        print(json.dumps(report), flush=True)
    player.close()  # before anything else that may take its time
