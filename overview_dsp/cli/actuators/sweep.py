"""`overview actuators sweep`: a test signal within what an actuator bears."""

from __future__ import annotations

import click

from overview_dsp.cli.common import announce_compile, print_json

SAGS_DB = 0.1
"""What protection may take off a sweep before it says so."""


@click.command(epilog="Example: overview actuators sweep c2 -o sweep.wav --from 100 --to 500")
@click.argument("name")
@click.option("-o", "--out", default="sweep.wav", show_default=True, help="WAV, FLAC, ...")
@click.option("--from", "low", default=20.0, show_default=True, help="Hz.")
@click.option("--to", "high", default=1000.0, show_default=True, help="Hz.")
@click.option("--seconds", default=20.0, show_default=True, help="How long it takes.")
@click.option(
    "--level", default=-9.0, show_default=True, help="dB of the tactor's full signal, -80 to 0."
)
@click.option("--shaped", is_flag=True, help="Sharpened and weighted, as presets are driven.")
@click.option("--sample-rate", default=48_000.0, show_default=True, help="Hz.")
@click.option("--subtype", help="How samples are stored: PCM_16, PCM_24, FLOAT, ...")
@click.option("--json", "as_json", is_flag=True, help="Report as JSON.")
def sweep(
    name: str,
    out: str,
    low: float,
    high: float,
    seconds: float,
    level: float,
    shaped: bool,
    sample_rate: float,
    subtype: str | None,
    as_json: bool,
) -> None:
    """Write a sine that rises through the frequencies, to measure the actuator NAME with.

    It is an even drive within the actuator's rating: left is silent, right is the drive.
    """
    import numpy as np

    from overview_dsp.files.sound import save_sound
    from overview_dsp.signal.actuators.library import load_actuator
    from overview_dsp.signal.actuators.stage import ActuatorStage, protected_report
    from overview_dsp.signal.actuators.tones import log_sweep

    actuator = load_actuator(name)
    if not shaped:
        actuator = actuator.unshaped
    tone = log_sweep(low, high, seconds, level, sample_rate)
    stage = ActuatorStage(actuator, sample_rate)
    announce_compile("drive_block")
    samples = np.zeros((len(tone), 2), dtype=np.float32)
    samples[:, 1] = tone
    stage.process(samples, 1)
    save_sound(out, samples, sample_rate, subtype)
    done = stage.protected
    if done.taken_db > SAGS_DB:
        click.echo(
            f"note: up to {done.taken_db:.1f} dB were taken back for its rating: the sweep is not "
            "even; take a lower --level",
            err=True,
        )
    if as_json:
        print_json(
            {
                "file": out,
                "from_hz": low,
                "to_hz": high,
                "seconds": seconds,
                "drive_rms": round(float(np.sqrt(np.mean(np.square(samples[:, 1], dtype=float))))
                                   * actuator.full_scale, 6),
                "unit": actuator.values["drive.unit"],
                "actuator": protected_report(actuator, done),
            }
        )  # fmt: skip
        return
    click.echo(
        f"{out}: {low:g} to {high:g} Hz in {seconds:g} s, {level:g} dB of the full signal of "
        f"{actuator.title}, on the right"
    )
