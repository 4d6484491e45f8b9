"""Routes of a live timeline: notices of new versions, and updates on request.

| path | answers |
|---|---|
| `GET /live/events?since=V` | server-sent events: one notice per version, with the version as id |
| `GET /live/events?since=V&rate=HZ&have=H` | the same, each notice with the update from version H |
| `GET /live/update?since=V&rate=HZ` | the update from version V; V = -1: the complete data |

A notice is ``{"version", "now_s", "duration_s", "ended", "status_text", "changes": [{"action":
"added" or "retracted", "kind", "label" and "change" (`site_data`), "time_s", "pattern",
"version"}]}``, and "update" in base64 if requested. A page that reconnects receives all changes
since its last version (`Last-Event-ID`).

An update is uint32 n, then n bytes of JSON ``{"version", "info", "view", "rate", "bytes",
"packed"}``, padded with spaces to a multiple of 8, then a patch (`sound_data`). `info` has the
changed fields of ``data/timeline.json``; `view` is like ``data/window-0.json``. The patch applies
to the surface change of version V, which is first cut or padded with 0 to `bytes`. If `packed` is
true, the packed surface change follows instead, since it is shorter. Rate 0: no patch, as the host
plays. Updates and events are created once per version for all pages.

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
from overview_dsp.kernels.layout import CELLS
from overview_dsp.signal.surface.base_surface import rank_step
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.units import clock_text
from overview_dsp.web.preset_data import vibration_pattern
from overview_dsp.web.site_content import compact_json
from overview_dsp.web.site_data import event_fields, kind_styles, series_json, window_json
from overview_dsp.web.sound_data import QUICK, make_patch, pack, window_bytes

CHECK_INTERVAL_S = 0.05
NOTICE_INTERVAL_S = 0.25
"""Minimum time between two notices; a page receives a goal within a second."""

COMMENT_INTERVAL_S = 15.0
"""Interval of comments, which keep proxies from closing the connection."""

CACHE_SIZE = 12
"""Number of versions in each cache, for pages that lag behind."""

LARGE = 30_000
"""Bytes of a patch from which on the packed surface may be shorter."""

MAX_CHANGES = 20
RATES = (0, 8_000, 192_000)
"""Rate without sound, and the lowest and highest rate of a browser, Hz."""


class LiveData:
    """Notices and updates of a live timeline for pages."""

    def __init__(self, live: LiveTimeline, preset: Callable[[], Preset]) -> None:
        self._live = live
        self._preset = preset
        self.version = live.revision
        self.timeline: Timeline = live.padded_snapshot()
        self._new_version = asyncio.Event()
        self._watching: asyncio.Task[None] | None = None
        self._pages = 0
        self._update_lock = threading.Lock()
        self._event_lock = asyncio.Lock()
        self._surfaces: OrderedDict[tuple[int, int], bytes] = OrderedDict()
        self._update_cache: OrderedDict[tuple[int, int, int], bytes] = OrderedDict()
        self._event_cache: OrderedDict[tuple[int, int, int | None, int], bytes] = OrderedDict()

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the table above."""
        return [Route("/live/events", self._events), Route("/live/update", self._update)]

    def notice(self, since: int) -> dict[str, Any]:
        """Return the notice of the current version for a page with version `since`."""
        preset = self._preset()
        changes = [
            {
                "action": change.action,
                "kind": change.event.kind,
                **event_fields(change.event),
                "time_s": change.event.time_s,
                "pattern": list(vibration_pattern(change.event.kind, preset)),
                "version": change.revision,
            }
            for change in self._live.changes_since(since)
            if change.revision <= self.version
        ]
        timeline = self.timeline
        now_s = timeline.duration_s if timeline.known_until_s is None else timeline.known_until_s
        ended = self._live.ended
        return {
            "version": self.version,
            "now_s": now_s,
            "duration_s": timeline.duration_s,
            "ended": ended,
            "status_text": "the end" if ended else f"data until {clock_text(now_s)}",
            "changes": changes[-MAX_CHANGES:],
        }

    # --- notices ----------------------------------------------------------------------------------

    async def _events(self, request: Request) -> Response:
        seen = request.query_params.get("since", "")
        seen = request.headers.get("last-event-id", seen)
        since = _version(seen, self.version)
        rate, page_version = None, since
        if "rate" in request.query_params:
            rate = _version(request.query_params["rate"], -1)
            if not _is_rate(rate):
                return PlainTextResponse("events?since=VERSION&rate=HZ&have=VERSION\n", 400)
            if "last-event-id" not in request.headers:  # reconnected: the page has that version
                page_version = _version(request.query_params.get("have", ""), -1)
        headers = {"cache-control": "no-store", "x-accel-buffering": "no"}
        return StreamingResponse(
            self._notices(since, page_version, rate),
            headers=headers,
            media_type="text/event-stream",
        )

    async def _notices(
        self, since: int, page_version: int, rate: int | None
    ) -> AsyncIterator[bytes]:
        if self._watching is None or self._watching.done():
            self._watching = asyncio.create_task(self._watch())
        self._pages += 1
        try:
            yield b"retry: 1000\n\n"
            while True:
                notified = self._new_version  # a version from now on sets this event
                if since != self.version or (rate is not None and page_version != self.version):
                    since, text = await self._event(since, page_version, rate)
                    page_version = since
                    yield text
                    continue
                try:
                    async with asyncio.timeout(COMMENT_INTERVAL_S):
                        await notified.wait()
                except TimeoutError:
                    yield b": alive\n\n"
        finally:
            self._pages -= 1

    async def _event(self, since: int, page_version: int, rate: int | None) -> tuple[int, bytes]:
        """Return the current version and its event for a page."""
        async with self._event_lock:  # pages share one event
            while True:
                version = self.version
                key = (since, page_version, rate, version)
                if key in self._event_cache:
                    return version, self._event_cache[key]
                update = b""
                if rate is not None:
                    update = await run_in_threadpool(self.update, page_version, rate)
                if version == self.version:
                    break
            notice = self.notice(since)
            if rate is not None:
                notice["update"] = base64.b64encode(update).decode()
            text = json.dumps(notice, ensure_ascii=False)
            event = f"id: {version}\ndata: {text}\n\n".encode()
            _cache(self._event_cache, key, event)
            return version, event

    async def _watch(self) -> None:
        """Check for new versions while there are pages."""
        while True:
            if self._live.revision != self.version:
                await run_in_threadpool(self.refresh)
                notified, self._new_version = self._new_version, asyncio.Event()
                notified.set()
                await asyncio.sleep(NOTICE_INTERVAL_S)
            await asyncio.sleep(CHECK_INTERVAL_S)
            if not self._pages:
                return

    def refresh(self) -> None:
        """Make the current revision the version."""
        revision = self._live.revision
        # later changes belong to the next version even if the timeline has them already
        timeline = self._live.padded_snapshot()
        with self._update_lock:
            self.version, self.timeline = revision, timeline

    # --- updates ----------------------------------------------------------------------------------

    async def _update(self, request: Request) -> Response:
        try:
            since, rate = (int(request.query_params[name]) for name in ("since", "rate"))
        except (KeyError, ValueError):
            since, rate = -1, -1
        if not _is_rate(rate):
            return PlainTextResponse("update?since=VERSION&rate=HZ\n", 400)
        if not self._pages and self._live.revision != self.version:  # no page triggers the check
            await run_in_threadpool(self.refresh)
        update = self._update_cache.get((since, self.version, rate))
        if update is None:
            update = await run_in_threadpool(self.update, since, rate)
        return Response(
            update, media_type="application/octet-stream", headers={"cache-control": "no-store"}
        )

    def update(self, since: int, rate: int) -> bytes:
        """Return the update from version `since` to the current one; `rate` in Hz."""
        with self._update_lock:
            version, timeline, preset = self.version, self.timeline, self._preset()
            key = (since, version, rate)
            if key in self._update_cache:
                return self._update_cache[key]
            surface = build_surface(timeline, preset)
            content: dict[str, Any] = {
                "version": version,
                "rate": rate,
                "info": {
                    "title": timeline.title,
                    "sides": timeline.sides,
                    "duration_s": timeline.duration_s,
                    "kinds": kind_styles(timeline, preset),
                    "notes": list(timeline.notes),
                    "series": series_json(timeline),
                },
                "view": window_json(timeline, surface, 0.0),
            }
            patch = b""
            if rate:
                surface_bytes = window_bytes(surface, preset, rate)
                content["bytes"] = len(surface_bytes)
                base = self._surfaces.get((since, rate), b"")
                # its length depends on the number of events
                base = base and base[: len(surface_bytes)].ljust(len(surface_bytes), b"\0")
                patch = make_patch(base, surface_bytes)
                if len(patch) > LARGE:
                    packed = pack(surface_bytes, rank_step(timeline, preset, CELLS), QUICK)
                    content["packed"] = len(packed) < len(patch)
                    patch = min(patch, packed, key=len)
                _cache(self._surfaces, (version, rate), surface_bytes)
            header = compact_json(content)
            header += b" " * (-(len(header) + 4) % 8)
            update = len(header).to_bytes(4, "little") + header + patch
            _cache(self._update_cache, key, update)
            return update


def _version(text: str, default: int) -> int:
    return int(text) if text.isdecimal() and len(text) < 16 else default


def _is_rate(rate: int) -> bool:
    none, lowest, highest = RATES
    return rate == none or lowest <= rate <= highest


def _cache(cache: OrderedDict[Any, bytes], key: Any, content: bytes) -> None:
    cache[key] = content
    while len(cache) > CACHE_SIZE:
        cache.popitem(last=False)
