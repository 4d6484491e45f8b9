"""Static folder with the page, its kernel and a timeline or several, for any web host.

The folder needs no server of this package and, once loaded, no network. `files.js` lists every file
and a digest. The page's service worker stores these files and renews them when the digest changes.

The start page has the timeline's title, a preview picture for shared links, and preload tags for
the first data files. A gallery is an index page, and one subfolder per timeline.
"""

from __future__ import annotations

import hashlib
import html
import io
import itertools
import json
import os
import re
from collections.abc import Callable, Sequence
from string import Template
from typing import Any

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import atomic_folder
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.web.assets import START, WEB, folder_files, page_files
from overview_dsp.web.site_content import SiteContent
from overview_dsp.web.site_data import default_levels

PICTURE = "preview.png"
WIDTH, HEIGHT = 1200, 630
"""Size of the preview picture in pixels, as link previews expect."""

_DPI = 100
_PRELOADED = ("data/timeline.json", "data/window-0.json")
_TITLE = "<title>overView</title>"
_HEADING = '<h1 id="title">overView</h1>'


def start_page(page: str, timeline: Timeline, address: str | None = None) -> str:
    """Return `index.html` for one timeline; `address` is the folder's URL, if known."""
    title = html.escape(timeline.title)
    head = [f"<title>{title}: overView</title>"]
    head += link_tags(timeline.title, PICTURE, address, f"{timeline.title}, drawn over time")
    head += [f'<link rel="preload" as="fetch" crossorigin href="{name}">' for name in _PRELOADED]
    return page.replace(_TITLE, "\n  ".join(head)).replace(_HEADING, f'<h1 id="title">{title}</h1>')


def link_tags(title: str, picture: str, address: str | None, alt: str | None = None) -> list[str]:
    """Return tags for link previews; many services need the full URL of the picture."""
    properties = {
        "title": title,
        "type": "website",
        "description": "A timeline that you can feel as friction.",
        "image": f"{address or ''}{picture}",
        "image:width": str(WIDTH),
        "image:height": str(HEIGHT),
    }
    properties |= {"image:alt": alt} if alt else {}
    properties |= {"url": address} if address else {}
    return [
        *(
            f'<meta property="og:{name}" content="{html.escape(content)}">'
            for name, content in properties.items()
        ),
        '<meta name="twitter:card" content="summary_large_image">',
    ]


def preview_picture(timeline: Timeline, preset: Preset) -> bytes:
    """Return a PNG picture of the timeline on the axis of its surface."""
    from overview_dsp.offline.plots.style import new_figure
    from overview_dsp.offline.plots.timeline import draw_timeline

    figure = new_figure(WIDTH / _DPI, HEIGHT / _DPI)
    axes = figure.subplots()
    draw_timeline(axes, timeline, AngleMap.of(timeline, preset))
    axes.set_title(timeline.title, fontsize=16)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})
    return file.getvalue()


MARKER_FILE = "files.js"
"""File that marks a folder as written by this module."""


def write_site(
    timeline: Timeline,
    preset: Preset,
    path: str | os.PathLike[str],
    *,
    levels: int | None = None,
    seed: int = 0,
    actuator: Actuator | None = None,
    progress: Callable[[float], None] | None = None,
    live: dict[str, Any] | None = None,
    address: str | None = None,
) -> int:
    """Write the folder completely or not at all; return its size in bytes.

    `path`: a new or empty folder, or an earlier export.
    `levels`: number of zoom levels, each with windows a third as long. None: `default_levels`.
    `actuator`: actuator of the tactor's signal.
    `live`: settings of a live timeline (`static_publisher`).
    `address`: URL of the published folder, if known: ``https://example.org/match/``.

    InputError if the folder can't be written, contains other files, or a surface can't be built.
    """
    levels = default_levels(timeline) if levels is None else levels
    content = SiteContent(timeline, preset, levels=levels, seed=seed, actuator=actuator, live=live)

    with atomic_folder(path, MARKER_FILE) as folder:
        listed: dict[str, list[str]] = {"page": [], "more": []}
        digest = hashlib.sha256()
        size = 0

        def put(name: str, file: bytes, group: str) -> None:
            nonlocal size
            file_path = folder / name
            file_path.parent.mkdir(exist_ok=True)
            file_path.write_bytes(file)
            listed[group].append(name)
            digest.update(name.encode() + file)
            size += len(file)

        for name, file in folder_files(live=live is not None).items():
            if name == START:
                file = start_page(file.decode(), timeline, address).encode()
            put(name, file, "page")
        put(PICTURE, preview_picture(timeline, preset), "more")
        for i, (name, make) in enumerate(content.files.items(), 1):
            put(name, make(), "page" if content.is_needed_first(name) else "more")
            if progress is not None:
                progress(i / len(content.files))
        files = {"version": digest.hexdigest()[:16], **listed}
        (folder / MARKER_FILE).write_text(f"self.FILES = {json.dumps(files)};\n", encoding="utf-8")
    return size


GALLERY_FILE = "gallery.txt"
"""File that marks a gallery folder; it lists the subfolders, one per line."""

_GALLERY_FILES = ("style.css", "gallery.css", "icon.svg", "icon-192.png")
_GALLERY_TITLE = "Timelines to feel"
_MAX_NAME = 48


def write_gallery(
    items: Sequence[tuple[Timeline, Preset]],
    path: str | os.PathLike[str],
    *,
    address: str | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> int:
    """Write the folder completely or not at all; return its size in bytes.

    `items` are timelines in order, each with its preset. Other arguments and errors are those of
    `write_site`; `path` may be an earlier gallery.
    """
    names = _folder_names([timeline.title for timeline, _ in items])
    files = {name: page_files()[name] for name in _GALLERY_FILES}
    files[GALLERY_FILE] = "".join(f"{name}\n" for name in names).encode()
    files[START] = _gallery_page([timeline for timeline, _ in items], names, address).encode()
    size = sum(map(len, files.values()))
    with atomic_folder(path, GALLERY_FILE) as folder:
        for name, content in files.items():
            (folder / name).write_bytes(content)
        for i, (name, (timeline, preset)) in enumerate(zip(names, items, strict=True)):

            def report(done: float, i: int = i) -> None:
                if progress is not None:
                    progress((i + done) / len(items))

            options["address"] = None if address is None else f"{address}{name}/"
            size += write_site(timeline, preset, folder / name, progress=report, **options)
    return size


def _folder_names(titles: Sequence[str]) -> list[str]:
    """Return a unique folder name of letters, digits and hyphens for each title."""
    names: list[str] = []
    for title in titles:
        plain = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:_MAX_NAME].strip("-")
        first = plain or "timeline"
        numbered = (f"{first}-{number}" for number in itertools.count(2))
        names.append(next(one for one in itertools.chain([first], numbered) if one not in names))
    return names


def _gallery_page(timelines: Sequence[Timeline], names: Sequence[str], address: str | None) -> str:
    items = "\n".join(
        f'    <li><a href="{name}/"><img src="{name}/{PICTURE}" alt="" width="{WIDTH}" '
        f'height="{HEIGHT}" loading="lazy"><span>{html.escape(timeline.title)}</span></a></li>'
        for timeline, name in zip(timelines, names, strict=True)
    )
    tags = "\n  ".join(link_tags(_GALLERY_TITLE, f"{names[0]}/{PICTURE}", address))
    page = Template((WEB / "gallery.html").read_text(encoding="utf-8"))
    return page.substitute(title=_GALLERY_TITLE, tags=tags, items=items)
