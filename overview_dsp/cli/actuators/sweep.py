"""`overview actuators sweep`: a test signal within what an actuator bears."""

from __future__ import annotations

import overview_dsp as ov
from overview_dsp.cli.common import announce_compile, note, show
from overview_dsp.cli.options.declaring import JSON, cli_command, option

SAGS_DB = 0.1
"""What protection may take off a sweep before it says so."""


@cli_command("actuators sweep c2 -o sweep.wav --low-frequency 100 --high-frequency 500")
def sweep(
    name: str,
    *,
    output: str = option("WAV, FLAC, ...", default="sweep.wav"),
    low_frequency: float = option("Lowest frequency, Hz.", default=20.0),
    high_frequency: float = option("Highest frequency, Hz.", default=1000.0),
    duration: float = option("Duration, s.", default=20.0),
    level: float = option("dB of the tactor's full signal, -80 to 0.", default=-9.0),
    apply_shaping: bool = option("Sharpen and weight it, as presets are driven."),
    sample_rate: float = option("Hz.", default=48_000.0),
    subtype: str | None = option("Sample format: PCM_16, PCM_24, FLOAT, ..."),
    as_json: bool = JSON,
) -> None:
    """Write a sine that rises through the frequencies, to measure the actuator NAME with.

    It is an even drive within the actuator's rating: left is silent, right is the drive.
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
    if done.reduction_db > SAGS_DB:
        note(
            f"its rating reduced the drive by up to {done.reduction_db:.1f} dB, unevenly; "
            "take a lower --level"
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
        f"the full signal of {actuator.title}, on the right"
    )
    show(as_json, report, line)
