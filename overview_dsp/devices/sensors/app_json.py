"""JSON of phone apps (phyphox's answer to `/get`, Sensor Logger's batches), and lines of JSON.

phyphox's buffers have the names of the experiment: `accX` with gravity, `linX` without, `gyrX`.
Samples in a batch of Sensor Logger are out of order. Its `accelerometer` lacks gravity;
`totalacceleration` includes it.

A line of JSON is one object: `{"t_us": 1000, "ax": 0.0, "ay": 0.0, "az": 9.81}`. Its keys are names
of `COLUMNS`; `acc` and `gyr` with three numbers stand for the six axes. Other keys are ignored, so
that a device may send more.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from typing import Any

from overview_dsp.devices.sensors.labelled_lines import WITHOUT_GRAVITY
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    COLUMNS,
    QUATERNION,
    Reading,
    has,
)

LONGEST = 16_384
"""Maximum size of a batch, bytes; a longer one is noise, and the app should send more often."""

_AXES = {"acc": ACCELERATION, "gyr": ANGULAR_VELOCITY}
_PHYPHOX = re.compile(r"(acc|gyr)[a-z]*?_?([xyz])$", re.IGNORECASE)
_PHYPHOX_TIME = re.compile(r"(acc|gyr)[a-z]*?_?(t|time)$", re.IGNORECASE)
_PHYPHOX_LINEAR = re.compile(r"(lin|user)[a-z]*?_?[xyz]$", re.IGNORECASE)
_LOGGER_LINEAR = {"accelerometer", "accelerometeruncalibrated"}
_LOGGER_GYROSCOPE = {"gyroscope", "gyroscopeuncalibrated"}
_LOGGER_TILT = {
    "totalacceleration": (ACCELERATION, "xyz"),
    "gravity": (ACCELERATION, "xyz"),
    "orientation": (QUATERNION, QUATERNION),
}
"""Sensors that show tilt, the best first: their columns, and the keys of their values."""


def parse_app_batch(text: str) -> list[Reading] | str | None:
    """Return an app's readings; a reason if none is usable, None if it isn't an app's object.

    Readings are in order of time, each acceleration with the angular velocity before it.
    """
    parsed = _parse_object(text)
    if isinstance(parsed.get("buffer"), dict):
        return _phyphox(parsed["buffer"])
    if isinstance(parsed.get("payload"), list):
        return _sensor_logger(parsed["payload"])
    return None


def _parse_object(text: str) -> dict[str, Any]:
    """Return the JSON object in a text; empty if the text isn't one."""
    try:
        parsed = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return parsed if isinstance(parsed, dict) else {}


def _phyphox(buffers: dict[str, Any]) -> list[Reading] | str:
    reading: dict[str, float] = {}
    for name, one in buffers.items():
        values = one.get("buffer") if isinstance(one, dict) else None
        if not isinstance(values, list) or not values or not _is_number(values[-1]):
            continue
        if found := _PHYPHOX.fullmatch(name):
            column = _AXES[found[1].lower()]["xyz".index(found[2].lower())]
            reading[column] = float(values[-1])
        elif _PHYPHOX_TIME.fullmatch(name):
            reading.setdefault("t_s", float(values[-1]))
    if not has(reading, ACCELERATION):
        if any(_PHYPHOX_LINEAR.fullmatch(name) for name in buffers):
            return WITHOUT_GRAVITY.replace("sketch print", "experiment give")
        return []
    if not has(reading, ANGULAR_VELOCITY):
        reading = {name: value for name, value in reading.items() if name[0] != "g"}
    return [reading]


def _sensor_logger(payload: list[Any]) -> list[Reading] | str:
    entries: list[tuple[int, str, dict[str, Any]]] = []
    for one in payload:
        if not isinstance(one, dict) or not isinstance(one.get("values"), dict):
            continue
        name, time_ns = str(one.get("name", "")).lower(), one.get("time")
        if isinstance(time_ns, str) and time_ns.isdecimal() and len(time_ns) < 20:
            time_ns = int(time_ns)
        if _is_number(time_ns):
            entries.append((int(time_ns), name, one["values"]))  # type: ignore[arg-type]
    names = {name for _, name, _ in entries}
    tilt = next((name for name in _LOGGER_TILT if name in names), None)
    if tilt is None:
        if names & _LOGGER_LINEAR:
            return WITHOUT_GRAVITY.split(":")[0] + ": turn on Total Acceleration in the app"
        return []
    readings: list[Reading] = []
    angular_velocity: dict[str, float] = {}
    has_gyroscope = bool(names & _LOGGER_GYROSCOPE) and tilt != "orientation"
    # at equal times the gyroscope comes first
    for time_ns, name, values in sorted(entries, key=lambda one: (one[0], one[1] == tilt)):
        if name in _LOGGER_GYROSCOPE:
            angular_velocity = _values(values, ANGULAR_VELOCITY, "xyz") or angular_velocity
        elif name == tilt:
            found = _values(values, *_LOGGER_TILT[tilt])
            if found and (angular_velocity or not has_gyroscope):
                readings.append({"t_s": time_ns * 1e-9, **found, **angular_velocity})
    return readings


def _values(
    values: dict[str, Any], columns: Sequence[str], keys: Sequence[str]
) -> dict[str, float]:
    if not all(_is_number(values.get(key)) for key in keys):
        return {}
    return {name: float(values[key]) for name, key in zip(columns, keys, strict=True)}


def _is_number(value: object) -> bool:
    return not isinstance(value, bool) and _is_finite(value)


def parse_json_line(line: str) -> Reading | None:
    """Return the reading of a line; None if the line is invalid."""
    parsed = _parse_object(line)
    values: dict[str, Any] = {name: value for name, value in parsed.items() if name in COLUMNS}
    for short, names in _AXES.items():
        if short in parsed:
            if not isinstance(parsed[short], list) or len(parsed[short]) != len(names):
                return None
            values.update(zip(names, parsed[short], strict=True))
    if not values or not all(_is_finite(value) for value in values.values()):
        return None
    return {name: float(value) for name, value in values.items()}


def _is_finite(value: object) -> bool:
    # a bool is a number too: touch may be true or false
    return isinstance(value, int | float) and -1e300 < value < 1e300 and math.isfinite(value)
