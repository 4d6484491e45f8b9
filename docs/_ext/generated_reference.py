"""Pages that the package itself writes: public names, commands, parameters, presets, a live page.

They are made before Sphinx reads its sources, into folders that version control ignores, so the
reference can't fall behind: a public name that stands in no group below is listed all the same.
"""

from __future__ import annotations

import inspect
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import click
from sphinx.application import Sphinx
from sphinx.config import Config

import overview_dsp as ov
from overview_dsp.cli import COMMANDS, INSTALLED_APART, added_commands, app
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
FACES = {
    "presets": "reading, writing, blending",
    "measure": "what a finger or an ear gets",
    "export": "haptic clips",
    "live": "audio outputs",
    "actuators": "what the tactor's signal drives",
}


def _title(text: str, line: str = "=") -> str:
    return f"{text}\n{line * len(text)}\n\n"


def _summary(module: str, names: list[str], heading: str) -> str:
    """An autosummary of classes, functions and exceptions; data as their first lines."""
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
    """What a table or a list holds, without printing all of it."""
    if isinstance(value, dict):
        return f"A table of {len(value)} entries by name, ``{next(iter(value))}`` the first."
    if isinstance(value, (tuple, list)) and all(isinstance(item, str) for item in value):
        return "One of " + ", ".join(f"``{item}``" for item in value) + "."
    return f"``{value!r}``"


def api_pages(folder: Path) -> None:
    """The public names in groups, and a page for each face."""
    listed = {name for names in GROUPS.values() for name in names}
    rest = [n for n in ov.__all__ if n not in listed and not inspect.ismodule(getattr(ov, n))]
    groups = {title: [n for n in names if n in ov.__all__] for title, names in GROUPS.items()}
    groups["More"] = rest
    text = _title("overview_dsp")
    text += "``import overview_dsp as ov``. What is not on these pages is private and may move.\n\n"
    text += "".join(_summary("overview_dsp", n, title) for title, n in groups.items() if n)
    text += _title("Faces", "-") + ".. toctree::\n   :maxdepth: 1\n\n"
    text += "".join(f"   {face}\n" for face in FACES)
    (folder / "index.rst").write_text(text, encoding="utf-8")
    for face, words in FACES.items():
        module = getattr(ov, face)
        # a name of `ov`, not a module's: autodoc imports what it documents
        sys.modules.setdefault(f"overview_dsp.{face}", module)
        public = list(getattr(module, "__all__", ()))
        shared = [n for n in public if n in ov.__all__ and getattr(module, n) is getattr(ov, n)]
        own = [n for n in public if n not in shared]
        page = _title(f"ov.{face}: {words}") + f"{inspect.getdoc(module) or ''}\n\n"
        if own:
            page += _summary(f"overview_dsp.{face}", own, "")
        if shared:
            names = ", ".join(f":py:obj:`ov.{n} <overview_dsp.{n}>`" for n in shared)
            page += f"Here too, as in ``ov`` itself: {names}.\n"
        (folder / f"{face}.rst").write_text(page, encoding="utf-8")


def command_pages(folder: Path) -> None:
    """A page a command, in the order of ``overview --help``."""
    text = _title("Command line")
    text += (
        "``overview COMMAND --help`` says the same. Exit codes: 0 done, 1 failed, 2 bad input.\n\n"
    )
    places = {name: f"overview_dsp.cli.{module}:command" for name, (module, _) in COMMANDS.items()}
    context = click.Context(app)
    for name in (*COMMANDS, *INSTALLED_APART):  # one that isn't installed prints how to install it
        assert app.get_command(context, name) is not None
    places |= {name: added_commands()[name].value for name in INSTALLED_APART}
    text += ".. toctree::\n   :maxdepth: 1\n\n" + "".join(f"   {name}\n" for name in places)
    (folder / "index.rst").write_text(text, encoding="utf-8")
    for name, place in places.items():
        page = f".. click:: {place}\n   :prog: overview {name}\n   :nested: full\n"
        (folder / f"{name}.rst").write_text(page, encoding="utf-8")


def preset_pages(folder: Path) -> None:
    """A page of all bundled presets: their headers, and every value folded away."""
    text = "# Bundled presets\n\nWhat each file says of itself, and every value.\n"
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
    """Array types as they are written in the sources, not as numpy spells them out.

    A constructor whose defaults are arrays is left out: its attributes are documented, and nobody
    calls it.
    """
    if arguments and "array(" in arguments:
        return "", None
    arguments = (arguments or "").replace("<factory>", "...")
    spelled = r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[(~[\w.]+)\]\]"
    both = [re.sub(spelled, r"NDArray[\1]", t) if t else t for t in (arguments, returned)]
    return (both[0], both[1]) if any(both) else None


def generate(application: Sphinx, config: Config) -> None:
    """All of them."""
    generated = Path(application.srcdir) / "reference" / "generated"
    # or pages of names that are gone stay
    shutil.rmtree(generated, ignore_errors=True)
    for part in ("api", "cli"):
        (generated / part).mkdir(parents=True, exist_ok=True)
    api_pages(generated / "api")
    command_pages(generated / "cli")
    preset_pages(generated)
    (generated / "parameters.md").write_text(reference(), encoding="utf-8")
    made = Path(application.srcdir) / "_generated"
    page = made / "extra" / "demo"
    page.parent.mkdir(parents=True, exist_ok=True)
    match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    draw(match, renders(match, football), made / "figures")
    write_site(match, football, page, levels=0)


def setup(application: Sphinx) -> dict[str, bool]:
    """Sphinx's entry."""
    # before Sphinx looks for its sources
    application.connect("config-inited", generate)
    application.connect("autodoc-process-signature", shorten)
    return {"parallel_read_safe": True}
