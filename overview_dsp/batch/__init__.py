"""Render grids to sound files, on one machine or a cluster, with a manifest of measurements."""

from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.jobs_file import load_jobs
from overview_dsp.batch.running import BatchResult, run_batch

__all__ = ["BatchResult", "RenderGrid", "load_jobs", "run_batch"]
