"""Where modules and names went that programs may import: they work for one release more, and warn.

To go with the release after 0.2.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from importlib.abc import Loader

PACKAGE = __name__.partition(".")[0]

MODULES = {
    "audition": "rendering.audition",
    "force": "force_feedback",
    "many": "rendering.many",
    "measure.feel_report": "measure.report",
    "measure.onsets": "measure.onset_detector",
    "meters": "engine.meters",
    "paper_figures": "plots.paper",
    "parameter": "presets.parameter",
    "saved_state": "presets.dicts",
    "skin": "actuators.sensitivity",
    "sound_file": "files.sound",
    "tuning": "measure.tuning",
    "web.encoding": "export.browser_memory",
}
"""Old module, new module."""

NAMES = {
    "actuators.actuator_names": "actuators.names",
    "actuators.load_actuator": "actuators.load",
    "measure.feel_report.character_steps": "measure.character_steps",
    "measure.feel_report.steps_apart": "measure.steps_apart",
    "measure.onsets.find_onsets": "measure.onsets",
    "plots.draw_timeline": "plots.timeline.draw_timeline",
    "plots.plot_feel": "plots.presets.plot_feel",
    "plots.plot_gallery": "plots.presets.plot_gallery",
    "plots.plot_strokes": "plots.strokes.plot_strokes",
    "plots.plot_timeline": "plots.timeline.plot_timeline",
    "plots.save_figure": "plots.saving.save_figure",
    "plots.save_picture": "plots.saving.save_picture",
    "presets.Kind": "EventKind",
    "presets.Mode": "ClickMode",
    "presets.bundled_names": "presets.bundled",
    "presets.load_preset": "presets.load",
    "presets.preset_path": "presets.library.preset_path",
    "saved_state.decode_state": "engine.state.decode_state",
    "saved_state.encode_state": "engine.state.encode_state",
    "timeline.bundled_timeline": "readers.bundled_timeline",
    "timeline.load_timeline": "load_timeline",
    "timeline.save_timeline": "save_timeline",
    # of the package itself
    "Kind": "EventKind",
    "Mode": "ClickMode",
    "PARAMETERS": "presets.PARAMETERS",
    "Parameter": "presets.Parameter",
    "Setting": "EngineParameter",
    "Voice": "RenderJob",
    "VoiceResult": "RenderedJob",
    "bundled_names": "bundled_presets",
    "rest": "pause",
    "voices": "render_jobs",
}
"""Old name with its module, new one."""


def moved_name(module: str, name: str) -> Any:
    """Look up a name that went elsewhere, and warn whoever asks.

    Parameters
    ----------
    module : str
        Where it was looked for, as the module's `__name__`.
    name : str
        The name.

    Raises
    ------
    AttributeError
        There never was such a name.
    """
    old = f"{module}.{name}".removeprefix(f"{PACKAGE}.")
    if old not in NAMES:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    new = NAMES[old]
    # the frames of this function and of the module's __getattr__
    warnings.warn(f"ov.{old} is ov.{new} now", DeprecationWarning, stacklevel=3)
    found: Any = import_module(PACKAGE)
    for part in new.split("."):
        if isinstance(found, ModuleType) and not hasattr(found, part):
            import_module(f"{found.__name__}.{part}")
        found = getattr(found, part)
    return found


class _Moved(ModuleType):
    """An old module: its names are those of the new one."""

    def __getattr__(self, name: str) -> Any:
        if f"{self.__name__}.{name}".removeprefix(f"{PACKAGE}.") in NAMES:
            return moved_name(self.__name__, name)
        return getattr(_new(self.__name__), name)

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        # importing `measure.feel_report` puts this in place of the function of that name
        return getattr(self, self.__name__.rpartition(".")[2])(*arguments, **keywords)


def _new_name(name: str) -> str | None:
    """The new name of an old module, or of one within an old package."""
    for old, new in MODULES.items():
        whole = f"{PACKAGE}.{old}"
        if name == whole or name.startswith(f"{whole}."):
            return f"{PACKAGE}.{new}{name.removeprefix(whole)}"
    return None


def _new(name: str) -> ModuleType:
    new = _new_name(name)
    assert new is not None
    return import_module(new)


class _Finder:
    """Finds old modules, where no file is found for them, and loads them."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        new = _new_name(name)
        if new is None:
            return None
        from importlib.util import find_spec

        if find_spec(new) is None:
            return None
        return ModuleSpec(name, cast("Loader", self))

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = _Moved(spec.name)
        # a package without a folder: its modules are looked for here too
        module.__path__ = []
        return module

    def exec_module(self, module: ModuleType) -> None:
        new = _new(module.__name__).__name__
        warnings.warn(f"{module.__name__} is {new} now", DeprecationWarning, stacklevel=2)


def find_moved_modules() -> None:
    """Let old modules be found; may be called again."""
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.append(_Finder())
