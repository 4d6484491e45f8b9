"""Other people's tools open what is written for them: by their own code, in their own Python.

They are GPL or large, so they are nobody's dependency:
``python -m venv tools && tools/bin/pip install psignifit psychopy bids-validator-deno``, then
``OVERVIEW_STUDY_TOOLS=tools``. What isn't in there is skipped.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import pytest

from studies.tests.files import varying, written
from tests.cli.running import overview

TOOLS = os.environ.get("OVERVIEW_STUDY_TOOLS", "")
PYTHON = Path(TOOLS, "bin", "python")


def run_by(module, program, *arguments):
    """What a program in the tools' Python prints as JSON."""
    if not TOOLS or subprocess.run([PYTHON, "-c", f"import {module}"], check=False).returncode:
        pytest.skip(f"needs {module} in the environment that OVERVIEW_STUDY_TOOLS names")
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run([PYTHON, "-c", program, *map(str, arguments)], capture_output=True,
                          text=True, check=False, env=environment)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def exported(*arguments):
    outcome = overview("study", "export", *arguments)
    assert outcome.code == 0, outcome.err


def test_psychopy_reads_a_list(tmp_path):
    exported("--to", "psychopy", "--study", written(tmp_path, varying("compare")),
             "-o", tmp_path / "p")  # fmt: skip
    rows = run_by(
        "psychopy.data",
        "import json, sys; from psychopy.data import importConditions\n"
        "rows = importConditions(sys.argv[1])\n"
        "print(json.dumps([[r['trial_id'], r['sound_file'], int(r['correct_response'])]"
        " for r in rows]))",
        tmp_path / "p" / "list-01.csv",
    )
    assert len(rows) == 16
    assert all((tmp_path / "p" / sound).is_file() for _, sound, _ in rows)


def test_psignifit_fits_the_table(tmp_path):
    from overview_studies.observers import Observers, simulate_answers, store_simulated
    from overview_studies.store import Store
    from studies.tests.files import study_of

    study, lists = study_of(tmp_path, varying("compare").replace("repeats = 4", "repeats = 40"))
    store = Store(tmp_path / "r.sqlite", study, list(lists.values()), simulated=True)
    store_simulated(store, simulate_answers(study, lists, Observers(1.0), 2, 0))
    store.close()
    exported(tmp_path / "r.sqlite", "--to", "psignifit", "-o", tmp_path / "p")
    middle = run_by(
        "psignifit",
        "import csv, json, sys, numpy, psignifit\n"
        "rows = [[float(r['level']), int(r['right']), int(r['trials'])]"
        " for r in csv.DictReader(open(sys.argv[1])) if r['participant'] == 'all']\n"
        "fit = psignifit.psignifit(numpy.array(rows), experiment_type='yes/no')\n"
        "print(json.dumps(float(fit.threshold(0.5, return_ci=False))))",
        tmp_path / "p" / "SIMULATED-psignifit.csv",
    )
    # between the neighbours of the standard, 8
    assert 4.0 < middle < 16.0


def test_the_bids_validator_finds_no_error(built, tmp_path):
    exported(built.answers, "--to", "bids", "-o", tmp_path / "b")
    validator = Path(TOOLS, "bin", "bids-validator-deno")
    if not TOOLS or not validator.is_file():
        pytest.skip("needs bids-validator-deno in the environment of OVERVIEW_STUDY_TOOLS")
    done = subprocess.run([validator, "--ignoreWarnings", tmp_path / "b"], capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert "BIDS compatible" in done.stdout
