"""The first file of a folder: the page with its timeline's own title, a picture for those who share
its address, and the data it begins with asked for along with its scripts.
"""

from __future__ import annotations

import html
import io

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.signal.surface.angle_map import AngleMap

PICTURE = "preview.png"
WIDTH, HEIGHT = 1200, 630
"""Pixels, as pages that show a link expect them."""

_DPI = 100
_FIRST = ("data/timeline.json", "data/window-0.json")
_TITLE = "<title>overView</title>"
_HEADING = '<h1 id="title">overView</h1>'


def front_page(page: str, timeline: Timeline, address: str | None = None) -> str:
    """The page's `index.html` for one timeline; `address`: where its folder will be, if known."""
    title = html.escape(timeline.title)
    head = [f"<title>{title}: overView</title>"]
    head += sharing(timeline.title, PICTURE, address, f"{timeline.title}, drawn over time")
    head += [f'<link rel="preload" as="fetch" crossorigin href="{name}">' for name in _FIRST]
    return page.replace(_TITLE, "\n  ".join(head)).replace(_HEADING, f'<h1 id="title">{title}</h1>')


def sharing(title: str, picture: str, address: str | None, alt: str | None = None) -> list[str]:
    """Tags for who shows a link: many of them need a picture's whole address."""
    told = {
        "title": title,
        "type": "website",
        "description": "A timeline to feel: friction under your finger.",
        "image": f"{address or ''}{picture}",
        "image:width": str(WIDTH),
        "image:height": str(HEIGHT),
    }
    told |= {"image:alt": alt} if alt else {}
    told |= {"url": address} if address else {}
    return [
        *(
            f'<meta property="og:{name}" content="{html.escape(content)}">'
            for name, content in told.items()
        ),
        '<meta name="twitter:card" content="summary_large_image">',
    ]


def front_picture(timeline: Timeline, preset: Preset) -> bytes:
    """The timeline as a picture, PNG, on the axis of its surface."""
    from overview_dsp.offline.plots.style import new_figure
    from overview_dsp.offline.plots.timeline import draw_timeline

    figure = new_figure(WIDTH / _DPI, HEIGHT / _DPI)
    axes = figure.subplots()
    draw_timeline(axes, timeline, AngleMap.of(timeline, preset))
    axes.set_title(timeline.title, fontsize=16)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})
    return file.getvalue()
