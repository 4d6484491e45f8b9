"""Scripts for further analysis: mixed models in R (lme4), and in Python (statsmodels).

The formula follows the design: factors within participants have a slope of each participant where
there is a row per trial. Without such a factor there is one number per participant, and no group.
The first level of a factor in the study file is the one that others are compared with.
"""

from __future__ import annotations

import json
import keyword
import re
from collections.abc import Mapping
from typing import Any

from overview_studies.answers import FOUND_TOLERANCE, Answers
from overview_studies.columns import RESERVED_COLUMNS
from overview_studies.design import NONE
from overview_studies.measures import (
    JND_PER_WIDTH,
    UNITS,
    Measures,
    compute_measures,
    conditions_of,
)
from overview_studies.scales import scale_of
from overview_studies.tables import cell, csv_text, one_line

R_SCRIPT, PYTHON_SCRIPT, MEASURES = "analysis.R", "analysis.py", "measures.csv"

MAIN_MEASURES = {
    "identify": "d_prime",
    "locate": "location_error",
    "search": "hits",
    "count": "exact",
    "compare": "accuracy",
    "draw": "likeness",
    "adjust": "adjusted",
    "staircase": "threshold",
    "quest": "threshold",
}
"""Main measure of each task."""


_OWN_COLUMNS = {"x", "stronger", "signal", "chosen", "hit"}
_R_WORDS = {"repeat", "function", "next", "TRUE", "FALSE", "NULL", "Inf", "NaN", "NA"}


def measures_csv(answers: Answers, measures: Measures | None = None) -> str:
    """Return a table with one row per participant, condition and measure.

    Levels and their distances are positions on the scale of the levels, such as logarithms. A
    missing number has a reason.
    """
    names = conditions_of(answers.study)
    found = measures or compute_measures(answers)
    reasons = {(one.measure, one.condition, one.participant): one.reason for one in found.missing}
    rows = [
        {**answers.mark, "participant": who, **dict(condition), "measure": measure,
         "unit": UNITS.get(measure.partition(".")[0], ""),
         "value": value if value == value else None,
         "reason": reasons.get((measure, condition, who))}
        for (measure, condition), by in found.values.items()
        for who, value in by.items()
    ]  # fmt: skip
    columns = [*answers.mark, "participant", *names, "measure", "unit", "value", "reason"]
    return csv_text(columns, rows)


def _identifiers(study: Mapping[str, Any]) -> dict[str, str]:
    """Return a name for both languages of each factor that forms conditions."""
    reserved = {*keyword.kwlist, *_R_WORDS, *_OWN_COLUMNS, *RESERVED_COLUMNS}
    found: dict[str, str] = {}
    for name in conditions_of(study):
        is_plain = re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name) and name not in reserved
        plain = name if is_plain else "factor_" + re.sub("[^A-Za-z0-9_]", "_", name)
        while plain in found.values():
            plain += "_"
        found[name] = plain
    return found


def _crossed(names: list[str]) -> str:
    return " * ".join(names) or "1"


def r_script(answers: Answers) -> str:
    """Return an R script with the mixed model of the task and design."""
    study = answers.study
    task, choices = study["task"], study["task"].get("choices", ())
    names = {name: f"`{plain}`" for name, plain in _identifiers(study).items()}
    within = [names[name] for name in names if study["factors"][name]["kind"] == "within"]
    fixed, slopes = list(names.values()), ["1", *within]
    phases, own, after = ["main"], "", ""
    family = 'family = binomial("logit")'
    if task["name"] == "identify" and len(choices) == 2:
        # the noise is the second choice, or that there was nothing
        signal = _r_text(next(choice for choice in choices if choice != NONE))
        phases = ["main", "catch"]
        own = (
            "# signal detection: the coefficient of signal is d', the intercept is -c, interactions"
            f"\n# with signal are differences of d'\n"
            f"main$signal <- ifelse(main$correct_response == {signal}, 0.5, -0.5)\n"
            f"main$chosen <- as.integer(main$response == {signal})\n"
        )
        fixed, slopes = ["signal", *fixed], ["1", _crossed(["signal", *within])]
        left, family = "chosen", 'family = binomial("probit")'
    elif task["name"] in ("identify", "count"):
        left, phases = "correct", ["main", "catch"] if task["name"] == "identify" else ["main"]
    elif task["name"] == "search":
        own = f"main$hit <- !is.na(main$error) & abs(main$error) <= {FOUND_TOLERANCE}\n"
        left = "hit"
    elif task["name"] in ("locate", "draw"):
        own = 'cat(sum(is.na(main$error)), "of", nrow(main), "trials without an error\\n")\n'
        left, family = "abs(error)", ""
    elif task["name"] == "compare" and scale_of(study).kind != "index":
        own, after = _r_comparison(study, fixed)
        fixed, slopes = ["x", *fixed], ["1", _crossed(["x", *within])]
        left, family = "stronger", 'family = binomial("probit")'
    else:
        main = MAIN_MEASURES[task["name"]]
        read = _r_read(answers, MEASURES, f'main$measure == "{main}"', names)
        shown = ", ".join(_r_text(name) for name in ["participant", *names, "reason"])
        missing = (
            "missing <- main[is.na(main$value), ]\n"
            'cat(nrow(missing), "of", nrow(main), "values are missing\\n")\n'
            f"print(missing[, c({shown})], row.names = FALSE)\n"
            "main <- main[!is.na(main$value), ]\n"
        )
        model = f"lmer(value ~ {_crossed(fixed)} + (1 | participant), data = main)"
        if not within:
            model = f"lm(value ~ {_crossed(fixed)}, data = main)"
        plain = ", ".join(_r_text(name.strip("`")) for name in fixed)
        cells = f", table(main[c({plain})])" if fixed else ""
        return (
            f"{_head(study)}library(lme4)\n{read}{missing}"
            f"if (all(c(nrow(main){cells}) > 0)) {{\n  model <- {model}\n"
            '  print(summary(model))\n} else cat("no model: a condition has no value\\n")\n'
        )
    stimuli = {row["stimulus"] for row in answers.rows() if row["phase"] in phases}
    groups = f"({' + '.join(slopes)} | participant)"
    if len(stimuli) > 1 and task["name"] != "compare":
        groups += " + (1 | stimulus)"
    model = f"lmer({left} ~ {_crossed(fixed)} + {groups}, data = main)"
    if family:
        family += ',\n               control = glmerControl(optimizer = "bobyqa")'
        model = f"g{model[:-1]}, {family})"
    rows = f"main$phase %in% c({', '.join(map(_r_text, phases))})"
    read = _r_read(answers, "responses.csv", rows, names)
    return (
        f"{_head(study)}library(lme4)\n{read}{own}model <- {model}\nprint(summary(model))\n{after}"
    )


