"""Offline rendering of single gestures and batches, and its outputs."""

from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_jobs, render_many
from overview_dsp.offline.rendering.offline import (
    RenderFileResult,
    RenderResult,
    render,
    render_to_file,
)
from overview_dsp.offline.rendering.trace import Trace

__all__ = [
    "RenderFileResult",
    "RenderJob",
    "RenderResult",
    "RenderedJob",
    "Trace",
    "render",
    "render_jobs",
    "render_many",
    "render_to_file",
]
