"""JSON as phone apps send it: phyphox's answer to `/get`, Sensor Logger's batches.

phyphox's buffers have the names of the experiment: `accX` with gravity, `linX` without, `gyrX`. A
batch of Sensor Logger's has its samples out of order; `accelerometer` lacks gravity there,
`totalacceleration` has it.

Lines of JSON objects: `{"t_us": 1000, "ax": 0.0, "ay": 0.0, "az": 9.81}`.

Keys are the names of `COLUMNS`; `acc` and `gyr` with three numbers are short for the six axes.
Other keys are left alone, so that a device may say more.
"""

from __future__ import annotations

import json
import math
import re
from typing import Any

from overview_dsp.devices.sensors.labelled_lines import WITHOUT_GRAVITY
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    COLUMNS,
    QUATERNION,
    Reading,
)

LONGEST = 16_384
"""Bytes of a batch; a longer one is noise: let the app send more often."""

_PHYPHOX = re.compile(r"(acc|gyr)[a-z]*?_?([xyz])$", re.IGNORECASE)
_PHYPHOX_TIME = re.compile(r"(acc|gyr)[a-z]*?_?(t|time)$", re.IGNORECASE)
_WITHOUT = re.compile(r"(lin|user)[a-z]*?_?[xyz]$", re.IGNORECASE)
_NAMES = {"acc": ACCELERATION, "gyr": ANGULAR_VELOCITY}
_WHOLE = ("totalacceleration", "gravity")
_TURNING = ("gyroscope", "gyroscopeuncalibrated")


def readings_of(text: str) -> list[Reading] | str | None:
    """The readings of one object; why it has none that can be used; None if it is no such object.

    Readings are by time, each acceleration with the angular velocity before it.
    """
    said = _object(text)
    if isinstance(said.get("buffer"), dict):
        return _phyphox(said["buffer"])
    if isinstance(said.get("payload"), list):
        return _sensor_logger(said["payload"])
    return None


def _object(text: str) -> dict[str, Any]:
    """The object that a text is; empty if it is none."""
    try:
        said = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return said if isinstance(said, dict) else {}


def _phyphox(buffers: dict[str, Any]) -> list[Reading] | str:
    reading: dict[str, float] = {}
    for name, one in buffers.items():
        values = one.get("buffer") if isinstance(one, dict) else None
        if not isinstance(values, list) or not values or not _is_number(values[-1]):
            continue
        if found := _PHYPHOX.fullmatch(name):
            column = _NAMES[found[1].lower()]["xyz".index(found[2].lower())]
            reading[column] = float(values[-1])
        elif _PHYPHOX_TIME.fullmatch(name):
            reading.setdefault("t_s", float(values[-1]))
    if not all(name in reading for name in ACCELERATION):
        if any(_WITHOUT.fullmatch(name) for name in buffers):
            return WITHOUT_GRAVITY.replace("sketch print", "experiment give")
        return []
    if not all(name in reading for name in ANGULAR_VELOCITY):
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
    whole = next((name for name in _WHOLE if name in names), None)
    if whole is None and "orientation" in names:
        whole = "orientation"
    if whole is None:
        if names & {"accelerometer", "accelerometeruncalibrated"}:
            return WITHOUT_GRAVITY.split(":")[0] + ": turn on Total Acceleration in the app"
        return []
    readings: list[Reading] = []
    turning: dict[str, float] = {}
    gyroscope = bool(names & set(_TURNING)) and whole != "orientation"
    # at one time the gyroscope goes first
    for time_ns, name, values in sorted(entries, key=lambda one: (one[0], one[1] == whole)):
        if name in _TURNING:
            turning = _values(values, ANGULAR_VELOCITY, "xyz") or turning
        elif name == whole:
            keys = QUATERNION if whole == "orientation" else "xyz"
            columns = QUATERNION if whole == "orientation" else ACCELERATION
            said = _values(values, columns, keys)
            if said and (turning or not gyroscope):
                readings.append({"t_s": time_ns * 1e-9, **said, **turning})
    return readings


def _values(values: dict[str, Any], columns: tuple[str, ...], keys: Any) -> dict[str, float]:
    if not all(_is_number(values.get(key)) for key in keys):
        return {}
    return {name: float(values[key]) for name, key in zip(columns, keys, strict=True)}


def _is_number(value: object) -> bool:
    return not isinstance(value, bool) and _is_finite(value)


_THREES = {"acc": ACCELERATION, "gyr": ANGULAR_VELOCITY}


def reading_of(line: str) -> Reading | None:
    """The reading of a line; None if it is none."""
    said = _object(line)
    given: dict[str, Any] = {name: value for name, value in said.items() if name in COLUMNS}
    for short, names in _THREES.items():
        if short in said:
            if not isinstance(said[short], list) or len(said[short]) != len(names):
                return None
            given.update(zip(names, said[short], strict=True))
    if not given or not all(_is_finite(value) for value in given.values()):
        return None
    return {name: float(value) for name, value in given.items()}


def _is_finite(value: object) -> bool:
    # a bool is a number too: touch may be true or false
    return isinstance(value, int | float) and -1e300 < value < 1e300 and math.isfinite(value)
