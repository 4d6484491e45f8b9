"""The commands `overview actuators sweep` and `overview actuators measure`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, note, protect_inputs, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option
from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from overview_dsp.arrays import FloatArray

LOW_FREQUENCY = option(default=20.0)
HIGH_FREQUENCY = option(default=1000.0)
DURATION = option(default=20.0)
LONGEST_S = 900.0  # longest recording
UNEVEN_DB = 0.1  # gain reduction by the protection that causes a note, dB


@cli_command("actuators sweep c2 -o sweep.wav --low-frequency 100 --high-frequency 500")
def sweep(
    name: str,
    *,
    output: str = option(default="sweep.wav"),
    low_frequency: float = LOW_FREQUENCY,
    high_frequency: float = HIGH_FREQUENCY,
    duration: float = DURATION,
    level: float = option(default=-9.0),
    apply_shaping: bool = option(),
    sample_rate: float = option(default=48_000.0),
    subtype: str | None = option(),
    as_json: bool = JSON,
) -> None:
    """Write a sine sweep within the rating of the actuator NAME, for `actuators measure`.

    The left channel is silent. The right one drives the actuator evenly at all frequencies.
    """
    import numpy as np

    from overview_dsp.files.sound import save_sound
    from overview_dsp.signal.actuators.stage import ActuatorStage, protection_json

    actuator = ov.load_actuator(name)
    if not apply_shaping:
        actuator = actuator.unshaped
    tone = ov.actuators.log_sweep(low_frequency, high_frequency, duration, level, sample_rate)
    stage = ActuatorStage(actuator, sample_rate)
    announce_compile("drive_block")
    samples = np.zeros((len(tone), 2), dtype=np.float32)
    samples[:, 1] = tone
    stage.process(samples, 1)
    save_sound(output, samples, sample_rate, subtype)
    done = stage.protected
    if done.reduction_db > UNEVEN_DB:
        note(
            f"the rating reduces the sweep by up to {done.reduction_db:.1f} dB, so it is not even; "
            "use a lower --level"
        )
    rms = float(np.sqrt(np.mean(np.square(samples[:, 1], dtype=float)))) * actuator.full_scale
    report = {
        "file": output,
        "from_hz": low_frequency,
        "to_hz": high_frequency,
        "seconds": duration,
        "drive_rms": round(rms, 6),
        "unit": actuator.values["drive.unit"],
        "actuator": protection_json(actuator, done),
    }
    line = (
        f"{output}: {low_frequency:g} to {high_frequency:g} Hz in {duration:g} s, {level:g} dB of "
        f"the full signal of {actuator.title}, in the right channel"
    )
    show(as_json, report, line)


@cli_command("actuators measure c2 recording.wav -o my-c2.toml")
def measure(
    name: str,
    recording: str,
    *,
    output: str | None = option(),
    quantity: str = option(
        type=click.Choice(("acceleration", "velocity", "displacement")), default="acceleration"
    ),
    input_channel: int = option(type=click.IntRange(1), default=1),
    low_frequency: float = LOW_FREQUENCY,
    high_frequency: float = HIGH_FREQUENCY,
    duration: float = DURATION,
    as_json: bool = JSON,
) -> None:
    """Measure the resonance of the actuator NAME from a RECORDING of its sweep.

    Play the file of `actuators sweep` to the actuator and record it whole with a microphone or an
    accelerometer. The new profile has the measured resonance and the other values of NAME.
    """
    from overview_dsp.files.atomic import write_file
    from overview_dsp.signal.actuators.library import measured_profile, parse_actuator
    from overview_dsp.signal.actuators.resonance import fit_resonance
    from overview_dsp.validation import prefix_errors

    protect_inputs(name, recording)
    actuator = ov.load_actuator(name)
    samples, sample_rate = _read_channel(recording, input_channel)
    with prefix_errors(f"{recording}: "):
        fit = fit_resonance(samples, sample_rate, low_frequency, high_frequency, duration, quantity)
    path = output or f"{actuator.name}-measured.toml"
    text = measured_profile(actuator, fit, Path(recording).name)
    measured = parse_actuator(text, Path(path).stem, path)
    write_file(path, text)
    report = {
        "file": path,
        "frequency_hz": round(fit.frequency_hz, 2),
        "q": round(fit.q, 2),
        "tolerance_percent": fit.tolerance_percent,
        "residual_db": round(fit.residual_db, 2),
        "overdrive": measured.values["shaping.overdrive"],
        "response_hz": [round(one, 2) for one in fit.response_hz.tolist()],
        "response_db": [round(one, 2) for one in fit.response_db.tolist()],
        "model_db": [round(one, 2) for one in fit.model_db.tolist()],
    }
    line = (
        f"{path}: resonance {fit.frequency_hz:.1f} Hz within {fit.tolerance_percent:g} %, Q "
        f"{fit.q:.3g}, rise {measured.rise_ms:.3g} ms; response within {fit.residual_db:.1f} dB RMS"
    )
    show(as_json, report, line)


def _read_channel(recording: str, channel: int) -> tuple[FloatArray, float]:
    """Return the samples and the rate (Hz) of one channel of a sound file."""
    import soundfile

    try:
        if (lasts_s := soundfile.info(recording).duration) > LONGEST_S:
            raise InputError(f"{recording} lasts {lasts_s:.0f} s; cut it to the sweep")
        samples, sample_rate = soundfile.read(recording, always_2d=True)
    except (soundfile.LibsndfileError, OSError) as error:
        raise InputError(f"{recording}: can't be read as sound ({error})") from None
    if channel > samples.shape[1]:
        raise InputError(
            f"{recording} has {samples.shape[1]} channels; --input-channel is {channel}"
        )
    return samples[:, channel - 1], float(sample_rate)
