"""The command `overview serve`: a page for a phone or a browser."""

from __future__ import annotations

import json
import math
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from overview_dsp.cli.common import note
from overview_dsp.cli.live_session import SECONDS, Session, open_player, play_headless
from overview_dsp.cli.options.declaring import cli_command, option, refuse_options
from overview_dsp.cli.options.follow import Feed, open_data
from overview_dsp.cli.options.output import Output
from overview_dsp.cli.options.reading import PresetChoice, Reading, Window
from overview_dsp.cli.options.server import Server, require_server
from overview_dsp.cli.signals import ended_by_signals, exit_if_stopped, wait_for_end
from overview_dsp.errors import InputError
from overview_dsp.validation import float_or_nan

if TYPE_CHECKING:
    from overview_dsp.web.media import Media

PAGE = "Page"


@cli_command(
    "serve world-cup-final-2018 --host 0.0.0.0 --audio host",
    name="serve",
    first="preset window follow audio media host port device record as_json",
)
def command(
    timeline: str | None,
    *,
    reading: Reading,
    window: Window,
    choice: PresetChoice,
    feed: Feed,
    audio: str = option(heading=PAGE, type=click.Choice(["here", "host"]), default="here"),
    media: str | None = option(heading=PAGE, metavar="FILE[,offset=S]"),
    publish: str | None = option(heading=PAGE, metavar="DIR"),
    as_json: bool = option("--json", heading=PAGE),
    server: Server,
    output: Output,
    session: Session,
    seconds: float | None = SECONDS,
) -> None:
    """Serve a page to play TIMELINE in a browser or on a phone, until Ctrl-C.

    Other machines (--host) get https and a QR code with the address. The page is open to
    anyone with the printed address. With --audio host the page is only the input, and this
    machine plays the sound: the options under Output and Session are those of overview play.
    """
    if publish is not None and feed.follow is None:
        raise click.UsageError(
            "--publish needs --follow; use overview export --to web for a finished timeline"
        )
    with ExitStack() as stack:
        data = stack.enter_context(open_data(timeline, feed, reading, window, choice.preset))
        require_server()
        if audio == "here":
            refuse_options("needs --audio host", Output, Session)
        film = None if media is None else _film(media)
        if publish is not None and data.follow is not None:
            from overview_dsp.web.static_publisher import StaticPublisher

            preset = choice.load(data.preset)
            stack.callback(StaticPublisher(data.follow.live, preset, publish, note).close)
        if audio == "host":
            from overview_dsp.web.session import HostSession

            player, received = stack.enter_context(
                open_player(data, output, session, choice.linear)
            )
            host = HostSession(player)
        else:
            received, host = stack.enter_context(ended_by_signals()), None
        opened = stack.enter_context(data.served(server, host, choice.linear, film))
        if as_json:
            sha256 = opened.fingerprint_sha256
            print(json.dumps({"address": opened.address, "fingerprint_sha256": sha256}), flush=True)
        if host is None:
            wait_for_end(received, seconds)
        else:
            play_headless(host.player, host, received, seconds)
    exit_if_stopped(received)


def _film(text: str) -> Media:
    from overview_dsp.web.media import open_media

    path, comma, offset = text.rpartition(",offset=")
    offset_s = float_or_nan(offset) if comma else 0.0
    if not math.isfinite(offset_s):
        raise InputError(f"--media is {text}; offset must be a number of seconds, such as 754")
    return open_media(path if comma else text, offset_s)
