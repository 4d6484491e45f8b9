"""The command `overview actuators sweep`."""

from __future__ import annotations

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, note, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option

UNEVEN_DB = 0.1  # gain reduction by the protection that causes a note, dB


@cli_command("actuators sweep c2 -o sweep.wav --low-frequency 100 --high-frequency 500")
def sweep(
    name: str,
    *,
    output: str = option("Sound file; the suffix selects the format.", default="sweep.wav"),
    low_frequency: float = option("Lowest frequency, Hz.", default=20.0),
    high_frequency: float = option("Highest frequency, Hz.", default=1000.0),
    duration: float = option("Duration, s.", default=20.0),
    level: float = option("Level, dB of the full tactor signal, -80 to 0.", default=-9.0),
    apply_shaping: bool = option("Apply the shaping of the actuator, as for presets."),
    sample_rate: float = option("Sample rate, Hz.", default=48_000.0),
    subtype: str | None = option("Sample format: PCM_16, PCM_24, FLOAT, ..."),
    as_json: bool = JSON,
) -> None:
    """Write a sine sweep within the rating of the actuator NAME, to measure the actuator.

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
