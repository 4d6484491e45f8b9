"""`overview actuators calibrate`: where a person begins to feel."""

from __future__ import annotations

import math
import queue
import random
import statistics
import sys
import threading
from dataclasses import replace
from typing import TYPE_CHECKING

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, note, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.output import DEVICE
from overview_dsp.errors import InputError
from overview_dsp.live.output.portaudio_library import SILENT

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from overview_dsp.live.output.sample_player import SamplePlayback
    from overview_dsp.live.output.settings import OutputSettings
    from overview_dsp.signal.actuators.model import Actuator

TRIES = 3
"""How often a tone may be answered before it sounds."""

SPREAD_DB = 6.0
"""Answers further apart than this deserve a word."""


@cli_command("actuators calibrate c2 --device 2")
def calibrate(
    name: str,
    *,
    device: str | None = DEVICE,
    channel: str | None = option(
        "Output channel, from 1, or several (3+4).  [default: as remembered]", metavar="N[+N]"
    ),
    frequency: float | None = option("Hz.  [default: the actuator's resonance]"),
    ramp: float = option("Rise of the tone, dB per second.", default=3.0),
    repeats: int = option("Tones to answer.", type=click.IntRange(1, 20), default=3),
    threshold: float | None = option("Store this threshold, without a tone.", metavar="DB"),
    reset_threshold: bool = option("Remove the stored threshold: presets play as made."),
    as_json: bool = JSON,
) -> None:
    """Find the level at which you begin to feel the actuator NAME, and keep a gain for it.

    Hold it as you will in use. A tone rises; press Enter as soon as you feel it. From then on
    --actuator NAME drives it so much more, or less, that what presets do is as far above your
    threshold as they mean it.
    """
    from overview_dsp.signal.actuators.calibration import (
        calibration_file,
        forget_threshold,
        gain_for,
        save_threshold,
    )

    actuator = ov.load_actuator(name)
    if reset_threshold:
        if threshold is not None:
            raise InputError("--threshold and --reset-threshold are opposites; give one of them")
        known = forget_threshold(actuator)
        click.echo(f"{actuator.name}: {'forgotten' if known else 'was not calibrated'}")
        return
    levels = []
    if threshold is None:
        levels = _answers(actuator, device, channel, frequency, ramp, repeats)
        threshold = statistics.median(levels)
        if max(levels) - min(levels) > SPREAD_DB:
            note(
                f"your answers lie {max(levels) - min(levels):.0f} dB apart; calibrate again in "
                "quiet, held the same way"
            )
    threshold = round(threshold, 2)
    save_threshold(actuator, threshold)
    gain = gain_for(threshold)
    report = {
        "actuator": actuator.name,
        "threshold_db": threshold,
        "gain_db": gain,
        "levels_db": [round(level, 2) for level in levels],
        "file": str(calibration_file()),
    }
    line = (
        f"{actuator.name}: felt from {threshold:.1f} dB of its nominal drive on, gain "
        f"{gain:+.1f} dB, kept in {calibration_file()}"
    )
    show(as_json, report, line)


def _answers(
    actuator: Actuator,
    device: str | None,
    channel: str | None,
    frequency: float | None,
    db_per_s: float,
    repeats: int,
) -> list[float]:
    """The levels at which a person pressed, dB of the nominal drive."""
    from overview_dsp.live.output.threshold import SILENCE_S, RisingTone, find_threshold

    settings, name, rate, index = _output(device, channel)
    out, channels = settings.tactor, settings.channels
    place = " and ".join(map(str, out.channels))
    hertz = actuator.resonance_hz if frequency is None else frequency
    announce_compile("drive_block")
    RisingTone(hertz, db_per_s, 0.0).drive(actuator, out, channels, rate)  # refuses wrong options
    keys = _Keys()
    levels: list[float] = []
    early = 0
    click.echo(
        f"{actuator.title} on {name}, channel {place}, {hertz:g} Hz. Hold it as you will in "
        "use; press Enter as soon as you feel it.",
        err=True,
    )
    while len(levels) < repeats:
        rise = RisingTone(hertz, db_per_s, random.uniform(*SILENCE_S))
        samples = rise.drive(actuator, out, channels, rate)
        click.echo(f"tone {len(levels) + 1} of {repeats} ...", err=True)
        keys.forget()
        level = find_threshold(rise, _playback(device, index, samples, rate), keys.pressed)
        if math.isfinite(level):
            click.echo(f"felt at {level:.1f} dB", err=True)
            levels.append(level)
        elif level > 0.0:
            raise InputError(
                f"{actuator.name}: nothing was felt up to the end; check that it is on channel "
                f"{place} of {name} and its amplifier is on, or press sooner"
            )
        else:
            early += 1
            if early > TRIES:
                raise InputError("pressed before each tone; wait until you feel one")
            click.echo("too early: there was no tone yet", err=True)
    return levels


def _output(
    device: str | None, channel: str | None
) -> tuple[OutputSettings, str, float, int | None]:
    """Return the tactor's output alone, and the device's name, rate (Hz) and index."""
    from overview_dsp.live.output.devices import find_device
    from overview_dsp.live.output.portaudio_library import device_named
    from overview_dsp.live.output.saved_settings import load_settings
    from overview_dsp.live.output.settings import OutputSettings, SignalSettings, parse_channels

    if device == SILENT:
        settings, name, rate, index = OutputSettings(), "no output", 48_000.0, None
    else:
        found = find_device(device_named(device))
        name, rate, index = found.full_name, found.sample_rate, found.index
        settings = load_settings(name, found.channels)
    tactor = settings.tactor
    if channel is not None:
        tactor = replace(tactor, channel=parse_channels(channel))
    if not tactor.channels:
        raise InputError(f"the tactor is on no channel of {name}; give one with --channel")
    return OutputSettings(SignalSettings(0), tactor), name, rate, index


def _playback(
    device: str | None, index: int | None, samples: NDArray[np.float32], rate: float
) -> SamplePlayback:
    from overview_dsp.live.output.sample_player import NullSamplePlayer, SamplePlayer

    if device == SILENT:
        return NullSamplePlayer(samples, rate)
    return SamplePlayer(samples, rate, index)


class _Keys:
    """Lines of standard input, read by a thread."""

    WAIT_S = 0.01

    def __init__(self) -> None:
        self._lines: queue.Queue[bool] = queue.Queue()
        threading.Thread(target=self._read, name="standard input", daemon=True).start()

    def _read(self) -> None:
        for _ in iter(sys.stdin.readline, ""):
            self._lines.put(True)
        self._lines.put(False)

    def forget(self) -> None:
        """Throw away what was pressed before, but not the input's end."""
        while not self._lines.empty():
            if not self._lines.get():
                self._lines.put(False)
                return

    def pressed(self) -> bool:
        """Whether Enter was pressed, after a little wait; InputError if nobody can any more."""
        try:
            if self._lines.get(timeout=self.WAIT_S):
                return True
        except queue.Empty:
            return False
        raise InputError("standard input ended before the tone was felt; run it in a terminal")
