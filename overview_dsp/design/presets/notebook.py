"""HTML of a preset for notebooks: description, heights and widths of its kinds."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from overview_dsp.design.presets.model import EventKind, Preset

_BAR = 120


def preset_page(preset: Preset) -> str:
    """Return HTML with title, description and one row per kind; all texts are escaped."""
    tallest = max(kind.height for kind in preset.kinds.values())
    rows = "".join(_row(name, kind, tallest) for name, kind in preset.kinds.items())
    return (
        f"<div><b>{html.escape(preset.title)}</b> ({html.escape(preset.name)}): "
        f"{html.escape(preset.description)}"
        "<table><thead><tr><th>kind</th><th>height</th><th>width</th><th>click</th></tr></thead>"
        f"<tbody>{rows}</tbody></table></div>"
    )


def _row(name: str, kind: EventKind, tallest: float) -> str:
    # loudness and friction are felt by ratios: the bar is logarithmic
    part = math.log1p(max(kind.height, 0.0)) / math.log1p(tallest) if tallest > 0.0 else 0.0
    width = f"{kind.width_ms:g} ms" if kind.width_ms is not None else f"{kind.width_percent:g} %"
    click = ", ".join(f"{mode.frequency_hz:g} Hz" for mode in kind.modes[:3])
    aliases = f" <small>({html.escape(', '.join(kind.aliases))})</small>" if kind.aliases else ""
    return (
        f"<tr><td>{html.escape(name)}{aliases}</td>"
        f'<td><svg width="{_BAR}" height="10" role="img" aria-label="{kind.height:g}">'
        f'<rect width="{part * _BAR:.0f}" height="10" fill="#0072B2"/></svg> {kind.height:g}</td>'
        f"<td>{width}</td><td>{click or html.escape(kind.material)}</td></tr>"
    )
