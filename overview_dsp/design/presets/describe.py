"""Description of a preset: every parameter with value, range and meaning."""

from __future__ import annotations

import math
from typing import Any

from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.design.presets.parameter import is_default, value_text
from overview_dsp.design.presets.parameters import PARAMETERS, SECTIONS
from overview_dsp.design.presets.serialization import preset_to_dict


def character(preset: Preset) -> dict[str, float]:
    """Return the dynamics of the disk on the bare surface.

    The result has undamped frequencies while touched and released (Hz), damping ratios (1:
    critical), and the time constant of a slow recoil (s).
    """
    number = preset.number
    inertia, k1, k2 = number("disk.inertia"), number("disk.k1"), number("disk.k2")
    b = number("surface.friction")
    return {
        "held_hz": math.sqrt((k1 + k2) / inertia) / (2.0 * math.pi),
        "held_damping": b / (2.0 * math.sqrt((k1 + k2) * inertia)),
        "free_hz": math.sqrt(k1 / inertia) / (2.0 * math.pi),
        "free_damping": b / (2.0 * math.sqrt(k1 * inertia)),
        "recoil_s": b / k1,
    }


def _kind_line(name: str, kind: EventKind) -> str:
    width = f"{kind.width_percent:g} %" if kind.width_percent else f"{kind.width_ms:g} ms"
    modes = ", ".join(f"{mode.frequency_hz:g} Hz {mode.decay_ms:g} ms" for mode in kind.modes)
    aliases = f"; also {', '.join(kind.aliases)}" if kind.aliases else ""
    if not modes and kind.material != "none":
        modes = f"{kind.material} {kind.pitch_hz:g} Hz"
    shape = f"{len(kind.points)} points" if kind.points else kind.shape
    if kind.model != "viscous":
        shape = f"{shape}, {kind.model}"
    return (
        f"  {name:<12} {kind.height:>6g} x  {width:>8}  {shape:<13}  {modes or 'no click'}{aliases}"
    )


def bristle_hold(preset: Preset) -> dict[str, float]:
    """Return the effect of the surface's bristles on a slowly pulled disk, in % of the surface.

    The result has its largest distance from the input disk, and the distance of a slip. The pull
    rises to the static torque and swings equally far below the sliding torque. Empty without
    bristles.
    """
    if preset.values["surface.model"] != "bristle":
        return {}
    number = preset.number
    sliding = number("surface.torque_ratio") * number("surface.friction")
    static = sliding * number("surface.static_ratio")
    percent = 100.0 / (number("disk.k2") * math.pi)
    return {
        "held_within_percent": static * percent,
        "slip_percent": 2.0 * (static - sliding) * percent,
    }


def describe(preset: Preset) -> str:
    """Return the preset as text; a star marks a value other than the default."""
    lines = [f"{preset.name}: {preset.title}", preset.description, ""]
    for section, members in SECTIONS.items():
        lines.append(f"[{section}]")
        for key, known in members.items():
            value = preset.values[known.id]
            star = " " if is_default(known, value) else "*"
            shown = f"{value_text(value)} {known.unit}".strip()
            lines.append(f" {star}{key:<18} {shown:<20} ({known.allowed}) {known.doc}")
    facts, hold = character(preset), bristle_hold(preset)
    lines.append("")
    if preset.points:
        lines.append(f"The intensity map has {len(preset.points)} points.")
    if hold:
        lines.append(
            f"Its bristles hold the disk up to {hold['held_within_percent']:.2g} % of the surface "
            f"from the input disk; pulled slowly it slips {hold['slip_percent']:.2g} % at a time."
        )
    lines += [
        "On the bare surface: "
        f"touched {facts['held_hz']:.2f} Hz, damping {facts['held_damping']:.2f};"
        f" released {facts['free_hz']:.2f} Hz, damping {facts['free_damping']:.2f}, "
        f"recoil {facts['recoil_s']:.2f} s.",
        "",
        "[kinds]        height     width  shape          click",
        *(_kind_line(name, kind) for name, kind in preset.kinds.items()),
    ]
    return "\n".join(lines)


def describe_json(preset: Preset) -> dict[str, Any]:
    """Return the preset, its ranges and its dynamics as plain data."""
    return {
        "name": preset.name,
        "title": preset.title,
        "description": preset.description,
        "parameters": {
            id: {
                "value": preset.values[id],
                **{key: getattr(known, key) for key in ("unit", "allowed", "default", "doc")},
            }
            for id, known in PARAMETERS.items()
        },
        "character": character(preset) | bristle_hold(preset),
        **{key: preset_to_dict(preset)[key] for key in ("points", "kinds")},
    }
