"""The data of a page: what it shows, what it sounds with, what it may keep.

| path | answers |
|---|---|
| `GET /data/session` | what sounds (`audio`), the preset's name, the first window, the film |
| `GET /data/timeline` | a part of the timeline (`timeline_data`) |
| `GET /data/surface` | the friction of a window (`surface_data`) |
| `GET /data/presets`, `/data/preset?name=NAME` | names; a preset and the parameter table |
| `POST /sound/whole`, `/sound/change` | what a page's kernel is given (`sound_data`) |
| `POST /preset/toml` | a preset's file, to download |
| `PUT /preset/NAME?replace=1` | keeps a preset file in the person's own folder |
| `GET /media` | the film, in ranges |

Bad input is 400 and one line. What takes long is done one after the other, in a thread: a page
can't take more than one core, and no Python here is in the way of a native audio callback.

Thread: the server's workers.
"""

from __future__ import annotations

import threading

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from overview_dsp.errors import InputError
from overview_dsp.presets.library import load_preset
from overview_dsp.presets.model import Preset
from overview_dsp.surface import build_surface
from overview_dsp.timeline import Timeline
from overview_dsp.web import sound_data
from overview_dsp.web.asked import answering, json_object, whole_number, window
from overview_dsp.web.media import Media
from overview_dsp.web.preset_data import (
    as_toml,
    preset_data,
    preset_named,
    preset_names,
    save_own,
)
from overview_dsp.web.surface_data import POINTS, encode_surface
from overview_dsp.web.timeline_data import COLUMNS, timeline_data

BINARY = "application/octet-stream"


def data_routes(
    timeline: Timeline,
    preset: str,
    *,
    audio: str = "here",
    first: tuple[float, float] | None = None,
    media: Media | None = None,
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
    """
    one_at_a_time = threading.Lock()
    known = preset_names()
    named = preset in (*known["bundled"], *known["own"])
    given = load_preset(preset)

    def chosen(name: str | None) -> Preset:
        if name is None or (name == given.name and not named):
            return load_preset(preset)  # as its file is now
        return preset_named(name)

    def session(request: Request, body: bytes) -> Response:
        told = {
            "audio": audio,
            "preset": given.name,
            "window": list(first or (0.0, timeline.duration_s)),
            "duration_s": timeline.duration_s,
            "title": timeline.title,
            "media": None if media is None else media.describe(),
        }
        return JSONResponse(told)

    def show(request: Request, body: bytes) -> Response:
        columns = whole_number(request, "columns", COLUMNS)
        part = window(request, timeline)
        with one_at_a_time:
            return JSONResponse(timeline_data(timeline, part, columns))

    def surface(request: Request, body: bytes) -> Response:
        part = window(request, timeline)
        points = whole_number(request, "points", POINTS)
        felt = chosen(request.query_params.get("preset"))
        with one_at_a_time:
            made = build_surface(timeline.window(*part), felt)
            return Response(encode_surface(made, part, points), media_type=BINARY)

    def names(request: Request, body: bytes) -> Response:
        return JSONResponse(preset_names())

    def one(request: Request, body: bytes) -> Response:
        return JSONResponse(preset_data(chosen(request.query_params.get("name"))))

    def whole(request: Request, body: bytes) -> Response:
        asked = json_object(body)
        with one_at_a_time:
            return Response(sound_data.whole(timeline, asked), media_type=BINARY)

    def change(request: Request, body: bytes) -> Response:
        asked = json_object(body)
        with one_at_a_time:
            return Response(sound_data.change(timeline, asked), media_type=BINARY)

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
        Route("/data/session", answering(session)),
        Route("/data/timeline", answering(show)),
        Route("/data/surface", answering(surface)),
        Route("/data/presets", answering(names)),
        Route("/data/preset", answering(one)),
        Route("/sound/whole", answering(whole), methods=["POST"]),
        Route("/sound/change", answering(change), methods=["POST"]),
        Route("/preset/toml", answering(toml), methods=["POST"]),
        Route("/preset/{name}", answering(keep), methods=["PUT"]),
    ]
    if media is not None:
        routes.append(Route("/media", media.send))
    return routes
