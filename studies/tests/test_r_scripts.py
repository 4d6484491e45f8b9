"""The scripts for R: R runs them on simulated answers, and finds what the report has."""

from __future__ import annotations

import csv
import shutil
import subprocess

import numpy as np
import pytest
from scipy.special import ndtri

from overview_studies.analysis import analyse
from overview_studies.exporting import export_answers
from overview_studies.observers import Observers, simulate_answers
from overview_studies.scales import scale_of
from overview_studies.scripts import MAIN_MEASURES
from studies.tests.files import study_of, varying
from studies.tests.test_scripts import BETWEEN, ODD
from studies.tests.test_simulated_studies import AT_LIMIT, CASES, drafted

OWN = {"adjust, between": varying("adjust") + BETWEEN, "adjust, odd": varying("adjust") + ODD}
RUN = """
for (folder in commandArgs(TRUE)) {
  setwd(folder)
  own <- new.env()
  outcome <- try(source("SIMULATED-analysis.R", local = own))
  writeLines(if (inherits(outcome, "try-error")) outcome else "", "error.txt")
  if (is.null(own$model)) next
  found <- if (inherits(own$model, "lm")) coef(own$model) else fixef(own$model)
  write.csv(data.frame(value = found), "found.csv")
  if (!is.null(own$cells) && is.data.frame(own$cells)) write.csv(own$cells, "cells.csv")
  if (inherits(own$model, "glmerMod")) {
    shares <- tapply(fitted(own$model), own$model@frame[[2]], mean)
    write.csv(data.frame(value = shares), "shares.csv")
  }
}
"""


@pytest.fixture(scope="module")
def in_r(tmp_path_factory):
    started = shutil.which("Rscript") and subprocess.run(
        ["Rscript", "-e", "library(lme4)"], capture_output=True, check=False
    )
    if not started or started.returncode:
        pytest.skip("needs lme4 of R: apt-get install r-base-core r-cran-lme4")
    folder, answers = tmp_path_factory.mktemp("r"), {}
    for name in (*CASES, *OWN):
        study, lists = drafted(name) if name in CASES else study_of(folder, OWN[name])
        d = CASES[name][2] if name in CASES else 1.0
        answers[name] = simulate_answers(study, lists, Observers(d), 12, 3)
        export_answers(answers[name], "r", folder / name)
    (folder / "run.R").write_text(RUN)
    folders = [str(folder / name) for name in answers]
    subprocess.run(["Rscript", str(folder / "run.R"), *folders], check=True, capture_output=True)
    return folder, answers


def values(path, column="value"):
    with open(path, newline="") as file:
        return [float(row[column]) for row in csv.DictReader(file)]


@pytest.mark.parametrize("name", [*CASES, *OWN])
def test_r_runs_the_script_and_finds_what_the_report_has(in_r, name):
    folder, answers = in_r[0] / name, in_r[1][name]
    assert not (folder / "error.txt").read_text().strip()
    if name == AT_LIMIT:
        assert not (folder / "found.csv").exists()
        return
    task, found = answers.study["task"]["name"], values(folder / "found.csv")
    report, scale = analyse(answers), scale_of(answers.study)
    main = {"draw": "drawn_error", "identify": "accuracy"}.get(task, MAIN_MEASURES[task])
    lines = [one.estimate.mean for one in report.estimates if one.measure == main]
    if task == "compare":
        pse, jnd = (report.line(one).estimate.mean for one in ("pse", "jnd"))
        step = scale.axis_position(jnd)
        assert scale.axis_position(values(folder / "cells.csv", "pse")[0]) == pytest.approx(
            scale.axis_position(pse), abs=0.01 * step)  # fmt: skip
        assert scale.axis_position(values(folder / "cells.csv", "jnd")[0]) == pytest.approx(
            step, rel=0.01)  # fmt: skip
    elif name == "detect":
        # all answers together, without the correction that the report has for each participant
        left, right = (ndtri(one[0, 0] / one[0].sum()) - ndtri(one[1, 0] / one[1].sum())
                       for one in report.matrices.values())  # fmt: skip
        assert [found[1], found[1] + found[3]] == pytest.approx([left, right], rel=0.01)
    elif task in ("identify", "count", "search"):
        assert values(folder / "shares.csv") == pytest.approx(lines, rel=0.01)
    elif "odd" not in name:
        means = np.array(found) + found[0] * (np.arange(len(found)) > 0)
        if main in ("adjusted", "threshold"):
            lines = list(map(scale.axis_position, lines))
        assert means == pytest.approx(lines, rel=1e-3, abs=1e-6)
