"""A folder that any web host can serve: the page, its kernel, and a timeline with its windows.

It needs no server of ours and, once loaded, no network. `files.js` lists every file with a digest
of all of them, from which the page's service worker knows what to keep and when to renew it.

The first file of a folder: the page with its timeline's own title, a picture for those who share
its address, and the data it begins with asked for along with its scripts.
"""

from __future__ import annotations

import hashlib
import html
import io
import json
import os
from collections.abc import Callable
from typing import Any

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import atomic_folder
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.web.assets import START, folder_files
from overview_dsp.web.site_content import SiteContent

PICTURE = "preview.png"
WIDTH, HEIGHT = 1200, 630
"""Pixels, as pages that show a link expect them."""

_DPI = 100
_FIRST = ("data/timeline.json", "data/window-0.json")
_TITLE = "<title>overView</title>"
_HEADING = '<h1 id="title">overView</h1>'


def front_page(page: str, timeline: Timeline, address: str | None = None) -> str:
    """The page's `index.html` for one timeline; `address`: where its folder will be, if known."""
    title = html.escape(timeline.title)
    head = [f"<title>{title}: overView</title>"]
    head += sharing(timeline.title, PICTURE, address, f"{timeline.title}, drawn over time")
    head += [f'<link rel="preload" as="fetch" crossorigin href="{name}">' for name in _FIRST]
    return page.replace(_TITLE, "\n  ".join(head)).replace(_HEADING, f'<h1 id="title">{title}</h1>')


def sharing(title: str, picture: str, address: str | None, alt: str | None = None) -> list[str]:
    """Tags for who shows a link: many of them need a picture's whole address."""
    told = {
        "title": title,
        "type": "website",
        "description": "A timeline to feel: friction under your finger.",
        "image": f"{address or ''}{picture}",
        "image:width": str(WIDTH),
        "image:height": str(HEIGHT),
    }
    told |= {"image:alt": alt} if alt else {}
    told |= {"url": address} if address else {}
    return [
        *(
            f'<meta property="og:{name}" content="{html.escape(content)}">'
            for name, content in told.items()
        ),
        '<meta name="twitter:card" content="summary_large_image">',
    ]


def front_picture(timeline: Timeline, preset: Preset) -> bytes:
    """The timeline as a picture, PNG, on the axis of its surface."""
    from overview_dsp.offline.plots.style import new_figure
    from overview_dsp.offline.plots.timeline import draw_timeline

    figure = new_figure(WIDTH / _DPI, HEIGHT / _DPI)
    axes = figure.subplots()
    draw_timeline(axes, timeline, AngleMap.of(timeline, preset))
    axes.set_title(timeline.title, fontsize=16)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})
    return file.getvalue()


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

    with atomic_folder(path, MARK) as folder:
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
