"""Command `overview learn`: a lesson about the feel of a preset, in the terminal or on a page."""

from __future__ import annotations

import json
import math
import time
from datetime import date
from pathlib import Path

from overview_dsp.cli.extensions import (
    SECONDS,
    Server,
    announce_compile,
    cli_command,
    ended_by_signals,
    exit_if_stopped,
    open_server,
    option,
    require_server,
    wait_for_end,
)


@cli_command("learn football", name="learn")
def command(
    preset: str,
    *,
    timeline: str | None = option(
        metavar="TIMELINE",
        help="Timeline from which examples are taken.  [default: the bundled match, for football]",
    ),
    again: bool = option(help="Repeat the whole lesson, not the questions alone."),
    page: bool = option(help="Serve the lesson as a page, until Ctrl-C."),
    device: str | None = option(
        metavar="NAME", help="Output: name or number of overview devices; pad; none."
    ),
    scores: str | None = option(
        metavar="FILE", help="File of the scores.  [default: in the data folder of the user]"
    ),
    seconds: float | None = SECONDS,
    as_json: bool = option("--json", help="Report each step as one line of JSON."),
    server: Server,
) -> None:
    """Learn what the events of PRESET feel like, in about three minutes.

    Each kind of event is played alone with its name, then in pairs, then among others. Ten
    questions follow. The score is stored, and on a later day the command asks again. A lesson that
    was interrupted continues at the same step.
    """
    from overview_studies.lesson import make_lesson
    from overview_studies.lesson_scores import Attempt

    announce_compile()

    def begin(again: bool) -> Attempt:
        return Attempt(
            None if scores is None else Path(scores),
            preset,
            lambda seed: make_lesson(preset, timeline, seed),
            date.today().isoformat(),
            again,
        )

    if page:
        require_server()
        from overview_studies.lesson_routes import lesson_paths, lesson_routes

        with (
            ended_by_signals() as received,
            open_server(server, None, lesson_routes(begin, again), public=lesson_paths()) as opened,
        ):
            if as_json:
                print(json.dumps({"address": opened.address}), flush=True)
            wait_for_end(received, seconds)
        exit_if_stopped(received)
        return
    from overview_studies.lesson_sound import Sound
    from overview_studies.lesson_terminal import TerminalLesson, terminal_keys

    attempt = begin(again)
    until = math.inf if seconds is None else time.monotonic() + seconds
    with ended_by_signals() as received:

        def stopped() -> bool:
            return bool(received) or time.monotonic() >= until

        with Sound(attempt.lesson, device) as sound, terminal_keys(stopped) as read_key:
            TerminalLesson(
                attempt, lambda example: sound.play(example, stopped), read_key, as_json
            ).run()
    exit_if_stopped(received)
