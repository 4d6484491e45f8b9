"""JSON schemas of the haptic formats, written from their published descriptions."""

from __future__ import annotations

from typing import Any

UNIT = {"type": "number", "minimum": 0, "maximum": 1}
SECONDS = {"type": "number", "minimum": 0}


def of(properties: dict[str, Any], optional: tuple[str, ...] = ()) -> dict[str, Any]:
    """An object with these properties and no others, all required but the optional ones."""
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def many(items: dict[str, Any], least: int = 0) -> dict[str, Any]:
    return {"type": "array", "items": items, "minItems": least}


_PARAMETER = of(
    {
        "ParameterID": {
            "enum": [
                "HapticIntensity",
                "HapticSharpness",
                "AttackTime",
                "DecayTime",
                "ReleaseTime",
                "Sustained",
            ]
        },
        "ParameterValue": UNIT,
    }
)
_EVENT = {
    "oneOf": [
        of(
            {
                "EventType": {"const": "HapticContinuous"},
                "Time": SECONDS,
                "EventDuration": {"type": "number", "exclusiveMinimum": 0, "maximum": 30},
                "EventParameters": many(_PARAMETER),
            }
        ),
        of(
            {
                "EventType": {"const": "HapticTransient"},
                "Time": SECONDS,
                "EventParameters": many(_PARAMETER),
            }
        ),
    ]
}
_CURVE = of(
    {
        "ParameterID": {"enum": ["HapticIntensityControl", "HapticSharpnessControl"]},
        "Time": SECONDS,
        "ParameterCurveControlPoints": many(
            of({"Time": SECONDS, "ParameterValue": {"type": "number", "minimum": -1, "maximum": 1}})
        ),
    }
)
AHAP = of(
    {
        "Version": {"const": 1.0},
        "Metadata": of(
            {name: {"type": "string"} for name in ("Project", "Created", "Description")},
            ("Project", "Created", "Description"),
        ),
        "Pattern": many({"oneOf": [of({"Event": _EVENT}), of({"ParameterCurve": _CURVE})]}, 1),
    },
    ("Metadata",),
)

_TEXTS = ("editor", "source", "project", "author", "description")
HAPTIC = of(
    {
        "version": of(
            {"major": {"const": 1}, "minor": {"type": "integer"}, "patch": {"type": "integer"}}
        ),
        "metadata": of(
            {name: {"type": "string"} for name in _TEXTS} | {"tags": many({"type": "string"})},
            (*_TEXTS, "tags"),
        ),
        "signals": of(
            {
                "continuous": of(
                    {
                        "envelopes": of(
                            {
                                "amplitude": many(
                                    of(
                                        {
                                            "time": SECONDS,
                                            "amplitude": UNIT,
                                            "emphasis": of({"amplitude": UNIT, "frequency": UNIT}),
                                        },
                                        ("emphasis",),
                                    ),
                                    2,
                                ),
                                "frequency": many(of({"time": SECONDS, "frequency": UNIT})),
                            }
                        )
                    }
                )
            }
        ),
    }
)

_INT = {"type": "integer"}
_MODALITIES = [
    "Other",
    "Pressure",
    "Acceleration",
    "Velocity",
    "Position",
    "Temperature",
    "Vibrotactile",
    "Water",
    "Wind",
    "Force",
    "Vibrotactile Texture",
    "Stiffness",
    "Friction",
    "Electrotactile",
]
_KEYFRAME = of(
    {
        "relative_position": {"type": "integer", "minimum": 0},
        "amplitude_modulation": {"type": "number", "minimum": -1, "maximum": 1},
        "frequency_modulation": _INT,
    },
    ("frequency_modulation",),
)
_EFFECT = of(
    {
        "effect_type": {"const": "Basis"},
        "position": {"type": "integer", "minimum": 0},
        "phase": {"type": "number"},
        "base_signal": {"enum": ["Sine", "Square", "Triangle", "SawToothUp", "SawToothDown"]},
        "keyframes": many(_KEYFRAME, 3),
    }
)
_BAND = of(
    {
        "band_type": {"enum": ["Transient", "Curve", "VectorialWave", "WaveletWave"]},
        "curve_type": {"enum": ["Linear", "Cubic", "Akima", "Bezier", "Bspline", "Unknown"]},
        "lower_frequency_limit": _INT,
        "upper_frequency_limit": _INT,
        "effects": many(_EFFECT, 1),
    },
    ("curve_type",),
)
_CHANNEL = of(
    {
        "id": _INT,
        "description": {"type": "string"},
        "gain": {"type": "number"},
        "mixing_coefficient": {"type": "number"},
        "body_part_mask": {"type": "integer", "minimum": 0},
        "reference_device_id": _INT,
        "bands": many(_BAND, 1) | {"maxItems": 7},
    },
    ("reference_device_id",),
)
_DEVICE = of(
    {
        "id": _INT,
        "name": {"type": "string"},
        "type": {"enum": ["Unknown", "LRA", "VCA", "ERM", "Piezo"]},
        "minimum_frequency": {"type": "number"},
        "resonance_frequency": {"type": "number"},
        "maximum_frequency": {"type": "number"},
    }
)
_PERCEPTION = of(
    {
        "id": _INT,
        "avatar_id": _INT,
        "description": {"type": "string"},
        "perception_modality": {"enum": _MODALITIES},
        "reference_devices": many(_DEVICE),
        "channels": many(_CHANNEL, 1) | {"maxItems": 127},
        "effect_library": many({}),
    },
    ("reference_devices",),
)
HJIF = of(
    {
        "version": {"type": "string", "pattern": "^([0-9]{4})(-([0-9]))?$"},
        "profile": {"enum": ["Main", "Simple Parametric"]},
        "level": {"enum": [1, 2]},
        "date": {"type": "string", "pattern": r"^\d{4}-\d{2}-\d{2}$"},
        "description": {"type": "string"},
        "timescale": {"const": 1000},
        "perceptions": many(_PERCEPTION, 1),
        "avatars": many({}),
        "syncs": many({}),
    }
)

ANDROID = of(
    {
        "description": {"type": "string"},
        "waveform": of(
            {
                "timings": many({"type": "integer", "minimum": 1}, 1),
                "amplitudes": many({"type": "integer", "minimum": 1, "maximum": 255}, 1),
                "repeat": {"const": -1},
            }
        ),
        "envelopeEffects": many(
            of(
                {
                    "startMs": {"type": "integer", "minimum": 0},
                    "initialFrequencyHz": {"type": "number", "exclusiveMinimum": 0},
                    "controlPoints": many(
                        of(
                            {
                                "amplitude": UNIT,
                                "frequencyHz": {"type": "number", "exclusiveMinimum": 0},
                                "durationMs": {"type": "integer", "minimum": 20, "maximum": 1000},
                            }
                        ),
                        1,
                    )
                    | {"maxItems": 16},
                }
            )
        ),
    }
)
