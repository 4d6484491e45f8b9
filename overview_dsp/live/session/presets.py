"""Presets of a session: watched files, and the pair of which one is chosen."""

from __future__ import annotations

import copy
import os
import time
from pathlib import Path

from overview_dsp.design.presets.library import load_preset, preset_path
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.signal.surface.angle_map import SHARE, without_map

LOOK_EVERY_S = 0.2


class PresetWatch:
    """A preset whose file is watched.

    Thread: control.

    Attributes
    ----------
    preset : Preset
        As its file was when it was last read whole.
    """

    def __init__(self, name: str, linear: bool = False) -> None:
        """Watch a preset by name or path; InputError if there is none or it isn't valid.

        `linear` leaves its angle map out.
        """
        self.path: Path = preset_path(name)
        self.linear = linear
        self.fixed = False
        self._signature = self._look()
        self._name = name
        self.preset: Preset = self._load()
        self._next = 0.0

    def as_it_is(self) -> PresetWatch:
        """Return the preset as it is now, whose file isn't watched."""
        fixed = copy.copy(self)
        fixed.fixed = True
        return fixed

    @property
    def name(self) -> str:
        """Name for the user."""
        return f"{self.preset.name} as it was" if self.fixed else self.path.name

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
        if self.fixed or now < self._next:
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
        self.linear = watch.linear
        self.waiting: int | None = None
        self._compares = other is not None
        self._watches = [watch.as_it_is(), watch] if other is None else [watch, other]
        self._chosen = 1 if other is None else 0
        self._changed: Preset | None = None

    def fitted(self, preset: Preset) -> Preset:
        """Return a preset with the map of this session, where that is one for all presets."""
        if self.linear:
            return without_map(preset)
        if not self._compares:
            return preset
        return preset.with_value(SHARE, self._watches[0].preset.number(SHARE))

    @property
    def preset(self) -> Preset:
        """The chosen one, as its file is."""
        return self.fitted(self._watches[self._chosen].preset)

    @property
    def name(self) -> str:
        """Name of the chosen one for the user."""
        return self._watches[self._chosen].name

    def words(self, which: int) -> str:
        """Return letter and name of one of them for the user."""
        return f"{'AB'[which]}, {self._watches[which].name}"

    def choose(self, which: int) -> Preset:
        """Choose one; return it."""
        self._chosen, self.waiting = which, None
        return self.preset

    def replace(self, watch: PresetWatch) -> Preset:
        """Put another preset in the chosen one's place; return it."""
        if self._watches[0].fixed:  # A stays what B is compared with: the one until now
            self._watches = [self._watches[self._chosen].as_it_is(), watch]
            self._chosen = 1
        else:
            self._watches[self._chosen] = watch
        return watch.preset

    def look(self) -> list[str]:
        """Read files that were saved; return messages for the user."""
        said = []
        for which, watch in enumerate(self._watches):
            try:
                changed = watch.changed()
            except OverviewError as error:
                said.append(f"{error}; the last good one plays on")
                continue
            if changed is not None:
                said.append(f"{watch.name}: read again")
                if which == self._chosen:
                    self._changed = changed
        return said

    def take_changed(self) -> Preset | None:
        """Return the chosen preset, if its file was saved since the last call."""
        changed, self._changed = self._changed, None
        return None if changed is None else self.fitted(changed)
