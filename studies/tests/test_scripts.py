"""The scripts of a report: formulas that fit the design, and established statistics that agree."""

from __future__ import annotations

import ast
import csv
import io
import re
import runpy
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from overview_dsp.errors import InputError
from overview_studies.analysis import analyse
from overview_studies.measures import JND_PER_WIDTH, level_counts
from overview_studies.observers import Observers, simulate_answers
from overview_studies.scripts import measures_csv, python_script, r_script
from overview_studies.statistics import fit_psychometric
from studies.tests.files import IDENTIFY, detecting, other, study_of, varying
from studies.tests.test_tasks import HALVES

WITHIN_FACTOR = 'mapping = { within = ["friction", "static"] }'
WITHIN = '[factors]\nmapping = { within = ["friction", "static"] }\n'
BETWEEN = '[factors]\nmapping = { between = ["friction", "static"] }\n'


def answers_of(folder, text, people=8, observers=None):
    study, lists = study_of(folder, text)
    return simulate_answers(study, lists, observers or Observers(1.5, 0.3), people, 3)


def is_parsed(script, folder):
    """Each bracket and quote of a script is closed; R reads it where it is installed."""
    code = re.sub(r'"(?:[^"\\]|\\.)*"|' "'[^']*'|`[^`]*`|#.*", "", script)
    assert not set("\"'`") & set(code), code
    pair = r"\([^(){}\[\]]*\)|\[[^(){}\[\]]*\]|\{[^(){}\[\]]*\}"
    while re.search(pair, code):
        code = re.sub(pair, "", code)
    assert not set("()[]{}") & set(code), code
    if shutil.which("Rscript"):
        (folder / "parsed.R").write_text(script, encoding="utf-8")
        subprocess.run(["Rscript", "-e", "invisible(parse('parsed.R'))"], cwd=folder, check=True)


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        (IDENTIFY, "glmer(correct ~ `mapping` * `input` + (1 + `mapping` | participant) + "
                   "(1 | stimulus)"),
        (other("locate") + BETWEEN, "lmer(abs(error) ~ `mapping` + (1 | participant) + "
                                    "(1 | stimulus)"),
        (varying("compare") + WITHIN, "glmer(stronger ~ x * `mapping` + "
                                       "(1 + x * `mapping` | participant), data = main"),
    (varying("compare"), "cells$pse <- 8.0 * 10^(-at / slope)"),
    (detecting(4, 8, WITHIN_FACTOR), "main$phase %in% c(\"main\", \"catch\")"),
    (detecting(4, 8, WITHIN_FACTOR), "main$signal <- ifelse(main$correct_response == \"goal\", "
                                     "0.5, -0.5)"),
    (detecting(4, 8, WITHIN_FACTOR), "glmer(chosen ~ signal * `mapping` + "
                                     "(1 + signal * `mapping` | participant) + (1 | stimulus)"),
    (varying("adjust") + WITHIN, "levels = c(\"friction\", \"static\")"),
        (varying("compare"), "log10(main$level) - log10(8.0)"),
        (varying("adjust") + WITHIN, "lmer(value ~ `mapping` + (1 | participant)"),
        (varying("adjust") + BETWEEN, "lm(value ~ `mapping`"),
        (varying("adjust"), "lm(value ~ 1"),
    ],
)  # fmt: skip
def test_the_formula_of_the_script_for_r_is_that_of_the_design(tmp_path, text, formula):
    script = r_script(answers_of(tmp_path, text, 4))
    is_parsed(script, tmp_path)
    assert formula in " ".join(script.split())
    assert "SIMULATED-" in script


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n", "\x0c", "\x85", "\u2028"])
def test_a_line_end_in_a_title_starts_no_statement_in_a_script(tmp_path, end):
    """A study file or a file of answers may be another person's."""
    answers = answers_of(tmp_path, varying("adjust"), 2)
    title = f'Mine{end}raise SystemExit("run"){end}system("run") #'
    answers = replace(answers, study={**answers.study, "title": title}, simulated=False)
    for script in (r_script(answers), python_script(answers)):
        assert script.startswith('# Mine raise SystemExit("run") system("run") #')
        assert not any("run" in line for line in script.splitlines()[1:])
        assert "\0" not in script
    ast.parse(python_script(answers))


def test_the_table_of_measures_has_the_numbers_that_are_averaged(tmp_path):
    answers = answers_of(tmp_path, varying("adjust") + WITHIN)
    rows = list(csv.DictReader(io.StringIO(measures_csv(answers))))
    assert {row["simulated"] for row in rows} == {"SIMULATED"}
    own = [float(row["value"]) for row in rows
           if row["measure"] == "adjusted" and row["mapping"] == "static"]  # fmt: skip
    line = analyse(answers).line("adjusted", mapping="static").estimate
    assert len(own) == line.participants == 8
    assert 10.0 ** np.mean(own) == pytest.approx(line.mean)


