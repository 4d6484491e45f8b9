"""Film or recording of a timeline (`--media`), served in byte ranges.

Thread: the server's.
"""

from __future__ import annotations

import mimetypes
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response

from overview_dsp.errors import InputError

MAX_RANGES = 1
"""Ranges per request; players request one."""


@dataclass(frozen=True)
class Media:
    """Film or recording; `offset_s` is its time at the start of the timeline."""

    path: Path
    kind: str
    offset_s: float

    def describe(self) -> dict[str, Any]:
        """Return URL, type and offset for the page."""
        return {"url": "/media", "type": self.kind, "offset_s": self.offset_s}

    def send(self, request: Request) -> Response:
        """Answer with the file or the requested range."""
        if request.headers.get("range", "").count(",") >= MAX_RANGES:
            return PlainTextResponse("only one range per request is supported\n", 416)
        if not os.path.isfile(self.path):
            return PlainTextResponse(
                "the media file was removed: restore it, or serve another one\n", 404
            )
        return FileResponse(self.path, media_type=self.kind)


def open_media(path: str, offset_s: float) -> Media:
    """Open a film or recording; InputError if it can't be read, or browsers can't play its type."""
    kind = mimetypes.guess_type(path)[0] or ""
    if not kind.startswith(("video/", "audio/")):
        raise InputError(f"{path}: unknown media type; use .mp4, .webm, .mp3 or .ogg")
    try:
        with open(path, "rb") as file:
            file.read(1)
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    return Media(Path(path).resolve(), kind, offset_s)
