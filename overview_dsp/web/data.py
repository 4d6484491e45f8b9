"""Routes for a page's data: timeline, windows, sound, presets and media.

| path | answers |
|---|---|
| `GET /data/...json`, `/sound/...` | the files of a static folder (`site_content`) |
| `POST /data/window`, `/sound/change` | any window and preset (`sound_data`) |
| `GET /data/presets`, `/data/preset?name=NAME` | preset names; a preset and the parameter table |
| `GET /preset/changes` | the served preset after each change of its file |
| `POST /preset/toml` | a preset as a TOML file |
| `PUT /preset/NAME?replace=1` | saves a preset in the user's folder |
| `GET /media` | the film, in ranges |

`live_data` has the routes `GET /live/...` of a live timeline.

``server`` of ``data/timeline.json`` is ``{"audio": "here" or "host", "window": [start_s, end_s],
"media": {"url", "type", "offset_s"} or null, "pages": [names]}``. `audio` is the machine that plays
the sound, `window` the first visible window, `pages` the entry points `overview_dsp.pages` of other
distributions: each makes the routes of ``/NAME/`` from a preset. A reloaded page uses the current
content of the preset file.

``/preset/changes`` sends server-sent events in the format of ``/data/preset``: first the current
preset, then each valid change of its file. For an invalid file it sends ``event: refused`` with the
error message; the last valid version stays active.

Invalid input is answered by 400 and a one-line message. Slow requests run in a thread,
one at a time, so a page can use only one core and doesn't block a native audio
callback.

Thread: the server's; requests are answered in its worker threads.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import AsyncIterator
from importlib.metadata import entry_points
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Mount, Route

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.library import load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.design.presets.writing import preset_toml
from overview_dsp.errors import InputError, warn
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.signal.surface.angle_map import without_map
from overview_dsp.web import sound_data
from overview_dsp.web.live_data import LiveData
from overview_dsp.web.media import Media
from overview_dsp.web.messages import json_object
from overview_dsp.web.preset_data import (
    named_preset,
    parse_preset,
    preset_data,
    preset_names,
    save_preset,
)
from overview_dsp.web.security.middleware import threaded_endpoint
from overview_dsp.web.site_content import SiteContent

BINARY, JSON = "application/octet-stream", "application/json"
TIMELINE_FILE, POINTS_FILE = "data/timeline.json", "data/points-0.json"
LEVELS = 4
"""Number of zoom levels of a served page, each with windows a third as long."""

CHECK_INTERVAL_S = 0.1
CHECKS_PER_COMMENT = 50
"""Checks between two comments, which reveal a dead connection."""


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
    """Return the routes of a timeline, for the name or path of a preset.

    `audio`: machine that plays the sound, "here" (the page's) or "host".
    `first`: the window (s) that is shown first.
    `media`: film or recording of the timeline.
    `live`: live timeline; `timeline` is its snapshot.
    `linear`: whether presets are used without their angle map.
    """
    one_at_a_time = threading.Lock()
    is_library_name = any(preset in names for names in preset_names().values())
    first_name = load_preset(preset).name

    pages = _pages_of_packages(preset)

    def adapted(preset: Preset) -> Preset:
        return without_map(preset) if linear else preset

    def served() -> Preset:
        return adapted(load_preset(preset))  # reads the file again

    def preset_by_name(name: str) -> Preset:
        if name == first_name and not is_library_name:
            return served()
        return adapted(named_preset(name))

    def current_timeline() -> Timeline:
        return timeline if live is None else live.padded_snapshot()

    def new_content() -> SiteContent:
        version = None if live is None else live.revision
        current = current_timeline()
        server: dict[str, Any] = {
            "audio": audio,
            "window": list(first or (0.0, current.duration_s)),
            "media": None if media is None else media.describe(),
            "pages": list(pages),
        }
        return SiteContent(
            current,
            served(),
            levels=LEVELS,
            server=server,
            live=None if live is None else {"levels": LEVELS, "version": version},
        )

    content = new_content()

    def file(request: Request, body: bytes) -> Response:
        nonlocal content
        name = request.url.path.removeprefix("/")
        with one_at_a_time:
            if name in (TIMELINE_FILE, POINTS_FILE) and (
                served() != content.preset or current_timeline() is not content.timeline
            ):
                content = new_content()
            if name not in content.files:
                return PlainTextResponse("not found\n", 404)
            kind = JSON if name.endswith(".json") else BINARY
            return Response(content.files[name](), media_type=kind)

    def window(request: Request, body: bytes) -> Response:
        query = json_object(body)
        with one_at_a_time:
            return JSONResponse(sound_data.window(current_timeline(), content.preset, query))

    def one_preset(request: Request, body: bytes) -> Response:
        name = request.query_params.get("name")
        return JSONResponse(preset_data(content.preset if name is None else preset_by_name(name)))

    async def changes(request: Request) -> Response:
        return StreamingResponse(
            _preset_events(preset, linear),
            headers={"cache-control": "no-store"},
            media_type="text/event-stream",
        )

    def change(request: Request, body: bytes) -> Response:
        query = json_object(body)
        with one_at_a_time:
            changed = sound_data.change(current_timeline(), content.preset, query)
            return Response(changed, media_type=BINARY)

    def toml(request: Request, body: bytes) -> Response:
        return PlainTextResponse(preset_toml(parse_preset(json_object(body))))

    def save(request: Request, body: bytes) -> Response:
        try:
            text = body.decode()
        except UnicodeDecodeError as error:
            raise InputError(f"byte {error.start} is not UTF-8; must be a TOML file") from None
        with one_at_a_time:
            path = save_preset(
                request.path_params["name"], text, request.query_params.get("replace") == "1"
            )
        return JSONResponse({"name": path.stem}, 201)

    routes: list[BaseRoute] = [
        Route("/preset/changes", changes),
        Route(
            "/data/presets", threaded_endpoint(lambda request, body: JSONResponse(preset_names()))
        ),
        Route("/data/preset", threaded_endpoint(one_preset)),
        Route("/sound/change", threaded_endpoint(change), methods=["POST"]),
        Route("/preset/toml", threaded_endpoint(toml), methods=["POST"]),
        Route("/preset/{name}", threaded_endpoint(save), methods=["PUT"]),
        Route("/data/window", threaded_endpoint(window), methods=["POST"]),
        Route("/data/{file}", threaded_endpoint(file)),
        Route("/sound/{file}", threaded_endpoint(file)),
        *(Mount(f"/{name}", routes=routes) for name, routes in pages.items()),
    ]
    if live is not None:
        routes = [*LiveData(live, lambda: content.preset).routes(), *routes]
    if media is not None:
        routes.append(Route("/media", media.send))
    return routes


def _pages_of_packages(preset: str) -> dict[str, list[BaseRoute]]:
    """Return the routes of the pages of installed packages, by name."""
    found = {}
    for page in entry_points(group="overview_dsp.pages"):
        try:
            found[page.name] = page.load()(preset)
        except Exception as error:  # its import may raise any error
            package = "?" if page.dist is None else page.dist.name
            warn(f"the page {page.name} of {package} can't be shown ({error}); left out")
    return found


async def _preset_events(name: str, linear: bool) -> AsyncIterator[str]:
    watch = PresetWatch(name, linear)
    yield "retry: 1000\n\n" + _preset_event(watch.preset)
    checks = 0
    while True:
        await asyncio.sleep(CHECK_INTERVAL_S)
        checks += 1
        try:
            changed = await asyncio.to_thread(watch.pop_changed)
        except InputError as error:
            yield f"event: refused\ndata: {json.dumps(str(error))}\n\n"
            continue
        if changed is not None:
            yield _preset_event(changed)
        elif checks % CHECKS_PER_COMMENT == 0:
            yield ": alive\n\n"


def _preset_event(preset: Preset) -> str:
    return f"data: {json.dumps(preset_to_dict(preset))}\n\n"
