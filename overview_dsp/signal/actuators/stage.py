"""Actuator drive as an offline stage, with the compiled code of live output."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.errors import InputError, warn
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.actuator import drive_block
from overview_dsp.kernels.device.derive_actuator import SKIN_HZ, derive_actuator
from overview_dsp.public import counted
from overview_dsp.signal.actuators.model import Actuator, pacinian_db
from overview_dsp.units import gain_to_db

FAINT_DB = -12.0  # level of a carrier, relative to the resonance, below which a warning is shown
HIGHEST_PART = 0.45  # highest resonance frequency relative to the sample rate


def warn_of_carrier(actuator: Actuator, frequency_hz: float) -> None:
    """Warn if the actuator's vibration at a frequency is hardly felt."""
    validation.instance(actuator, Actuator, "actuator", "ov.load_actuator gives one")
    resonance_hz = actuator.resonance_hz
    felt = actuator.response_db(frequency_hz)
    felt += pacinian_db(frequency_hz) - pacinian_db(resonance_hz)
    if felt < FAINT_DB:
        warn(
            f"{actuator.name} is felt {-felt:.0f} dB less at tactor.frequency_hz = "
            f"{frequency_hz:g} than at its resonance; set that to {resonance_hz:g} Hz"
        )


def write_actuator(
    memory: FloatArray, at: int, actuator: Actuator | None, sample_rate: float
) -> None:
    """Write an actuator's coefficients to memory at `at` and reset its state.

    None disables the actuator. The heat is kept, so that reopening an output does not cool the
    model. InputError for a sample rate (Hz) too low for the resonance. Thread: main, before audio
    runs.
    """
    if actuator is not None:
        _check_rate(actuator, actuator.resonance_hz, sample_rate)
        if actuator.values["shaping.perceptual_weighting"]:
            _check_rate(actuator, SKIN_HZ, sample_rate)
    heat = float(memory[at + layout.ACT_HEAT])
    memory[at : at + layout.ACT_SIZE] = 0.0
    if actuator is not None:
        for column, value in _coefficient_inputs(actuator).items():
            memory[at + column] = value
        derive_actuator(memory, at, float(sample_rate))
    memory[at + layout.ACT_HEAT] = min(heat, float(memory[at + layout.ACT_LIMIT]))
    memory.view(np.int64)[at + layout.ACT_ON] = actuator is not None


def _coefficient_inputs(actuator: Actuator) -> dict[int, float]:
    """Return the values from which coefficients are derived, by column."""
    return {
        layout.GIVEN_NOMINAL: actuator.nominal,
        layout.GIVEN_GAIN_DB: actuator.gain_db,
        layout.GIVEN_PEAK: actuator.peak,
        layout.GIVEN_MEAN_SQUARE: actuator.mean_square,
        layout.GIVEN_WINDOW_S: actuator.window_s,
        layout.GIVEN_DUTY: actuator.number("drive.duty"),
        layout.GIVEN_RESONANCE_HZ: actuator.resonance_hz,
        layout.GIVEN_Q: actuator.q,
        layout.GIVEN_OVERDRIVE_Q: actuator.overdrive_q,
        layout.GIVEN_PERCEPTUAL_WEIGHTING: float(
            bool(actuator.values["shaping.perceptual_weighting"])
        ),
    }


def _check_rate(actuator: Actuator, frequency_hz: float, sample_rate: float) -> None:
    # written so that NaN fails
    if not frequency_hz / HIGHEST_PART < sample_rate < math.inf:
        raise InputError(
            f"actuator {actuator.name} needs a sample rate above "
            f"{frequency_hz / HIGHEST_PART:.0f} Hz, not {sample_rate:g}"
        )


@dataclass(frozen=True)
class ProtectionReport:
    """Interventions of an actuator's protection.

    Attributes
    ----------
    reduction_db : float
        Largest reduction of the drive by the thermal limit, dB.
    at_peak : int
        Samples limited to the peak.

    Examples
    --------
    >>> ov.actuators.ProtectionReport(reduction_db=0.0, at_peak=3).at_peak
    3
    """

    reduction_db: float
    at_peak: int


def protection_json(actuator: Actuator | None, protected: ProtectionReport | None) -> Any:
    """Return an actuator and its protection report for JSON; None without an actuator."""
    if actuator is None or protected is None:
        return None
    return {
        "name": actuator.name,
        "calibration_db": actuator.gain_db,
        "reduction_db": round(protected.reduction_db, 1),
        "samples_at_peak": protected.at_peak,
    }


def read_protection(memory: FloatArray, at: int) -> ProtectionReport:
    """Read an actuator's protection report from memory."""
    left = math.sqrt(max(1e-12, 1.0 - float(memory[at + layout.ACT_MOST_TAKEN])))
    held = int(memory.view(np.int64)[at + layout.ACT_AT_PEAK])
    return ProtectionReport(0.0 - gain_to_db(left), held)


class ActuatorStage:
    """Converts a channel to an actuator's drive, block by block.

    For engines in your own audio callback. The block size changes no bit. Thread: one.

    Parameters
    ----------
    actuator : Actuator
        Actuator to drive.
    sample_rate : float
        Hz.

    Raises
    ------
    InputError
        The sample rate is too low for the actuator.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> stage = ov.actuators.ActuatorStage(c2, 8000)
    >>> samples = np.ones((256, 2), dtype=np.float32)  # of engine.process
    >>> stage.process(samples, channel=1)
    >>> float(np.abs(samples[:, 1]).max()) <= c2.peak
    True
    """

    def __init__(self, actuator: Actuator, sample_rate: float) -> None:
        validation.instance(actuator, Actuator, "actuator", "ov.load_actuator gives one")
        sample_rate = validation.real(sample_rate, "sample_rate")
        self._name = actuator.name
        self._memory = np.zeros(layout.ACT_SIZE)
        write_actuator(self._memory, 0, actuator, sample_rate)

    def process(self, samples: SampleArray, channel: int) -> None:
        """Replace one channel by the drive.

        Parameters
        ----------
        samples : float32 (frames, channels)
            C-ordered and writable.
        channel : int
            From 0.

        Raises
        ------
        InputError
            An array of the wrong type, shape or order, or one without that channel.

        Examples
        --------
        >>> c2 = ov.actuators.load("c2")
        >>> stage = ov.actuators.ActuatorStage(c2, 8000)
        >>> stage.process(np.zeros((256, 2), dtype=np.float32), channel=1)
        >>> stage.silent_samples
        256
        """
        frames, channels = validation.block(samples, "samples")
        if not 0 <= channel < channels:
            raise InputError(f"channel {channel} is not one of {channels}, counted from 0")
        memory = self._memory
        w = memory.view(np.int64)
        drive_block(memory, w, 0, samples.reshape(-1), frames, channels, channel)

    @property
    def silent_samples(self) -> int:
        """Number of samples since the last non-zero drive."""
        return int(self._memory.view(np.int64)[layout.ACT_SILENT])

    @property
    def protected(self) -> ProtectionReport:
        """Interventions of the protection so far."""
        return read_protection(self._memory, 0)

    def __repr__(self) -> str:
        at_peak = counted(self.protected.at_peak, "sample")
        return f"<ActuatorStage: {self._name}, {at_peak} at the peak>"
