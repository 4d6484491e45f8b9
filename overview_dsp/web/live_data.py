"""A timeline that grows, for pages: told in a line when it has, fetched when a page wants it.

| path | answers |
|---|---|
| `GET /live/events?since=V` | server-sent events: a notice a version, its id the version |
| `GET /live/events?since=V&rate=HZ&have=H` | the same, with the update from version H in each |
| `GET /live/update?since=V&rate=HZ` | what a page with version V lacks; V -1: it has none yet |

A notice is ``{"version", "now_s", "duration_s", "ended", "words", "news": [{"what": "added" or
"retracted", "kind", "label", "time_s", "pulse", "version"}]}``, and "update", base64,
where the update comes with it. A page that slept is told the news since the version that it knew
(`Last-Event-ID`).

An update is uint32 n, n bytes of JSON ``{"version", "info", "view", "rate", "bytes"}`` (`info` what
has changed of ``data/timeline.json``, `view` as ``data/window-0.json``), blanks up to a multiple of
8, and a patch (`sound_data`) that makes the change to the whole's surface of that of version V,
which is cut or filled up with 0 to `bytes` first. It is made once a version, however many pages
want it, and an event's bytes are, too. Rate 0: no patch, as the host sounds.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
import base64
import json
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.units import clock_text
from overview_dsp.web.preset_data import pulse_of
from overview_dsp.web.site_data import kind_looks, window_json
from overview_dsp.web.sound_data import patch_of, window_bytes
from overview_dsp.web.values import series_json

LOOK_EVERY_S = 0.05
TELL_EVERY_S = 0.25
"""A new version is told at most so often: a goal is felt on a page within a second."""

ALIVE_EVERY_S = 15.0
"""A comment, so that nothing between here and a page takes the connection for dead."""

KEPT = 12
"""Versions whose bytes are kept for the patches of pages that lag behind."""

MOST_NEWS = 20
RATES = (0, 8_000, 192_000)
"""No sound, and the lowest and highest rate of a browser, Hz."""


class LiveData:
    """What pages are told of a timeline that grows."""

    def __init__(self, live: LiveTimeline, preset: Callable[[], Preset]) -> None:
        self._live = live
        self._preset = preset
        self.version = live.revision
        self.timeline: Timeline = live.felt()
        self._told = asyncio.Event()
        self._ticking: asyncio.Task[None] | None = None
        self._pages = 0
        self._making = threading.Lock()
        self._telling = asyncio.Lock()
        self._bytes: OrderedDict[tuple[int, int], bytes] = OrderedDict()
        self._updates: OrderedDict[tuple[int, int, int], bytes] = OrderedDict()
        self._events_made: OrderedDict[tuple[int, int, int | None, int], bytes] = OrderedDict()

    def routes(self) -> list[BaseRoute]:
        """The routes of the table above."""
        return [Route("/live/events", self._events), Route("/live/update", self._update)]

    def notice(self, since: int) -> dict[str, Any]:
        """What is told of the present version to a page that knew another."""
        preset = self._preset()
        news = [
            {
                "what": change.what,
                "kind": change.event.kind,
                "label": change.event.display_label,
                "time_s": change.event.time_s,
                "pulse": list(pulse_of(change.event.kind, preset)),
                "version": change.revision,
            }
            for change in self._live.changes_since(since)
            if change.revision <= self.version
        ]
        timeline = self.timeline
        now_s = timeline.duration_s if timeline.known_until_s is None else timeline.known_until_s
        over = self._live.ended
        return {
            "version": self.version,
            "now_s": now_s,
            "duration_s": timeline.duration_s,
            "ended": over,
            "words": "the end" if over else f"data until {clock_text(now_s)}",
            "news": news[-MOST_NEWS:],
        }

    # --- notices ----------------------------------------------------------------------------------

    async def _events(self, request: Request) -> Response:
        known = request.query_params.get("since", "")
        known = request.headers.get("last-event-id", known)
        since = _version(known, self.version)
        rate, have = None, since
        if "rate" in request.query_params:
            rate = _version(request.query_params["rate"], -1)
            if not _is_rate(rate):
                return PlainTextResponse("events?since=VERSION&rate=HZ&have=VERSION\n", 400)
            if "last-event-id" not in request.headers:  # each of these brought its update
                have = _version(request.query_params.get("have", ""), -1)
        headers = {"cache-control": "no-store", "x-accel-buffering": "no"}
        return StreamingResponse(
            self._notices(since, have, rate), headers=headers, media_type="text/event-stream"
        )

    async def _notices(self, since: int, have: int, rate: int | None) -> AsyncIterator[bytes]:
        if self._ticking is None or self._ticking.done():
            self._ticking = asyncio.create_task(self._tick())
        self._pages += 1
        try:
            yield b"retry: 1000\n\n"
            while True:
                told = self._told  # what comes from now on is heard of
                if since != self.version or (rate is not None and have != self.version):
                    since, text = await self._event(since, have, rate)
                    have = since
                    yield text
                    continue
                try:
                    async with asyncio.timeout(ALIVE_EVERY_S):
                        await told.wait()
                except TimeoutError:
                    yield b": alive\n\n"
        finally:
            self._pages -= 1

    async def _event(self, since: int, have: int, rate: int | None) -> tuple[int, bytes]:
        """The present version, and the event that brings a page there."""
        async with self._telling:  # pages that wait for the same make it once
            while True:
                version = self.version
                key = (since, have, rate, version)
                if key in self._events_made:
                    return version, self._events_made[key]
                update = b""
                if rate is not None:
                    update = await run_in_threadpool(self.update, have, rate)
                if version == self.version:
                    break
            notice = self.notice(since)
            if rate is not None:
                notice["update"] = base64.b64encode(update).decode()
            text = json.dumps(notice, ensure_ascii=False)
            made = f"id: {version}\ndata: {text}\n\n".encode()
            _keep(self._events_made, key, made)
            return version, made

    async def _tick(self) -> None:
        """Look whether there is a new version, as long as there are pages."""
        while True:
            if self._live.revision != self.version:
                await run_in_threadpool(self.take)
                told, self._told = self._told, asyncio.Event()
                told.set()
                await asyncio.sleep(TELL_EVERY_S)
            await asyncio.sleep(LOOK_EVERY_S)
            if not self._pages:
                return

    def take(self) -> None:
        """Make the present revision the version."""
        revision = self._live.revision
        # what comes in between is in the timeline already, and news of the next version
        timeline = self._live.felt()
        with self._making:
            self.version, self.timeline = revision, timeline

    # --- updates ----------------------------------------------------------------------------------

    async def _update(self, request: Request) -> Response:
        try:
            since, rate = (int(request.query_params[name]) for name in ("since", "rate"))
        except (KeyError, ValueError):
            since, rate = -1, -1
        if not _is_rate(rate):
            return PlainTextResponse("update?since=VERSION&rate=HZ\n", 400)
        if not self._pages and self._live.revision != self.version:  # nobody looks
            await run_in_threadpool(self.take)
        made = self._updates.get((since, self.version, rate))
        if made is None:
            made = await run_in_threadpool(self.update, since, rate)
        return Response(
            made, media_type="application/octet-stream", headers={"cache-control": "no-store"}
        )

    def update(self, since: int, rate: int) -> bytes:
        """Make the bytes of an update to the present version; rate in Hz."""
        with self._making:
            version, timeline, preset = self.version, self.timeline, self._preset()
            key = (since, version, rate)
            if key in self._updates:
                return self._updates[key]
            surface = build_surface(timeline, preset)
            content: dict[str, Any] = {
                "version": version,
                "rate": rate,
                "info": {
                    "title": timeline.title,
                    "duration_s": timeline.duration_s,
                    "kinds": kind_looks(timeline, preset),
                    "notes": list(timeline.notes),
                    "series": series_json(timeline),
                },
                "view": window_json(timeline, surface, 0.0),
            }
            patch = b""
            if rate:
                wanted = window_bytes(surface, preset, rate)
                content["bytes"] = len(wanted)
                base = self._bytes.get((since, rate))
                if base is not None:  # with more events it is longer
                    base = base[: len(wanted)].ljust(len(wanted), b"\0")
                patch = patch_of(base or b"", wanted)
                _keep(self._bytes, (version, rate), wanted)
            text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
            head = text.encode()
            head += b" " * (-(len(head) + 4) % 8)
            made = len(head).to_bytes(4, "little") + head + patch
            _keep(self._updates, key, made)
            return made


def _version(text: str, otherwise: int) -> int:
    return int(text) if text.isdecimal() and len(text) < 16 else otherwise


def _is_rate(rate: int) -> bool:
    none, lowest, highest = RATES
    return rate == none or lowest <= rate <= highest


def _keep(kept: OrderedDict[Any, bytes], key: Any, content: bytes) -> None:
    kept[key] = content
    while len(kept) > KEPT:
        kept.popitem(last=False)
