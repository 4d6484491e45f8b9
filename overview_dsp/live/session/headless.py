"""Session without a terminal: one JSON line per second, and a summary."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from overview_dsp.data.timeline import Event
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.session.commands import poll
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.session import Status
from overview_dsp.signal.actuators.stage import protection_json
from overview_dsp.units import gain_to_db

POLL_EVERY_S = 0.02
LINE_EVERY_S = 1.0
Passed = tuple[float, Event, float]
"""Time (s) at which an event was passed, within `POLL_EVERY_S`; the event; its click amplitude."""

MAX_PASSED = 10_000
"""Maximum number of passed events in a summary; the oldest are discarded."""


def run(
    player: Player,
    source: Input | None,
    stopped: Callable[[], bool],
    note: Callable[[str], None],
    seconds: float | None = None,
    describe: Callable[[list[Passed]], dict[str, Any]] | None = None,
) -> Iterator[dict[str, Any]]:
    """Play until the source or replay ends and the disk rests, `seconds` pass, or `stopped()`.

    Yields one report per second, then a summary that includes `describe` of the passed events.
    Without `describe` the engine's log of passed events isn't read, so that another reader gets it.
    `note` receives each message at once.
    """
    started = last = time.monotonic()
    replayed = player.loop.playing
    click = tactor = 0.0
    passed: list[Passed] = []
    while True:
        status = poll(player, source)
        for message in status.messages:
            note(message)
        if describe is not None:
            struck = player.engine.pop_strike_events()
            passed += [(status.time_s, event, level) for event, level in struck]
            del passed[:-MAX_PASSED]
        click, tactor = max(click, status.peak_click), max(tactor, status.peak_tactor)
        now = time.monotonic()
        if now - last >= LINE_EVERY_S:
            last += LINE_EVERY_S
            yield {**_line(status, click, tactor), **_input(source)}
            click = tactor = 0.0
        late = seconds is not None and now - started >= seconds
        if is_over(player, source, replayed) or stopped() or late:
            break
        time.sleep(POLL_EVERY_S)
    described = describe(passed) if describe is not None else {}
    last_status = poll(player)
    for message in last_status.messages:
        note(message)
    yield {"summary": {**_summary(last_status), **_input(source), **described}}


def is_over(player: Player, source: Input | None, replayed: bool) -> bool:
    """Return whether the source, or without one the replay, is over, with its sound."""
    if source is not None:
        return source.is_over(player.engine) and player.at_rest
    return replayed and not player.loop.playing


def _input(source: Input | None) -> dict[str, Any]:
    report = {} if source is None else dict(source.report())
    return {"input": report} if report else {}


def _counts(status: Status) -> dict[str, Any]:
    return {
        "blocks": status.stream.callbacks, "late_callbacks": status.stream.late,
        "underflows": status.stream.underflows, "frames_lost": status.frames_lost,
        "dropped_events": status.dropped,
    }  # fmt: skip


def _line(status: Status, click: float, tactor: float) -> dict[str, Any]:
    return {
        "state": vars(status.state), "time_s": round(status.time_s, 3),
        "cursor": round(status.cursor, 6), "touching": status.touching, "torque_nm": status.torque,
        "peak_click_dbfs": _db(click), "peak_tactor_dbfs": _db(tactor), **_counts(status),
        **({} if status.following is None else {"following": status.following}),
    }  # fmt: skip


def _summary(status: Status) -> dict[str, Any]:
    return {
        "state": vars(status.state), "output": status.output, "callback": status.callback,
        "sample_rate": status.sample_rate, "block_size": status.block_size,
        "latency_ms": round(status.stream.latency_s * 1e3, 3), "time_s": round(status.time_s, 3),
        **_counts(status), "frames": status.stream.frames,
        "dsp_load_percent": round(100.0 * status.stream.load, 2),
        "callback_p50_us": round(status.stream.median_s * 1e6, 2),
        "callback_p99_us": round(status.stream.p99_s * 1e6, 2),
        "callback_max_us": round(status.stream.longest_s * 1e6, 2),
        "actuator": protection_json(status.settings.actuator, status.protected),
        "recording": status.recording,
    }  # fmt: skip


def _db(peak: float) -> float | None:
    return round(gain_to_db(peak), 1) if peak > 0.0 else None
