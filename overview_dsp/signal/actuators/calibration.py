"""Calibration: detection thresholds of actuators, stored in the user's config folder.

The threshold is the level of a tone, dB of the nominal drive, at which it is just felt. Presets
assume `REFERENCE_DB`. The gain of a user is the difference between the threshold and this level.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import platformdirs

from overview_dsp import validation
from overview_dsp.errors import InputError
from overview_dsp.files.json_table import read_table, write_table
from overview_dsp.signal.actuators.library import load_actuator, reference
from overview_dsp.signal.actuators.model import MAX_CALIBRATION_DB, Actuator

REFERENCE_DB = -40.0
"""The threshold that needs no gain (our own choice: 40 dB from just felt to the nominal drive)."""

LOWEST_DB, HIGHEST_DB = REFERENCE_DB - MAX_CALIBRATION_DB, REFERENCE_DB + MAX_CALIBRATION_DB
"""Range of thresholds that a gain can compensate."""


def calibration_file() -> Path:
    """Return the path of `actuators.json` in the user's config folder."""
    return Path(platformdirs.user_config_dir("overview-dsp")) / "actuators.json"


def gain_for(threshold_db: float) -> float:
    """Return the gain, dB, for a threshold; raise InputError if it is out of range."""
    limits, end = (LOWEST_DB, HIGHEST_DB), " dB of the nominal drive"
    return validation.within(threshold_db, "threshold_db", *limits, " dB", end) - REFERENCE_DB


def save_threshold(actuator: Actuator, threshold_db: float) -> None:
    """Store the user's detection threshold of an actuator in the configuration.

    Parameters
    ----------
    actuator : Actuator
        Which one.
    threshold_db : float
        Level of a tone that is just felt, dB of the nominal drive, -70 to -10.

    Raises
    ------
    InputError
        A threshold out of range, a damaged file of thresholds.
    OutputError
        A full disk.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> ov.actuators.save_threshold(c2, -34.0)
    >>> ov.actuators.apply_calibration("c2").gain_db
    6.0
    >>> ov.actuators.forget_threshold(c2)
    True
    """
    entry = {"threshold_db": threshold_db, "gain_db": gain_for(threshold_db)}
    write_table(calibration_file(), {**_read(), reference(actuator): entry})


def forget_threshold(actuator: Actuator) -> bool:
    """Delete the stored detection threshold of an actuator.

    Parameters
    ----------
    actuator : Actuator
        Which one.

    Returns
    -------
    bool
        Whether a threshold was stored.

    Raises
    ------
    InputError
        A damaged file of thresholds.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> ov.actuators.save_threshold(c2, -34.0)
    >>> ov.actuators.forget_threshold(c2), ov.actuators.forget_threshold(c2)
    (True, False)
    """
    thresholds = _read()
    if thresholds.pop(reference(actuator), None) is None:
        return False
    write_table(calibration_file(), thresholds)
    return True


def gain_of(actuator: Actuator) -> float:
    """Return the calibrated gain of an actuator, dB; 0 without; InputError for a damaged file."""
    name = reference(actuator)
    entry = _read().get(name)
    if entry is None:
        return 0.0
    gain: Any = entry.get("gain_db") if isinstance(entry, dict) else None
    is_number = isinstance(gain, int | float) and not isinstance(gain, bool)
    if not is_number or not abs(gain) <= MAX_CALIBRATION_DB:
        raise InputError(
            f"{calibration_file()}: gain_db of {name!r} is {gain!r}; must be a number from "
            f"-{MAX_CALIBRATION_DB:g} to {MAX_CALIBRATION_DB:g}; correct or delete the file"
        )
    return float(gain)


def apply_calibration(name: str | Path) -> Actuator:
    """Load an actuator with its calibrated gain.

    Parameters
    ----------
    name : str or path
        As `load` takes it.

    Returns
    -------
    Actuator
        Its `gain_db` is 0 if no threshold is stored.

    Raises
    ------
    InputError
        As `load`; a damaged file of thresholds.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> ov.actuators.save_threshold(c2, -46.0)
    >>> ov.actuators.apply_calibration("c2").gain_db
    -6.0
    >>> ov.actuators.forget_threshold(c2)
    True
    """
    actuator = load_actuator(name)
    return replace(actuator, gain_db=gain_of(actuator))


def _read() -> dict[str, Any]:
    return read_table(calibration_file(), "not a table of actuators")
