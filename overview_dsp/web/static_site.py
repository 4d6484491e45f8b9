"""A folder that any web host can serve: the page, its kernel, and a timeline with its windows.

It needs no server of ours and, once loaded, no network. `files.js` lists every file with a digest
of all of them, from which the page's service worker knows what to keep and when to renew it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from typing import Any

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import whole_folder
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.web.assets import START, folder_files
from overview_dsp.web.front_page import PICTURE, front_page, front_picture
from overview_dsp.web.site_content import SiteContent

MARK = "files.js"
"""The file by which a folder is known as one of ours."""


def write_site(
    timeline: Timeline,
    preset: Preset,
    path: str | os.PathLike[str],
    *,
    levels: int = 3,
    seed: int = 0,
    actuator: Actuator | None = None,
    progress: Callable[[float], None] | None = None,
    live: dict[str, Any] | None = None,
    address: str | None = None,
) -> int:
    """Write the folder, whole or not at all; its size in bytes.

    Parameters
    ----------
    path
        A new or empty folder, or one that this wrote before.
    levels
        How many times the page can zoom, to a third each.
    actuator
        What the tactor's signal drives.
    live
        What the page is told of a timeline that grows (`published`).
    address
        Where the folder will be, if that is known: ``https://example.org/match/``.

    Raises
    ------
    InputError
        The folder can't be written or holds other files; a surface that can't be made.
    """
    content = SiteContent(timeline, preset, levels=levels, seed=seed, actuator=actuator, live=live)

    def front(file: bytes) -> bytes:
        return front_page(file.decode(), timeline, address).encode()

    with whole_folder(path, MARK) as folder:
        listed: dict[str, list[str]] = {"page": [], "more": []}
        digest = hashlib.sha256()
        size = 0

        def put(name: str, file: bytes, group: str) -> None:
            nonlocal size
            place = folder / name
            place.parent.mkdir(exist_ok=True)
            place.write_bytes(file)
            listed[group].append(name)
            digest.update(name.encode() + file)
            size += len(file)

        for name, file in folder_files(live=live is not None).items():
            put(name, front(file) if name == START else file, "page")
        put(PICTURE, front_picture(timeline, preset), "more")
        for i, name in enumerate(content.names):
            put(name, content.make(name), "page" if content.is_needed_first(name) else "more")
            if progress is not None:
                progress((i + 1) / len(content.names))
        files = {"version": digest.hexdigest()[:16], **listed}
        (folder / MARK).write_text(f"self.FILES = {json.dumps(files)};\n", encoding="utf-8")
    return size
