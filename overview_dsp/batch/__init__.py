"""Studies: a grid of renders to files, on one machine or a cluster, with a manifest of measures."""

from overview_dsp.batch.grid import Study
from overview_dsp.batch.jobs_file import load_study
from overview_dsp.batch.running import Outcome, run_study

__all__ = ["Outcome", "Study", "load_study", "run_study"]
