"""Opening a player on the device that the user chose, and saving its settings at the end."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.data.timeline import Timeline
from overview_dsp.files.atomic import require_writable
from overview_dsp.live.output.devices import find_device
from overview_dsp.live.output.portaudio_library import SILENT, device_named
from overview_dsp.live.output.portaudio_stream import CallbackKind
from overview_dsp.live.output.reconnecting_stream import MAX_BLOCK, StreamOpener
from overview_dsp.live.output.settings import is_pad, resolve_output, save_settings
from overview_dsp.live.session.live_updates import FollowSettings
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.live.takes.recovery import pop_interrupted_takes
from overview_dsp.signal.actuators.stage import warn_of_carrier
from overview_dsp.signal.engine.coefficients import announce_compile


@dataclass(frozen=True)
class PlayerSettings:
    """Settings that a player is opened with."""

    preset: str  # name or path
    compare: str | None = None  # second preset to switch to
    linear: bool = False  # whether the presets are used without their angle maps
    window: tuple[float, float] | None = None  # first window, s; None: the whole timeline
    follow: FollowSettings | None = None  # of a live timeline
    device: str | None = None  # name or number; None: the default; "none": no sound; "pad"
    block_size: int = 256  # frames; 0 lets the device choose
    sample_rate: float | None = None  # Hz; None: the device's default
    callback: CallbackKind = "native"
    actuator: str | None = None  # name or file; "none" removes it; None: the last of the device
    # changes to the settings last used with the device, as fields of `SignalSettings`
    click: Mapping[str, Any] = field(default_factory=dict)
    tactor: Mapping[str, Any] = field(default_factory=dict)
    record: str | None = None  # file of a take that starts at the first sample
    seed: int = 0  # of the texture noise


class OpenedPlayer:
    """Context manager that opens a player and closes it.

    At the end it saves the take, and the device's settings if they were changed.
    """

    def __init__(
        self,
        timeline: Timeline,
        settings: PlayerSettings,
        note: Callable[[str], None],
        say: Callable[[str], None],
    ) -> None:
        """Open the player; `note` receives messages, `say` one line per take at the end.

        OverviewError: a device, file or value can't be used.
        """
        self._note, self._say = note, say
        self._window = settings.window and timeline.require_window(*settings.window)
        self._opener = StreamOpener(settings.device, settings.block_size, settings.callback)
        if settings.record is not None:
            require_writable(settings.record)
            require_writable(os.path.splitext(settings.record)[0] + ".json")
        for take in pop_interrupted_takes():
            note(f"interrupted take saved as {take} (overview render ... --gesture {take})")
        watch = PresetWatch(settings.preset, settings.linear)
        other = None if settings.compare is None else PresetWatch(settings.compare, settings.linear)
        self._device, rate, channels = None, 48_000.0, 0  # without sound
        if settings.device != SILENT:
            device = find_device(device_named(settings.device))
            self._device, rate, channels = device.full_name, device.sample_rate, device.channels
        changes = settings.click, settings.tactor
        self._resolved = resolve_output(self._device, *changes, settings.actuator, channels)
        output = self._resolved.settings
        if self._device is not None and is_pad(self._device, channels):
            actuator = "none" if output.actuator is None else output.actuator.name
            note(f"{self._device} is a game pad: {output.channels_text}, actuator {actuator}")
        if output.actuator is not None:
            warn_of_carrier(output.actuator, watch.preset.number("tactor.frequency_hz"))
        native = settings.callback == "native" and self._device is not None
        announce_compile("process", "callback" if native else "finish_block")
        self.player = Player(
            timeline,
            watch,
            self._opener,
            output,
            sample_rate=settings.sample_rate or rate,
            max_block_size=MAX_BLOCK,
            callback="native" if native else "python",
            record=settings.record,
            seed=settings.seed,
            other=other,
            follow=settings.follow,
        )

    def __enter__(self) -> Player:
        if self._window is not None:
            self.player.show(*self._window)
        return self.player

    def __exit__(self, *error: object) -> None:
        self.player.close()
        for message in self.player.take_messages():
            self._note(message)
        for line in self.player.takes.summaries:
            self._say(line)
        # settings are saved only if the user did not change to another device
        same = self.player.output.opener is self._opener
        last = self.player.output.settings
        if same and self._device is not None and self._resolved.differ(last):
            save_settings(self._device, last)
