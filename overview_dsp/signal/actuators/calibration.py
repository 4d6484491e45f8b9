"""Where a person begins to feel an actuator, kept in the user's config folder and used from then.

The threshold is the level of a tone, dB of the nominal drive, at which it is just felt. Presets are
made for one at `REFERENCE_DB`: whoever needs more gets so much more, who needs less, less.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import platformdirs

from overview_dsp import validation
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, make_folder
from overview_dsp.signal.actuators.library import load_actuator, reference
from overview_dsp.signal.actuators.model import MAX_CALIBRATION_DB, Actuator

REFERENCE_DB = -40.0
"""The threshold that needs no gain (our own choice: 40 dB from just felt to the nominal drive)."""

LOWEST_DB, HIGHEST_DB = REFERENCE_DB - MAX_CALIBRATION_DB, REFERENCE_DB + MAX_CALIBRATION_DB
"""Thresholds that a gain can make up for."""


def calibration_file() -> Path:
    """Where thresholds are kept: `actuators.json` in the user's config folder."""
    return Path(platformdirs.user_config_dir("overview-dsp")) / "actuators.json"


def gain_for(threshold_db: float) -> float:
    """The gain, dB, for a threshold; InputError for one that is out of reach."""
    threshold_db = validation.real(threshold_db, "threshold_db")
    # written so that NaN fails
    if not LOWEST_DB <= threshold_db <= HIGHEST_DB:
        raise InputError(
            f"threshold {threshold_db:g} dB is out of range; it is {LOWEST_DB:g} to "
            f"{HIGHEST_DB:g} dB of the nominal drive"
        )
    return threshold_db - REFERENCE_DB


def save_threshold(actuator: Actuator, threshold_db: float) -> None:
    """Remember where a person begins to feel an actuator, in the user's configuration.

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
    >>> ov.actuators.calibrated("c2").gain_db
    6.0
    >>> ov.actuators.forget_threshold(c2)
    True
    """
    entry = {"threshold_db": threshold_db, "gain_db": gain_for(threshold_db)}
    _write({**_read(), reference(actuator): entry})


def forget_threshold(actuator: Actuator) -> bool:
    """Forget where a person begins to feel an actuator.

    Parameters
    ----------
    actuator : Actuator
        Which one.

    Returns
    -------
    bool
        Whether anything was known.

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
    kept = _read()
    if kept.pop(reference(actuator), None) is None:
        return False
    _write(kept)
    return True


def gain_of(actuator: Actuator) -> float:
    """The gain an actuator was calibrated to, dB; 0 if it wasn't. InputError: a damaged file."""
    name = reference(actuator)
    kept = _read().get(name)
    if kept is None:
        return 0.0
    gain = kept.get("gain_db") if isinstance(kept, dict) else None
    if (
        isinstance(gain, bool)
        or not isinstance(gain, int | float)
        or not -MAX_CALIBRATION_DB <= gain <= MAX_CALIBRATION_DB
    ):
        raise InputError(
            f"{calibration_file()}: the gain of {name!r} is damaged; correct or delete the file"
        )
    return float(gain)


def calibrated_actuator(name: str | Path) -> Actuator:
    """Load an actuator with the gain that it was calibrated to.

    Parameters
    ----------
    name : str or path
        As `load` takes it.

    Returns
    -------
    Actuator
        With a `gain_db` of 0 where no threshold is known.

    Raises
    ------
    InputError
        As `load`; a damaged file of thresholds.

    Examples
    --------
    >>> c2 = ov.actuators.load("c2")
    >>> ov.actuators.save_threshold(c2, -46.0)
    >>> ov.actuators.calibrated("c2").gain_db
    -6.0
    >>> ov.actuators.forget_threshold(c2)
    True
    """
    actuator = load_actuator(name)
    return replace(actuator, gain_db=gain_of(actuator))


def _write(kept: dict[str, Any]) -> None:
    path = calibration_file()
    make_folder(path.parent)
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(kept, indent=1, ensure_ascii=False), encoding="utf-8")


def _read() -> dict[str, Any]:
    path = calibration_file()
    try:
        kept = json.loads(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: can't be read ({error}); correct or delete it") from None
    if not isinstance(kept, dict):
        raise InputError(f"{path}: not a table of actuators; correct or delete it")
    return kept
