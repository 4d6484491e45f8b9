"""A preset's file, watched: saved in an editor, felt at once."""

from __future__ import annotations

import os
import time
from pathlib import Path

from overview_dsp.design.presets.library import load_preset, preset_path
from overview_dsp.design.presets.model import Preset
from overview_dsp.signal.surface.angle_map import without_map

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