def _r_text(text: str) -> str:
    """Return a literal of R."""
    return json.dumps(text.replace("\0", ""), ensure_ascii=False)


def _r_read(answers: Answers, file: str, rows: str, names: Mapping[str, str]) -> str:
    """Return lines of R that read the rows of a table, with the factors in order."""
    texts = ", ".join(f"{_r_text(name)} = 'character'" for name in ["participant", *names])
    lines = [
        f'main <- read.csv("{answers.marked(file)}", check.names = FALSE, na.strings = "",',
        f"                 colClasses = c({texts}), encoding = 'UTF-8')",
        f"main <- main[{rows}, ]",
    ]
    for name, plain in names.items():
        levels = ", ".join(_r_text(cell(one)) for one in answers.study["factors"][name]["levels"])
        lines.append(f"main${plain} <- factor(main[[{_r_text(name)}]], levels = c({levels}))")
    return "\n".join(lines) + "\n"


def _r_comparison(study: Mapping[str, Any], names: list[str]) -> tuple[str, str]:
    """Return lines of R before and after the model of a comparison.

    They have the distance from the standard, and print point of equality and JND by condition.
    """
    is_log, standard = scale_of(study).kind == "log", float(study["task"]["standard"])
    of, power, plus = ("log10({})", "10^", "*") if is_log else ("{}", "", "+")
    columns = ", ".join(_r_text(name.strip("`")) for name in names)
    cells = f"unique(main[, c({columns}), drop = FALSE])" if names else "data.frame(all = 'all')"
    return (
        f"main$x <- {of.format('main$level')} - {of.format(standard)}\n"
        "main$stronger <- ifelse(main$x > 0, main$correct, 1 - main$correct)\n",
        f"cells <- {cells}\n"
        "at <- predict(model, cbind(cells, x = 0), re.form = NA)\n"
        "slope <- predict(model, cbind(cells, x = 1), re.form = NA) - at\n"
        f"cells$pse <- {standard} {plus} {power}(-at / slope)\n"
        f"cells$jnd <- {power}({JND_PER_WIDTH} / slope)\n"
        "print(cells, row.names = FALSE)\n",
    )


def _head(study: Mapping[str, Any]) -> str:
    return f"# {one_line(study['title'])}: a first mixed model\n"


def python_script(answers: Answers) -> str:
    """Return a Python script with the model of the main measure (pandas, statsmodels)."""
    names, factors = _identifiers(answers.study), answers.study["factors"]
    main = MAIN_MEASURES[answers.study["task"]["name"]]
    formula = f"value ~ {_crossed(list(names.values()))}"
    model = (
        f"smf.mixedlm({formula!r}, rows, groups=rows['participant'])"
        if any(factors[name]["kind"] == "within" for name in names)
        else f"smf.ols({formula!r}, rows)"
    )
    lines = [
        "import pandas as pd",
        "import statsmodels.formula.api as smf",
        "",
        f"rows = pd.read_csv({answers.marked(MEASURES)!r}, keep_default_na=False, na_values=[''],",
        f"                   dtype={dict.fromkeys(['participant', *names], 'str')!r})",
        f"rows = rows[rows['measure'] == {main!r}]",
        "missing = rows[rows['value'].isna()]",
        "print(len(missing), 'of', len(rows), 'values are missing')",
        f"print(missing[{['participant', *names, 'reason']!r}].to_string(index=False))",
        "rows = rows[rows['value'].notna()].copy()",
    ]
    for name, plain in names.items():
        levels = [cell(one) for one in factors[name]["levels"]]
        lines.append(f"rows[{plain!r}] = pd.Categorical(rows[{name!r}], categories={levels!r})")
    if names:
        lines.append(f"cells = rows.groupby({list(names.values())!r}, observed=False).size()")
    known = "len(rows) and (cells > 0).all()" if names else "len(rows)"
    lines += [
        f"if {known}:",
        f"    print({model}.fit().summary())",
        "else:",
        "    print('no model: a condition has no value')\n",
    ]
    return _head(answers.study) + "\n".join(lines)
