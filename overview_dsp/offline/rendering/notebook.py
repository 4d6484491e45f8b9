"""Notebook display of a render: self-contained HTML with player, curves and transcript.

The curves are SVG, since a plotting library would be too slow for notebooks with many results.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence

import numpy as np

from overview_dsp.arrays import FloatArray, SampleArray

WIDTH, ROW = 720, 70
_POINTS = 700
_STYLE = 'fill="none" stroke="{}" stroke-width="1"'
Row = tuple[str, FloatArray, str]  # a curve: label, values of the frames, and colour


def result_page(
    title: str,
    samples: SampleArray,
    sample_rate: float,
    rows: Sequence[Row],
    lines: Sequence[str] = (),
    passed: int = 0,
) -> str:
    """Return HTML with title, player (16-bit FLAC), one row per curve, and a transcript.

    `rows` are curves with the same duration, `lines` those of the transcript, initially folded. Of
    `passed` events the transcript has the strongest.
    """
    seconds = len(samples) / sample_rate
    name = html.escape(f"{title}, {seconds:.2f} s", quote=True)
    player = ""
    if len(samples):
        sound = base64.b64encode(_flac(samples, round(sample_rate))).decode()
        player = (
            f'<audio controls aria-label="Sound of {name}" '
            f'src="data:audio/flac;base64,{sound}"></audio>'
        )
    drawn = "".join(_curve(row, i) for i, row in enumerate(rows) if len(row[1]))
    height = ROW * len(rows) + 16
    return (
        f"<div><b>{html.escape(title)}</b>, {seconds:.2f} s: left is heard, right is felt<br>"
        f'{player}<br><svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
        f'font-family="sans-serif" font-size="11" role="img" '
        f'aria-label="Curves of {name}">{drawn}'
        f'<text x="{WIDTH - 4}" y="{height - 4}" text-anchor="end">{seconds:.2f} s</text></svg>'
        f"{_transcript(lines, passed)}</div>"
    )


def _transcript(lines: Sequence[str], passed: int) -> str:
    if not lines:
        return "<p>Transcript: no event is passed.</p>"
    shown = ", the strongest of each way" if len(lines) < passed else ""
    count = f"{passed} events passed{shown}"
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return f"<details><summary>Transcript: {count}</summary><ul>{items}</ul></details>"


def _flac(samples: SampleArray, rate: int) -> bytes:
    import soundfile

    data = io.BytesIO()
    soundfile.write(data, samples, rate, format="FLAC", subtype="PCM_16")
    return data.getvalue()


def _curve(row: Row, index: int) -> str:
    label, values, colour = row
    top = ROW * index
    low, high = float(values.min()), float(values.max())
    span = high - low or 1.0
    edges = np.unique(np.linspace(0, len(values), _POINTS + 1).astype(int)[:-1])
    # minimum and maximum of each step, so that no peak is lost
    pair = np.column_stack(
        [np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)]
    ).ravel()
    x = np.repeat(edges / len(values) * WIDTH, 2)
    y = top + ROW - 8.0 - (pair - low) / span * (ROW - 24.0)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return (
        f'<text x="2" y="{top + 11}" fill="{colour}">{html.escape(label)}: {low:.3g} to '
        f'{high:.3g}</text><polyline points="{points}" {_STYLE.format(colour)}/>'
    )
