"""The command `overview actuators calibrate`: the threshold of a user."""

from __future__ import annotations

import math
import random
import statistics
from dataclasses import replace
from typing import TYPE_CHECKING

import click

import overview_dsp as ov
from overview_dsp.cli.common import LineReader, announce_compile, note, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.cli.options.output import DEVICE, sample_player, saved_output
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.live.output.settings import OutputSettings
    from overview_dsp.signal.actuators.model import Actuator

MAX_EARLY = 3  # maximum number of answers before a tone
SPREAD_DB = 6.0  # range of answers that causes a note, dB


@cli_command("actuators calibrate c2 --device 2")
def calibrate(
    name: str,
    *,
    device: str | None = DEVICE,
    channel: str | None = option(metavar="N[+N]"),
    frequency: float | None = option(),
    ramp: float = option(default=3.0),
    repeats: int = option(type=click.IntRange(1, 20), default=3),
    threshold: float | None = option(metavar="DB"),
    reset_threshold: bool = option(),
    as_json: bool = JSON,
) -> None:
    """Measure the weakest level at which you feel the actuator NAME, and save a gain for it.

    Hold the actuator as in use. A tone rises; press Enter as soon as you feel it. --actuator NAME
    then applies the gain, so that presets are as far above your threshold as intended.
    """
    from overview_dsp.signal.actuators import calibration

    actuator = ov.load_actuator(name)
    if reset_threshold:
        if threshold is not None:
            raise InputError("--threshold and --reset-threshold exclude each other; remove one")
        known = calibration.forget_threshold(actuator)
        click.echo(f"{actuator.name}: {'threshold removed' if known else 'was not calibrated'}")
        return
    levels = []
    if threshold is None:
        levels = _answers(actuator, device, channel, frequency, ramp, repeats)
        threshold = statistics.median(levels)
        if max(levels) - min(levels) > SPREAD_DB:
            note(
                f"your answers differ by {max(levels) - min(levels):.0f} dB; calibrate again in a "
                "quiet place, and hold the actuator the same way"
            )
    threshold = round(threshold, 2)
    calibration.save_threshold(actuator, threshold)
    gain = calibration.gain_for(threshold)
    report = {
        "actuator": actuator.name,
        "threshold_db": threshold,
        "gain_db": gain,
        "levels_db": [round(level, 2) for level in levels],
        "file": str(calibration.calibration_file()),
    }
    line = (
        f"{actuator.name}: threshold {threshold:.1f} dB of its nominal drive, gain "
        f"{gain:+.1f} dB, saved in {calibration.calibration_file()}"
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
    """Play tones; return the levels at which Enter was pressed, dB of the nominal drive."""
    from overview_dsp.live.output.threshold import SILENCE_S, RisingTone, find_threshold

    settings, name, rate, index = _output(device, channel)
    out, channels = settings.tactor, settings.channels
    channel_text = " and ".join(map(str, out.channels))
    hertz = actuator.resonance_hz if frequency is None else frequency
    announce_compile("drive_block")
    RisingTone(hertz, db_per_s, 0.0).drive(actuator, out, channels, rate)  # checks the options
    lines = LineReader()
    levels: list[float] = []
    early = 0
    click.echo(
        f"{actuator.title} on {name}, channel {channel_text}, {hertz:g} Hz. Hold it as in use; "
        "press Enter as soon as you feel it.",
        err=True,
    )
    while len(levels) < repeats:
        rise = RisingTone(hertz, db_per_s, random.uniform(*SILENCE_S))
        samples = rise.drive(actuator, out, channels, rate)
        click.echo(f"tone {len(levels) + 1} of {repeats} ...", err=True)
        lines.discard()
        player = sample_player(samples, rate, index)
        level = find_threshold(rise, player, lambda: lines.next() is not None)
        if math.isfinite(level):
            click.echo(f"felt at {level:.1f} dB", err=True)
            levels.append(level)
        elif level > 0.0:
            raise InputError(
                f"{actuator.name}: no answer up to the highest level; check that it is on channel "
                f"{channel_text} of {name} and that its amplifier is on, or press sooner"
            )
        else:
            early += 1
            if early > MAX_EARLY:
                raise InputError(f"{early} answers before a tone; wait until you feel it")
            click.echo("too early: the tone had not begun", err=True)
    return levels


def _output(
    device: str | None, channel: str | None
) -> tuple[OutputSettings, str, float, int | None]:
    """Return the output of the tactor, and name, rate (Hz) and index of the device."""
    from overview_dsp.live.output.settings import OutputSettings, SignalSettings, parse_channels

    settings, name, rate, index = saved_output(device)
    tactor = settings.tactor
    if channel is not None:
        tactor = replace(tactor, channel=parse_channels(channel))
    if not tactor.channels:
        raise InputError(f"the tactor has no channel of {name}; select one with --channel")
    return OutputSettings(SignalSettings(0), tactor), name, rate, index