@pytest.mark.parametrize("factors", [WITHIN, BETWEEN])
def test_statsmodels_finds_the_difference_of_the_report(tmp_path, monkeypatch, capsys, factors):
    pytest.importorskip("statsmodels", reason="the script needs statsmodels")
    answers = answers_of(tmp_path, other("draw", stimuli='made = { curves = ["rise", "dip"] }')
                         + factors)  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / answers.marked("measures.csv")).write_text(measures_csv(answers))
    (tmp_path / "analysis.py").write_text(python_script(answers))
    runpy.run_path("analysis.py")
    printed = next(line for line in capsys.readouterr().out.splitlines() if "[T.static]" in line)
    found = float(printed.split()[1])
    (difference,) = [one.estimate for one in analyse(answers).differences
                     if one.measure == "likeness"]  # fmt: skip
    assert found == pytest.approx(difference.mean, abs=1e-3)


def test_a_condition_without_a_value_has_no_model(tmp_path, monkeypatch, capsys):
    pytest.importorskip("statsmodels", reason="the script needs statsmodels")
    answers = answers_of(tmp_path, varying("adjust"))
    table = measures_csv(answers).splitlines()
    names = table[0].split(",")
    one = table[1].split(",")
    one[names.index("value")] = ""
    monkeypatch.chdir(tmp_path)
    (tmp_path / answers.marked("measures.csv")).write_text("\n".join([table[0], ",".join(one)]))
    (tmp_path / "analysis.py").write_text(python_script(answers))
    runpy.run_path("analysis.py")
    assert "no model: a condition has no value" in capsys.readouterr().out


ODD = """
[factors]
class = { within = ["new", "NA"], order = "williams" }
"a b`c" = { between = ["01", "1"] }
[text.conditions]
"class.new" = "1"
"class.NA" = "2"
"a b`c.01" = "3"
"a b`c.1" = "4"
"""


@pytest.mark.filterwarnings("ignore:The MLE may be on the boundary")
def test_names_and_levels_of_factors_that_a_language_reserves_are_read_as_they_are(
    tmp_path, monkeypatch, capsys
):
    pytest.importorskip("statsmodels", reason="the script needs statsmodels")
    answers = answers_of(tmp_path, varying("adjust") + ODD, 12)
    script = r_script(answers)
    is_parsed(script, tmp_path)
    assert 'main$`factor_a_b_c` <- factor(main[["a b`c"]], levels = c("01", "1"))' in script
    assert "`factor_class` * `factor_a_b_c` + (1 | participant)" in script
    monkeypatch.chdir(tmp_path)
    (tmp_path / answers.marked("measures.csv")).write_text(measures_csv(answers))
    (tmp_path / "analysis.py").write_text(python_script(answers))
    runpy.run_path("analysis.py")
    printed = capsys.readouterr().out
    assert "0 of 24 values are missing" in printed
    for term in ("factor_class[T.NA] ", "factor_a_b_c[T.1] "):
        assert term in printed


def test_a_factor_with_the_name_of_a_column_is_refused(tmp_path):
    for name in ("participant", "phase", "value", "simulated"):
        text = varying("adjust") + f'[factors]\n{name} = {{ between = ["a", "b"] }}\n'
        with pytest.raises(InputError, match=f"factors.{name}: .* rename"):
            study_of(tmp_path, text)


def test_the_scripts_name_who_has_no_threshold(tmp_path, monkeypatch, capsys):
    pytest.importorskip("statsmodels", reason="the script needs statsmodels")
    answers = answers_of(
        tmp_path,
        varying("staircase", "standard = 2.0").replace("[2.0, 4.0, 8.0, 16.0, 32.0]", HALVES),
        16,
        Observers(0.12),
    )
    missing = analyse(answers).missing
    assert 0 < len(missing) < 8
    monkeypatch.chdir(tmp_path)
    (tmp_path / answers.marked("measures.csv")).write_text(measures_csv(answers))
    (tmp_path / "analysis.py").write_text(python_script(answers))
    runpy.run_path("analysis.py")
    printed = capsys.readouterr().out
    assert f"{len(missing)} of 16 values are missing" in printed
    assert all(re.search(f"{one.participant}.*{one.reason}", printed) for one in missing)
    script = r_script(answers)
    is_parsed(script, tmp_path)
    assert 'print(missing[, c("participant", "reason")]' in script


def test_a_fit_is_that_of_a_probit_model_to_one_percent(tmp_path):
    """Without lapses, the function is a generalized linear model with a probit link."""
    sm = pytest.importorskip("statsmodels.api", reason="an independent implementation")
    answers = answers_of(tmp_path, varying("compare").replace("repeats = 4", "repeats = 20"), 1,
                         Observers(1.0))  # fmt: skip
    levels, right, trials = level_counts(answers.study, answers.rows())
    fitted = fit_psychometric(levels, right, trials, None, 0.0)
    model = sm.GLM(np.column_stack([right, trials - right]), sm.add_constant(levels),
                   family=sm.families.Binomial(sm.families.links.Probit()))  # fmt: skip
    intercept, slope = model.fit(tol=1e-12).params
    assert fitted.threshold == pytest.approx(-intercept / slope, rel=0.01)
    assert JND_PER_WIDTH * fitted.width == pytest.approx(JND_PER_WIDTH / slope, rel=0.01)
