"""A static folder with several timelines: an index page, and one subfolder per timeline."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Callable, Sequence
from typing import Any

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import atomic_folder
from overview_dsp.web.assets import START, page_files
from overview_dsp.web.static_site import HEIGHT, PICTURE, WIDTH, link_tags, write_site

MARKER_FILE = "gallery.txt"
"""File that marks a gallery folder; it lists the subfolders, one per line."""

_FILES = ("style.css", "icon.svg", "icon-192.png")
_TITLE = "Timelines to feel"
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
    files = {name: page_files()[name] for name in _FILES}
    files[MARKER_FILE] = "".join(f"{name}\n" for name in names).encode()
    files[START] = _page([timeline for timeline, _ in items], names, address).encode()
    size = sum(map(len, files.values()))
    with atomic_folder(path, MARKER_FILE) as folder:
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
        name, number = plain or "timeline", 1
        while name in names:
            number += 1
            name = f"{plain or 'timeline'}-{number}"
        names.append(name)
    return names


def _page(timelines: Sequence[Timeline], names: Sequence[str], address: str | None) -> str:
    items = "\n".join(
        f'    <li><a href="{name}/"><img src="{name}/{PICTURE}" alt="" width="{WIDTH}" '
        f'height="{HEIGHT}" loading="lazy"><span>{html.escape(timeline.title)}</span></a></li>'
        for timeline, name in zip(timelines, names, strict=True)
    )
    tags = "\n  ".join(link_tags(_TITLE, f"{names[0]}/{PICTURE}", address))
    return f"""<!doctype html>
<html lang="en">
<head>
  <meta charset="utf-8">
  <meta name="viewport" content="width=device-width, initial-scale=1, viewport-fit=cover">
  <meta name="color-scheme" content="light dark">
  <title>{_TITLE}</title>
  {tags}
  <link rel="icon" href="icon.svg" type="image/svg+xml">
  <link rel="apple-touch-icon" href="icon-192.png">
  <link rel="stylesheet" href="style.css">
</head>
<body class="gallery">
  <main>
  <h1>{_TITLE}</h1>
  <ul>
{items}
  </ul>
  </main>
</body>
</html>
"""
