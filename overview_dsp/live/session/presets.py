"""Presets of a session: watched files, and a pair of which one is active."""

from __future__ import annotations

import copy
import os
import time
from collections.abc import Sequence
from pathlib import Path

from overview_dsp.design.presets.library import load_preset, preset_path
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.signal.surface.angle_map import SHARE, without_map

CHECK_EVERY_S = 0.2
MISSING_CHECKS = 5
"""Number of checks without a file after which it is reported; an editor replaces it sooner."""


class PresetWatch:
    """Preset whose file is checked for changes.

    Thread: control.

    `preset`: preset of the last valid version of the file.
    """

    def __init__(self, name: str, linear: bool = False) -> None:
        """Watch a preset by name or path; InputError if it doesn't exist or isn't valid.

        `linear` removes its angle map.
        """
        self.path: Path = preset_path(name)
        self.linear = linear
        self.fixed = False
        self._signature = self._read_signature()
        self._missing = 0
        self._name = name
        self.preset: Preset = self._load()
        self._check_at = 0.0

    def snapshot(self) -> PresetWatch:
        """Return the present version of the preset, whose file isn't watched."""
        fixed = copy.copy(self)
        fixed.fixed = True
        return fixed

    @property
    def name(self) -> str:
        """Name for the user."""
        return f"{self.preset.name}, earlier version" if self.fixed else self.path.name

    def _load(self) -> Preset:
        preset = load_preset(self._name)
        return without_map(preset) if self.linear else preset

    def _read_signature(self) -> tuple[int, int, int] | None:
        try:
            status = os.stat(self.path)
        except OSError:  # between an editor's delete and rename
            return None
        return status.st_mtime_ns, status.st_size, status.st_ino

    def pop_changed(self) -> Preset | None:
        """Return the preset if its file has changed since the last call; otherwise None.

        InputError: the changed file isn't valid, or was deleted. `preset` stays the last valid
            version.
        """
        now = time.monotonic()
        if self.fixed or now < self._check_at:
            return None
        self._check_at = now + CHECK_EVERY_S
        signature = self._read_signature()
        self._missing = 0 if signature is not None else self._missing + 1
        if self._missing == MISSING_CHECKS:
            raise InputError(f"{self.path}: the file was deleted or moved")
        if signature is None or signature == self._signature:
            return None
        self._signature = signature
        preset = self._load()
        if preset == self.preset:
            return None
        self.preset = preset
        return preset


class PresetPair:
    """Presets A and B, one of which is active.

    They are two watched files, or an earlier and the present version of one file. Two files use
    one angle map, that of A.

    Thread: control.

    `linear`: whether presets are used without their angle map.
    `next_choice`: preset (0 or 1) that becomes active at the start of the next loop pass.
    """

    def __init__(self, watch: PresetWatch, other: PresetWatch | None = None) -> None:
        """Make `watch` active. Without `other`, A is the present version of its file."""
        self.linear = watch.linear
        self.next_choice: int | None = None
        self._compares = other is not None
        self._watches = [watch.snapshot(), watch] if other is None else [watch, other]
        self._chosen = 1 if other is None else 0
        self._changed: Preset | None = None

    def with_session_map(self, preset: Preset) -> Preset:
        """Return a preset with the angle map that all presets of this session use, if any."""
        if self.linear:
            return without_map(preset)
        if not self._compares:
            return preset
        return preset.with_value(SHARE, self._watches[0].preset.number(SHARE))

    @property
    def preset(self) -> Preset:
        """Active preset, in the last valid version of its file."""
        return self.with_session_map(self._watches[self._chosen].preset)

    @property
    def name(self) -> str:
        """Name of the active preset for the user."""
        return self._watches[self._chosen].name

    def label(self, index: int) -> str:
        """Return letter and name of a preset (0 or 1) for the user."""
        return f"{'AB'[index]}, {self._watches[index].name}"

    def choose(self, index: int) -> Preset:
        """Make a preset (0 or 1) active; return it."""
        self._chosen, self.next_choice = index, None
        return self.preset

    def replace(self, watch: PresetWatch) -> Preset:
        """Replace the active preset by another one; return the new one."""
        if self._watches[0].fixed:  # A becomes the preset that was active until now
            self._watches = [self._watches[self._chosen].snapshot(), watch]
            self._chosen = 1
        else:
            self._watches[self._chosen] = watch
        return watch.preset

    def fix(self, presets: Sequence[Preset]) -> None:
        """Replace A and B by two presets, whose files aren't watched."""
        self._watches = [watch.snapshot() for watch in self._watches]
        for watch, preset in zip(self._watches, presets, strict=True):
            watch.preset = preset

    def check_files(self) -> list[str]:
        """Read files that were saved; return messages for the user."""
        messages = []
        for index, watch in enumerate(self._watches):
            try:
                changed = watch.pop_changed()
            except OverviewError as error:
                messages.append(f"{error}; the previous version stays active")
                continue
            if changed is not None:
                messages.append(f"{watch.name}: read again")
                if index == self._chosen:
                    self._changed = changed
        return messages

    def pop_changed(self) -> Preset | None:
        """Return the active preset if its file was saved since the last call; otherwise None."""
        changed, self._changed = self._changed, None
        return None if changed is None else self.with_session_map(changed)
