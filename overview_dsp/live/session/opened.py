"""A player on the device that the user chose: opened, reported, closed and remembered."""

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
from overview_dsp.live.output.saved_settings import resolve_output, save_settings
from overview_dsp.live.output.settings import is_pad
from overview_dsp.live.output.stream_opener import MAX_BLOCK, StreamOpener
from overview_dsp.live.session.growing import Growth
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.live.takes.recovery import take_cut_short
from overview_dsp.signal.actuators.stage import warn_of_carrier
from overview_dsp.signal.engine.coefficients import announce_compile


@dataclass(frozen=True)
class PlayerSettings:
    """Settings that a player is opened with.

    Parameters
    ----------
    preset
        Name or path.
    compare
        A second preset to switch to, or None.
    linear
        Whether the presets' angle maps are left out.
    window
        The part of the timeline (s) that is shown first; None is the whole.
    growth
        How the session follows a timeline that grows; None for one that is finished.
    device
        Output: name or number; None is the default, `"none"` no sound, `"pad"` a game pad.
    block_size
        Frames; 0 is the device's own.
    sample_rate
        Hz; None is the device's own.
    callback
        What PortAudio calls.
    actuator
        Name or file; `"none"` for none, None for the one last used with the device.
    click, tactor
        Changes to the settings last used with the device: fields of `SignalSettings`.
    record
        File that the take is written to, from the first sample on; None for none.
    seed
        Of the texture noise.
    """

    preset: str
    compare: str | None = None
    linear: bool = False
    window: tuple[float, float] | None = None
    growth: Growth | None = None
    device: str | None = None
    block_size: int = 256
    sample_rate: float | None = None
    callback: CallbackKind = "native"
    actuator: str | None = None
    click: Mapping[str, Any] = field(default_factory=dict)
    tactor: Mapping[str, Any] = field(default_factory=dict)
    record: str | None = None
    seed: int = 0


class OpenedPlayer:
    """A player that is opened by settings; as a context it gives the player, and closes it.

    Closed, it saves the take, and remembers the settings of the device if they were changed.
    """

    def __init__(
        self,
        timeline: Timeline,
        settings: PlayerSettings,
        note: Callable[[str], None],
        say: Callable[[str], None],
    ) -> None:
        """Open it; `note` receives messages for the user, `say` a line on each take in the end.

        Raises
        ------
        OverviewError
            A device, file or value that can't be used.
        """
        self._note, self._say = note, say
        self._window = settings.window and timeline.require_window(*settings.window)
        self._opener = StreamOpener(settings.device, settings.block_size, settings.callback)
        if settings.record is not None:
            require_writable(settings.record)
            require_writable(os.path.splitext(settings.record)[0] + ".json")
        for take in take_cut_short():
            note(f"a take was cut short; it is in {take} (overview render ... --gesture {take})")
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
            driven = "none" if output.actuator is None else output.actuator.name
            note(f"{self._device} is a pad: {output.placed}, actuator {driven}")
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
            growth=settings.growth,
        )

    def __enter__(self) -> Player:
        if self._window is not None:
            self.player.show(*self._window)
        return self.player

    def __exit__(self, *error: object) -> None:
        self.player.close()
        for message in self.player.take_messages():
            self._note(message)
        for line in self.player.takes.words:
            self._say(line)
        # what belongs to another device, chosen meanwhile, isn't this one's
        same = self.player.output.opener is self._opener
        played = self.player.output.settings
        if same and self._device is not None and self._resolved.differ(played):
            save_settings(self._device, played)
