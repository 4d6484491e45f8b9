"""A folder that any web host can serve: the page, its kernel, and a timeline with its windows.

It needs no server of ours and, once loaded, no network. `files.js` lists every file with a digest
of all of them, from which the page's service worker knows what to keep and when to renew it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from importlib import resources
from typing import Any

from overview_dsp.actuators import Actuator
from overview_dsp.files import whole_folder
from overview_dsp.presets.model import Preset
from overview_dsp.surface import build_surface
from overview_dsp.timeline import Timeline
from overview_dsp.web.site_data import timeline_json, window_json
from overview_dsp.web.site_sound import patch_of, whole_bytes, window_bytes
from overview_dsp.web.site_windows import site_windows

RATES = (48_000, 44_100)
"""What browsers play at, Hz; others resample."""

KERNEL_FILES = ("kernel.js", "kernel.wasm", "kernel_node.js", "layout.js", "processor.js")
MARK = "files.js"
"""The file by which a folder is known as one of ours."""


def page_files() -> dict[str, bytes]:
    """The page's own files by their path in the folder, the same for every timeline."""
    package = resources.files("overview_dsp.web")
    files = {name: (package / name).read_bytes() for name in KERNEL_FILES}
    for one in sorted((package / "site").iterdir(), key=lambda file: file.name):
        if one.is_file():
            files[one.name] = one.read_bytes()
    return files


def write_site(
    timeline: Timeline,
    preset: Preset,
    path: str | os.PathLike[str],
    *,
    levels: int = 2,
    seed: int = 0,
    actuator: Actuator | None = None,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Write the folder, whole or not at all; its size in bytes.

    Parameters
    ----------
    path
        A new or empty folder, or one that this wrote before.
    levels
        How many times the page can zoom, 0 to 3.
    actuator
        What the tactor's signal drives.

    Raises
    ------
    InputError
        The folder can't be written or holds other files; a surface that can't be made.
    """
    parts = site_windows(timeline, levels)
    with whole_folder(path, MARK) as folder:
        listed: dict[str, list[str]] = {"page": [], "more": []}
        digest = hashlib.sha256()
        size = 0

        def put(name: str, content: bytes, group: str = "page") -> None:
            nonlocal size
            place = folder / name
            place.parent.mkdir(exist_ok=True)
            place.write_bytes(content)
            listed[group].append(name)
            digest.update(name.encode() + content)
            size += len(content)

        def put_sound(name: str, at_rates: list[bytes], group: str = "page") -> None:
            put(f"sound/{name}.bin", at_rates[0], group)
            for rate, content in zip(RATES[1:], at_rates[1:], strict=True):
                put(f"sound/{name}-{rate}.patch", patch_of(at_rates[0], content), group)

        for name, content in page_files().items():
            put(name, content)
        put("data/timeline.json", _json(timeline_json(timeline, preset, parts, RATES)))
        for i, part in enumerate(parts):
            group = "page" if i == 0 else "more"
            shown = timeline if i == 0 else timeline.window(part.start_s, part.end_s)
            surface = build_surface(shown, preset)
            put(f"data/window-{i}.json", _json(window_json(shown, surface, part)), group)
            if i == 0:
                put_sound("0", [whole_bytes(timeline, preset, at, seed, actuator) for at in RATES])
            if len(parts) > 1:
                name = "back" if i == 0 else str(i)
                put_sound(name, [window_bytes(surface, preset, at) for at in RATES], "more")
            if progress is not None:
                progress((i + 1) / len(parts))
        told = {"version": digest.hexdigest()[:16], **listed}
        (folder / MARK).write_text(f"self.FILES = {json.dumps(told)};\n", encoding="utf-8")
    return size


def _json(document: dict[str, Any]) -> bytes:
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()
