"""Generated pages of the reference: public names, parameters, presets, and a live page.

They are written before Sphinx reads its sources, into folders that version control ignores. Public
names in no group below are listed under "More".
"""

from __future__ import annotations

import inspect
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.config import Config

import overview_dsp as ov
from overview_dsp.design.presets.describe import describe
from overview_dsp.design.presets.library import preset_path
from overview_dsp.design.presets.reference import reference
from overview_dsp.offline.plots.paper import draw, renders
from overview_dsp.web.static_site import write_site

GROUPS: dict[str, tuple[str, ...]] = {
    "Data": ("load_timeline", "save_timeline", "Timeline", "Event", "Intensity"),
    "Presets": ("load_preset", "bundled_presets", "Preset", "EventKind", "ClickMode"),
    "Gestures": (
        "sweep",
        "tap",
        "pause",
        "parse_gesture",
        "load_gesture",
        "save_gesture",
        "Gesture",
    ),
    "Rendering": (
        "render",
        "render_to_file",
        "render_jobs",
        "render_many",
        "RenderResult",
        "Trace",
        "Strikes",
        "RenderJob",
        "RenderedJob",
    ),
    "Engine": ("Engine", "EngineParameter", "Meters", "Surface", "build_surface"),
    "Actuators": ("load_actuator", "Actuator"),
    "Errors": (
        "OverviewError",
        "InputError",
        "OutputError",
        "NotPreparedError",
        "OverviewWarning",
    ),
}
MODULES = {
    "presets": "reading, writing, morphing",
    "measure": "what is felt and heard",
    "export": "haptic clips",
    "live": "audio outputs",
    "actuators": "profiles of output devices",
}


def _title(text: str, line: str = "=") -> str:
    return f"{text}\n{line * len(text)}\n\n"


def _summary(module: str, names: list[str], heading: str) -> str:
    """Return the autosummary of classes, functions and exceptions, and entries of data."""
    found = getattr(ov, module.partition(".")[2]) if "." in module else ov
    objects = [
        n for n in names if inspect.isclass(getattr(found, n)) or callable(getattr(found, n))
    ]
    data = [n for n in names if n not in objects]
    text = _title(heading, "-") if heading else ""
    if objects:
        rows = "\n".join(f"   {name}" for name in objects)
        text += (
            f".. currentmodule:: {module}\n\n.. autosummary::\n   :toctree: names\n"
            f"   :nosignatures:\n\n{rows}\n\n"
        )
    for name in data:
        line = _data_line(getattr(found, name))
        text += (
            f".. py:data:: {name}\n   :module: {module}\n   :no-contents-entry:\n\n   {line}\n\n"
        )
    return text


def _data_line(value: Any) -> str:
    """Return a summary of a table or a list."""
    if isinstance(value, dict):
        return f"A table of {len(value)} entries by name, ``{next(iter(value))}`` the first."
    if isinstance(value, (tuple, list)) and all(isinstance(item, str) for item in value):
        return "One of " + ", ".join(f"``{item}``" for item in value) + "."
    return f"``{value!r}``"


def api_pages(folder: Path) -> None:
    """Write the page of public names in groups, and a page for each public module."""
    listed = {name for names in GROUPS.values() for name in names}
    rest = [n for n in ov.__all__ if n not in listed and not inspect.ismodule(getattr(ov, n))]
    groups = {title: [n for n in names if n in ov.__all__] for title, names in GROUPS.items()}
    groups["More"] = rest
    text = _title("overview_dsp")
    text += "``import overview_dsp as ov``. Names that are not on these pages are private.\n\n"
    text += "".join(_summary("overview_dsp", n, title) for title, n in groups.items() if n)
    text += _title("Modules", "-") + ".. toctree::\n   :maxdepth: 1\n\n"
    text += "".join(f"   {module_name}\n" for module_name in MODULES)
    (folder / "index.rst").write_text(text, encoding="utf-8")
    for module_name, title in MODULES.items():
        module = getattr(ov, module_name)
        # autodoc imports modules by name; this one is an attribute of `ov`
        sys.modules.setdefault(f"overview_dsp.{module_name}", module)
        public = list(getattr(module, "__all__", ()))
        shared = [n for n in public if n in ov.__all__ and getattr(module, n) is getattr(ov, n)]
        own = [n for n in public if n not in shared]
        page = _title(f"ov.{module_name}: {title}") + f"{inspect.getdoc(module) or ''}\n\n"
        if own:
            page += _summary(f"overview_dsp.{module_name}", own, "")
        if shared:
            names = ", ".join(f":py:obj:`ov.{n} <overview_dsp.{n}>`" for n in shared)
            page += f"Also available from ``ov``: {names}.\n"
        (folder / f"{module_name}.rst").write_text(page, encoding="utf-8")


def preset_pages(folder: Path) -> None:
    """Write the page of all bundled presets, with their headers and values."""
    text = "# Bundled presets\n\nThe header and all values of each file.\n"
    for name in ov.bundled_presets():
        lines = preset_path(name).read_text(encoding="utf-8").splitlines()
        header = []
        for line in lines[1:]:
            if not line.startswith("#"):
                break
            header.append(line.removeprefix("#").strip())
        paragraphs = "\n".join(header).strip()
        for word in ("Feels like:", "Sounds like:", "For:"):
            paragraphs = paragraphs.replace(f"\n{word}", f"\n\n{word}")
            paragraphs = paragraphs.replace(word, f"**{word}**")
        text += f"\n## {name}\n\n{paragraphs}\n\n"
        values = describe(ov.load_preset(name))
        text += f":::{{dropdown}} Every value of {name}\n```text\n{values}\n```\n:::\n"
    (folder / "presets.md").write_text(text, encoding="utf-8")


def shorten(
    application: Sphinx,
    what: str,
    name: str,
    found: Any,
    options: Any,
    arguments: str | None,
    returned: str | None,
) -> tuple[str | None, str | None] | None:
    """Shorten array types in signatures, and remove signatures with arrays as defaults."""
    if arguments and "array(" in arguments:
        return "", None
    arguments = (arguments or "").replace("<factory>", "...")
    spelled = r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[(~[\w.]+)\]\]"
    both = [re.sub(spelled, r"NDArray[\1]", t) if t else t for t in (arguments, returned)]
    return (both[0], both[1]) if any(both) else None


def generate(application: Sphinx, config: Config) -> None:
    """Write all pages."""
    generated = Path(application.srcdir) / "reference" / "generated"
    # delete pages of removed names
    shutil.rmtree(generated, ignore_errors=True)
    (generated / "api").mkdir(parents=True, exist_ok=True)
    api_pages(generated / "api")
    preset_pages(generated)
    (generated / "parameters.md").write_text(reference(), encoding="utf-8")
    made = Path(application.srcdir) / "_generated"
    page = made / "extra" / "demo"
    page.parent.mkdir(parents=True, exist_ok=True)
    match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    draw(match, renders(match, football), made / "figures")
    write_site(match, football, page, levels=0)


def setup(application: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    # before Sphinx reads its sources
    application.connect("config-inited", generate)
    application.connect("autodoc-process-signature", shorten)
    return {"parallel_read_safe": True}
