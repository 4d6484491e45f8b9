"""Small studies, and what they left."""

from __future__ import annotations

import hashlib
from pathlib import Path

from overview_dsp.batch import load_jobs

JOBS = """
out = "study"
timelines = [
    "world-cup-final-2018",
    {file = "world-cup-final-2018", window = ["goal:1-60", "goal:1+60"]},
]
presets = ["football", "heart"]
gestures = ["tap:0.4:0.05", "sweep:0.1:0:0.5+rest:0.05"]
seeds = 3
sample_rate = 8000
tail = "none"
[parameters]
"tactor.gain_db" = [-6, 0.0]
"""
CASES = 2 * 2 * 2 * 2 * 3


def jobs_file(folder: Path, text: str = JOBS) -> Path:
    path = folder / "jobs.toml"
    path.write_text(text)
    return path


def grid_in(folder: Path, text: str = JOBS, out: str | None = None):
    return load_jobs(jobs_file(folder, text), out)


def hashes(folder: Path) -> dict[str, str]:
    """Every file of a folder with its hash."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
