"""`GET /preset/changes`: the served preset's file, saved on the desk, is felt on every page.

Server-sent events: first the preset as it is, then each time its file has changed and is whole, as
`/data/preset` has it. A file that isn't valid is told as ``event: refused`` with the line that says
why; the last good one goes on.

Thread: the server's; files are read in a worker.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

from overview_dsp.design.presets.dicts import preset_to_dict
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.live.session.presets import PresetWatch

LOOK_EVERY_S = 0.1
ALIVE_EVERY = 50
"""Looks after which a line is sent in any case: a dead connection is noticed."""


def preset_link(name: str, linear: bool) -> Route:
    """The route for a preset, by name or path; `linear`: without its angle map."""

    async def changes(request: Request) -> Response:
        return StreamingResponse(
            _told(name, linear),
            headers={"cache-control": "no-store"},
            media_type="text/event-stream",
        )

    return Route("/preset/changes", changes)


async def _told(name: str, linear: bool) -> AsyncIterator[str]:
    watch = PresetWatch(name, linear)
    yield "retry: 1000\n\n" + _message(watch.preset)
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
            yield _message(changed)
        elif looks % ALIVE_EVERY == 0:
            yield ": alive\n\n"


def _message(preset: Preset) -> str:
    return f"data: {json.dumps(preset_to_dict(preset))}\n\n"
