"""A preset's file, watched: saved in an editor, felt at once.

The two presets of a session: the one whose file is edited, and what it is compared with.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

from overview_dsp.design.presets.library import load_preset, preset_path
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.signal.surface.angle_map import SHARE, without_map

LOOK_EVERY_S = 0.2


class PresetWatch:
    """Reports when a preset's file has changed and is whole.

    Thread: control.
    """

    def __init__(self, name: str, linear: bool = False) -> None:
        """Watch a preset by name or path; InputError if there is none or it isn't valid.

        `linear` leaves its angle map out.
        """
        self.path: Path = preset_path(name)
        self.linear = linear
        self._signature = self._look()
        self._name = name
        self.preset: Preset = self._load()
        self._next = 0.0

    def _load(self) -> Preset:
        preset = load_preset(self._name)
        return without_map(preset) if self.linear else preset

    def _look(self) -> tuple[int, int, int] | None:
        try:
            status = os.stat(self.path)
        except OSError:  # between an editor's delete and rename
            return None
        return status.st_mtime_ns, status.st_size, status.st_ino

    def changed(self) -> Preset | None:
        """The preset if its file has changed since the last call, else None.

        Raises
        ------
        InputError
            It has changed, and isn't valid now: the last good one goes on.
        """
        now = time.monotonic()
        if now < self._next:
            return None
        self._next = now + LOOK_EVERY_S
        signature = self._look()
        if signature is None or signature == self._signature:
            return None
        self._signature = signature
        preset = self._load()
        if preset == self.preset:
            return None
        self.preset = preset
        return preset


class PresetPair:
    """A and B, one of them chosen: two watched files, or one file as it was and as it is now.

    Two files are compared on one map between time and angle, A's.

    Thread: control.

    Attributes
    ----------
    linear : bool
        Whether presets are used without their angle map.
    waiting : int or None
        The one (0 or 1) that is to be chosen when a loop begins.
    """

    def __init__(self, watch: PresetWatch, other: PresetWatch | None = None) -> None:
        """`watch` is chosen first. Without `other`, A is its file as it is now."""
        self._before = watch.preset
        self.linear, self._compares = watch.linear, other is not None
        self._watches = (None, watch) if other is None else (watch, other)
        self._chosen = 1 if other is None else 0
        self._changed: Preset | None = None
        self.waiting: int | None = None

    def _preset(self, which: int) -> Preset:
        watch = self._watches[which]
        return self._before if watch is None else self.fitted(watch.preset)

    def fitted(self, preset: Preset) -> Preset:
        """A preset with the map of this session, where that is one for all presets."""
        if self.linear:
            return without_map(preset)
        first = self._watches[0]
        if not self._compares or first is None:
            return preset
        return preset.with_value(SHARE, first.preset.number(SHARE))

    @property
    def preset(self) -> Preset:
        """The chosen one, as its file is."""
        return self._preset(self._chosen)

    @property
    def name(self) -> str:
        """The chosen one's file."""
        watch = self._watches[self._chosen]
        return self._before.name if watch is None else watch.path.name

    @property
    def letter(self) -> str:
        """The chosen one: A or B."""
        return "AB"[self._chosen]

    def words(self, which: int) -> str:
        """One of them, for a person."""
        watch = self._watches[which]
        what = f"{self._before.name} as it was" if watch is None else watch.path.name
        return f"{'AB'[which]}, {what}"

    def choose(self, which: int) -> Preset:
        """Choose one; it."""
        self._chosen, self.waiting = which, None
        return self.preset

    def replace(self, watch: PresetWatch) -> Preset:
        """Put another preset in the chosen one's place; it."""
        self._before = self.preset
        if self._watches[0] is None:
            self._watches, self._chosen = (None, watch), 1
        else:
            first, second = self._watches
            self._watches = (watch, second) if self._chosen == 0 else (first, watch)
        return watch.preset

    def look(self) -> list[str]:
        """See whether a file was saved; what a person should know."""
        said = []
        for which, watch in enumerate(self._watches):
            if watch is None:
                continue
            try:
                changed = watch.changed()
            except OverviewError as error:
                said.append(f"{error}; the last good one plays on")
                continue
            if changed is not None:
                said.append(f"{watch.path.name}: read again")
                if which == self._chosen:
                    self._changed = changed
        return said

    def take_changed(self) -> Preset | None:
        """The chosen preset, if its file was saved since the last call."""
        changed, self._changed = self._changed, None
        return None if changed is None else self.fitted(changed)
