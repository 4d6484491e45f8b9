"""Inertial recordings with true orientation (BROAD), where OVERVIEW_TEST_DATA has them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import scipy.io

TRIALS = ("04_undisturbed_slow_rotation_with_breaks_A", "25_disturbed_tapping_B")
_DATA = os.environ.get("OVERVIEW_TEST_DATA")
needs_data = pytest.mark.skipif(
    not _DATA or not (Path(_DATA) / "imu").is_dir(),
    reason="needs other people's data: set OVERVIEW_TEST_DATA to a folder with imu/",
)


@dataclass(frozen=True)
class Trial:
    """One recording: m/s², rad/s; the true roll and pitch in degrees, NaN where unseen."""

    rate: float
    acceleration: np.ndarray
    turning: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    moving: np.ndarray

    @property
    def scored(self) -> np.ndarray:
        """Samples whose roll can be judged: moving, seen, and not too steep."""
        return self.moving & (np.abs(self.pitch) < 60.0)

    def rmse(self, roll: np.ndarray) -> float:
        """Root mean square error of a roll, degrees."""
        error = (roll - self.roll + 180.0) % 360.0 - 180.0
        return float(np.sqrt(np.mean(error[self.scored] ** 2)))


def load_trial(name: str) -> Trial:
    """A whole recording."""
    data = scipy.io.loadmat(Path(_DATA or "") / "imu" / f"{name}.mat")
    w, x, y, z = data["opt_quat"].T
    up = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return Trial(
        float(data["sampling_rate"].squeeze()),
        data["imu_acc"],
        data["imu_gyr"],
        np.degrees(np.arctan2(up[1], up[2])),
        np.degrees(np.arcsin(np.clip(up[0], -1.0, 1.0))),
        data["movement"].squeeze().astype(bool),
    )
