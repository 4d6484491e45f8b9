"""The data of a page: what it shows, what it sounds with, what it may keep.

| path | answers |
|---|---|
| `GET /data/...json`, `/sound/...` | the files that a folder has (`site_content`) |
| `POST /data/window`, `/sound/change` | any window, any preset (`sound_data`) |
| `GET /data/presets`, `/data/preset?name=NAME` | names; a preset and the parameter table |
| `GET /preset/changes` | the served preset, whenever its file was saved on the desk |
| `POST /preset/toml` | a preset's file, to download |
| `PUT /preset/NAME?replace=1` | keeps a preset file in the person's own folder |
| `GET /media` | the film, in ranges |

`GET /live/...` of a timeline that grows are `live_data`'s.

``server`` of ``data/timeline.json`` is ``{"audio": "here" or "host", "window": [start_s, end_s],
"media": {"url", "type", "offset_s"} or null}``: what sounds, the first window, the film. A page
that is opened again is felt by the preset's file as it is then.

``/preset/changes`` are server-sent events: first the preset as it is, then each time its file has
changed and is whole, as ``/data/preset`` has it. A file that isn't valid is told as ``event:
refused`` with the line that says why; the last good one goes on.

Bad input is 400 and one line. What takes long is done one after the other, in a thread: a page
can't take more than one core, and no Python here is in the way of a native audio callback.

Thread: the server's; what reads or makes something is its workers'.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import AsyncIterator
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.library import load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.errors import InputError
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.signal.surface.angle_map import without_map
from overview_dsp.web import sound_data
from overview_dsp.web.live_data import LiveData
from overview_dsp.web.media import Media
from overview_dsp.web.messages import json_object
from overview_dsp.web.preset_data import (
    as_toml,
    preset_data,
    preset_named,
    preset_names,
    save_own,
)
from overview_dsp.web.security.request_body import answering
from overview_dsp.web.site_content import SiteContent

BINARY, JSON = "application/octet-stream", "application/json"
TIMELINE_FILE, POINTS_FILE = "data/timeline.json", "data/points-0.json"
LEVELS = 4
"""How many times a served page zooms, each time to a third."""

LOOK_EVERY_S = 0.1
ALIVE_EVERY = 50
"""Looks after which a line is sent in any case: a dead connection is noticed."""


def data_routes(
    timeline: Timeline,
    preset: str,
    *,
    audio: str = "here",
    first: tuple[float, float] | None = None,
    media: Media | None = None,
    live: LiveTimeline | None = None,
    linear: bool = False,
) -> list[BaseRoute]:
    """The routes of a timeline.

    Parameters
    ----------
    preset
        The preset it is felt with, a name or a path.
    audio
        Where it sounds, "here" or "host".
    first
        The part (s) that is shown first.
    media
        The film of it.
    live
        What grows; `timeline` is its snapshot then.
    linear
        Whether presets are used without their angle map.
    """
    one_at_a_time = threading.Lock()
    known = preset_names()
    named = preset in (*known["bundled"], *known["own"])
    given = load_preset(preset)

    def fitted(preset: Preset) -> Preset:
        return without_map(preset) if linear else preset

    def served() -> Preset:
        return fitted(load_preset(preset))  # as its file is now

    def chosen(name: str) -> Preset:
        return served() if name == given.name and not named else fitted(preset_named(name))

    def now() -> Timeline:
        return timeline if live is None else live.felt()

    def made() -> SiteContent:
        version = None if live is None else live.revision
        present = now()
        server: dict[str, Any] = {
            "audio": audio,
            "window": list(first or (0.0, present.duration_s)),
            "media": None if media is None else media.describe(),
        }
        return SiteContent(
            present,
            served(),
            levels=LEVELS,
            server=server,
            live=None if live is None else {"levels": LEVELS, "version": version},
        )

    content = made()

    def file(request: Request, body: bytes) -> Response:
        nonlocal content
        name = request.url.path.removeprefix("/")
        with one_at_a_time:
            if name in (TIMELINE_FILE, POINTS_FILE) and (
                served() != content.preset or now() is not content.timeline
            ):
                content = made()
            if name not in content.names:
                return PlainTextResponse("not found\n", 404)
            kind = JSON if name.endswith(".json") else BINARY
            return Response(content.make(name), media_type=kind)

    def window(request: Request, body: bytes) -> Response:
        asked = json_object(body)
        with one_at_a_time:
            return JSONResponse(sound_data.window(now(), content.preset, asked))

    def names(request: Request, body: bytes) -> Response:
        return JSONResponse(preset_names())

    def one(request: Request, body: bytes) -> Response:
        name = request.query_params.get("name")
        return JSONResponse(preset_data(content.preset if name is None else chosen(name)))

    async def changes(request: Request) -> Response:
        return StreamingResponse(
            _preset_events(preset, linear),
            headers={"cache-control": "no-store"},
            media_type="text/event-stream",
        )

    def change(request: Request, body: bytes) -> Response:
        asked = json_object(body)
        with one_at_a_time:
            return Response(sound_data.change(now(), content.preset, asked), media_type=BINARY)

    def toml(request: Request, body: bytes) -> Response:
        return PlainTextResponse(as_toml(json_object(body)))

    def keep(request: Request, body: bytes) -> Response:
        try:
            text = body.decode()
        except UnicodeDecodeError as error:
            raise InputError(f"not UTF-8 text (byte {error.start}); it is a TOML file") from None
        with one_at_a_time:
            path = save_own(
                request.path_params["name"], text, request.query_params.get("replace") == "1"
            )
        return JSONResponse({"name": path.stem}, 201)

    routes: list[BaseRoute] = [
        Route("/preset/changes", changes),
        Route("/data/presets", answering(names)),
        Route("/data/preset", answering(one)),
        Route("/sound/change", answering(change), methods=["POST"]),
        Route("/preset/toml", answering(toml), methods=["POST"]),
        Route("/preset/{name}", answering(keep), methods=["PUT"]),
        Route("/data/window", answering(window), methods=["POST"]),
        Route("/data/{file}", answering(file)),
        Route("/sound/{file}", answering(file)),
    ]
    if live is not None:
        routes = [*LiveData(live, lambda: content.preset).routes(), *routes]
    if media is not None:
        routes.append(Route("/media", media.send))
    return routes


async def _preset_events(name: str, linear: bool) -> AsyncIterator[str]:
    watch = PresetWatch(name, linear)
    yield "retry: 1000\n\n" + _preset_event(watch.preset)
    looks = 0
    while True:
        await asyncio.sleep(LOOK_EVERY_S)
        looks += 1
        try:
            changed = await asyncio.to_thread(watch.changed)
        except InputError as error:
            yield f"event: refused\ndata: {json.dumps(str(error))}\n\n"
            continue
        if changed is not None:
            yield _preset_event(changed)
        elif looks % ALIVE_EVERY == 0:
            yield ": alive\n\n"


def _preset_event(preset: Preset) -> str:
    return f"data: {json.dumps(preset_to_dict(preset))}\n\n"
