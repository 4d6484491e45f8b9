"""One recording of what the timeline is about (`--media`), in byte ranges, to play from a moment.

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
"""Parts of the file in one answer: players ask for one."""


@dataclass(frozen=True)
class Media:
    """A film or a recording.

    `offset_s` is where in it the timeline's time 0 is (negative: it begins later).
    """

    path: Path
    kind: str
    offset_s: float

    def describe(self) -> dict[str, Any]:
        """For the page."""
        return {"url": "/media", "type": self.kind, "offset_s": self.offset_s}

    def send(self, request: Request) -> Response:
        """The file, or the range of it that was asked for."""
        if request.headers.get("range", "").count(",") >= MAX_RANGES:
            return PlainTextResponse("one range at a time\n", 416)
        if not os.path.isfile(self.path):
            return PlainTextResponse(
                "the film is gone: put it back where it was, or serve with another\n", 404
            )
        return FileResponse(self.path, media_type=self.kind)


def open_media(path: str, offset_s: float) -> Media:
    """The film or recording of a file.

    Raises
    ------
    InputError
        No such file, one that can't be read, or one that browsers don't play.
    """
    kind = mimetypes.guess_type(path)[0] or ""
    if not kind.startswith(("video/", "audio/")):
        raise InputError(f"{path}: no film or recording by its name; give .mp4, .webm, .mp3, .ogg")
    try:
        with open(path, "rb") as file:
            file.read(1)
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    return Media(Path(path).resolve(), kind, offset_s)
