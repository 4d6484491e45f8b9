"""`overview serve`: the page, for a phone or a browser."""

from __future__ import annotations

import json
import time
from contextlib import ExitStack
from typing import Any

import click

from overview_dsp.cli.common import note, part_of, window_options
from overview_dsp.cli.live_session import (
    ended_by_signals,
    exit_if_stopped,
    live_options,
    opened_player,
    print_lines,
    seconds_given,
)
from overview_dsp.cli.options.follow import follow_options, followed, laid_out, open_growing
from overview_dsp.cli.options.server import (
    Opened,
    open_server,
    refuse_given,
    require_server,
    server_options,
)
from overview_dsp.cli.options.timeline import (
    linear_option,
    preset_for,
    preset_option,
    timeline_options,
)

LOOK_EVERY_S = 0.1


@click.command(
    name="serve",
    epilog="Example: overview serve world-cup-final-2018 --host 0.0.0.0 --audio host",
)
@click.argument("timeline", required=False)
@follow_options
@preset_option
@linear_option
@click.option("--audio", type=click.Choice(["here", "host"]), default="here", show_default=True,
              help="What makes the sound: the page, or this machine's output.")  # fmt: skip
@window_options
@click.option("--media", metavar="FILE", help="A film or recording of it, to play from a moment.")
@click.option("--media-offset", type=float, default=0.0, show_default=True, metavar="S",
              help="Where in it the timeline's time 0 is.")  # fmt: skip
@click.option("--publish", metavar="DIR", help="With --follow: keep a folder up with it too, for "
              "any web host.")  # fmt: skip
@click.option("--seconds", type=float, callback=seconds_given, help="Stop after so long.")
@click.option("--json", "as_json", is_flag=True, help="The address as a line of JSON.")
@server_options
@timeline_options
@live_options
def command(
    timeline: str | None,
    following: dict[str, Any],
    preset: str | None,
    linear: bool,
    audio: str,
    window: tuple[str, str] | None,
    zoom_to: str | None,
    media: str | None,
    media_offset: float,
    publish: str | None,
    seconds: float | None,
    as_json: bool,
    server: dict[str, Any],
    load: dict[str, Any],
    **live: Any,
) -> None:
    """Serve a page on which TIMELINE is dragged, tapped and let go, until Ctrl-C.

    Beyond this machine (--host) it is served with https, and a QR code holds its address. Whoever
    has the printed address may use it. With --audio host the page is the hand, and the disk is
    heard and felt here: the options from --device on are those of `overview play`.
    """
    with ExitStack() as stack:
        growth = stack.enter_context(followed(timeline, following, load))
        if publish is not None and growth is None:
            raise click.UsageError(
                "--publish is for --follow; overview export --to web has the rest"
            )
        data = open_growing(timeline, load, growth)
        part = part_of(data, window, zoom_to)
        if part is not None and window and growth is None:
            data, part = data.window(*part), None
        name = preset_for(data, preset if growth is None else preset or growth.preset)
        data = laid_out(data, growth, name)
        require_server()
        if audio == "here":
            refuse_given(live, "is for --audio host; the page sounds by itself")
        from overview_dsp.web.data import data_routes
        from overview_dsp.web.media import open_media

        film = None
        if media is not None:
            film = open_media(media, media_offset)
        routes = data_routes(
            data,
            name,
            audio=audio,
            first=part,
            media=film,
            live=None if growth is None else growth.live,
            linear=linear,
        )
        if publish is not None and growth is not None:
            from overview_dsp.design.presets.library import load_preset
            from overview_dsp.signal.surface.angle_map import without_map
            from overview_dsp.web.published import Published

            chosen = load_preset(name)
            chosen = without_map(chosen) if linear else chosen
            stack.callback(Published(growth.live, chosen, publish, note).close)
        if audio == "host":
            from overview_dsp.web.session import HostSession

            with opened_player(data, part, name, live, None, growth, linear) as (player, received):
                session = HostSession(player)
                with open_server(server, session, routes, growth is not None) as opened:
                    _report(opened, as_json)
                    print_lines(player, session, received, seconds)
        else:
            with (
                ended_by_signals() as received,
                open_server(server, None, routes, growth is not None) as opened,
            ):
                _report(opened, as_json)
                _wait(received, seconds)
    exit_if_stopped(received)


def _report(opened: Opened, as_json: bool) -> None:
    if as_json:
        report = {
            "address": opened.address,
            "fingerprint_sha256": opened.fingerprint_sha256,
        }
        print(json.dumps(report), flush=True)


def _wait(received: list[int], seconds: float | None) -> None:
    until = None if seconds is None else time.monotonic() + seconds
    while not received and (until is None or time.monotonic() < until):
        time.sleep(LOOK_EVERY_S)
