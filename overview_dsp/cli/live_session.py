"""Shared parts of live commands: session options, the player, play without a screen."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from overview_dsp.cli.common import note, say
from overview_dsp.cli.options.declaring import option, require_none
from overview_dsp.cli.options.follow import OpenedData
from overview_dsp.cli.options.input import FORCE_BLOCK
from overview_dsp.cli.options.output import Output, callback_kind, output_changes
from overview_dsp.cli.options.reading import PRESET
from overview_dsp.cli.signals import ended_by_signals
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.design.gestures import Gesture
    from overview_dsp.live.inputs.input import Input
    from overview_dsp.live.session.headless import Passed
    from overview_dsp.live.session.player import Player

BLOCK = 256
"""Default block size, frames."""

SEED = option(default=0, type=int)


@dataclass(frozen=True)
class Session:
    """Options of a session on this machine."""

    heading: ClassVar[str] = "Session"

    record: str | None = option(metavar="TAKE.csv")
    seed: int = SEED


@dataclass(frozen=True)
class Comparison:
    """Options of a second preset, and of a blind comparison with it."""

    heading: ClassVar[str] = PRESET

    compare: str | None = option(metavar="PRESET")
    blind: bool = option()

    def require_consistent(
        self, record: str | None, remote: str | None, screen: str | None, has_keys: bool
    ) -> None:
        """Check the options beside --blind; click.UsageError."""
        problems = {
            "--blind needs a second preset: --compare PRESET": self.compare is None,
            "--blind restarts the engine, which ends a take; remove --record": record is not None,
            "--blind doesn't apply to --remote, whose page shows the preset": remote is not None,
            "--blind doesn't apply to --screen full, which shows the presets": screen == "full",
            "--blind needs a terminal for its keys, or --input with commands": not has_keys,
        }
        if self.blind:
            require_none(problems)

    def begin(self, player: Player, take: str, gesture: Gesture | None, repeats: bool) -> None:
        """Begin a blind comparison of the player's presets by a take, or by the user's hand.

        The levels are matched over the take, or a sweep of 4 s. The answers are stored beside the
        take.
        """
        from overview_dsp.design.gestures import sweep
        from overview_dsp.live.session.blind import BlindComparison
        from overview_dsp.measure.level_matching import match_levels

        window, stem = player.active_window, os.path.splitext(take)[0] + "."
        second, first = window.presets.choose(1), window.presets.choose(0)
        moved = gesture or sweep(4.0)
        *matched, report = match_levels(first, second, window.window_timeline, moved)
        name = f"{stem if os.path.exists(take) else ''}blind-{time.strftime('%Y%m%d-%H%M%S')}.csv"
        player.blind = BlindComparison(player, matched, Path(name), gesture, repeats)
        note(report)
        note("blind comparison: press a, b or x to feel; A or B (with Shift) answers; q ends")


def check_seconds(context: Any, parameter: Any, seconds: float | None) -> float | None:
    """Check a duration (s); NaN fails."""
    if seconds is not None and not 0.0 <= seconds < math.inf:
        raise InputError(f"--seconds is {seconds:g}; must be 0 or more")
    return seconds


SECONDS = option(heading=Session.heading, metavar="S", callback=check_seconds)


@contextmanager
def open_player(
    data: OpenedData,
    output: Output,
    session: Session,
    linear: bool = False,
    compare: str | None = None,
    force: bool = False,
) -> Iterator[tuple[Player, list[int]]]:
    """Open a player on the selected device, and collect the signals that end it.

    Afterwards it is closed, and takes and device settings are saved. `compare` is a second preset;
    `linear` removes the angle maps of presets; `force` is for a motor, which needs short blocks.

    OverviewError: a device, file or value can't be used.
    """
    from overview_dsp.live.session.player import OpenedPlayer, PlayerSettings

    default_block = FORCE_BLOCK if force else BLOCK
    settings = PlayerSettings(
        data.preset,
        compare,
        linear,
        data.window,
        data.follow,
        device=output.device,
        block_size=default_block if output.block_size is None else output.block_size,
        sample_rate=output.sample_rate,
        callback=callback_kind(),
        actuator=output.actuator,
        record=session.record,
        seed=session.seed,
        marks=data.marks,
        **output_changes(output.settings),
    )
    opened = OpenedPlayer(data.timeline, settings, note, say)
    with ended_by_signals(opened.player.takes.end) as received, opened as player:
        yield player, received


def play_headless(
    player: Player,
    source: Input | None,
    received: list[int],
    seconds: float | None,
    events_sent: bool = False,
) -> None:
    """Play with one line of JSON per second; the last lists the events, unless OSC sends them."""
    from overview_dsp.live.session.headless import run

    def describe(passed: list[Passed]) -> dict[str, Any]:
        from overview_dsp.offline.rendering.event_log import as_records, of_events

        times, events, levels = zip(*passed, strict=True) if passed else ((), (), ())
        timeline = player.engine.timeline
        return {"events": as_records(of_events(times, levels, events, timeline))}

    for report in run(
        player, source, lambda: bool(received), note, seconds, None if events_sent else describe
    ):
        print(json.dumps(report), flush=True)
    player.close()  # the output is silent before the caller continues
