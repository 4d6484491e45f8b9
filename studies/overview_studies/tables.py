"""Answers as text: tidy CSV and TSV, and the script that R begins with."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from overview_studies.answers import Answers
from overview_studies.measures import conditions_of

R_SCRIPT = "analysis.R"


def cell(value: Any) -> str:
    """A value in a cell: numbers with a point, lists as JSON, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, list | dict):
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return repr(value) if isinstance(value, float) else str(value)


def csv_text(
    columns: Sequence[str],
    rows: Iterable[Mapping[str, Any]],
    delimiter: str = ",",
    missing: str = "",
) -> str:
    """A table with a header; columns that a row doesn't have are `missing`."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([cell(row.get(name)) or missing for name in columns])
    return out.getvalue()


def responses_csv(answers: Answers) -> str:
    """Tidy: one row a trial."""
    return csv_text(answers.columns, answers.rows())


def forms_csv(answers: Answers) -> str:
    """One row an item of a form."""
    columns = ["participant", "session", "list", "block", *answers.study["factors"]]
    return csv_text([*columns, "form", "item", "value", "received_utc"], answers.forms())


def r_script(answers: Answers, table: str = "responses.csv") -> str:
    """A mixed model to start from, in R: what this program leaves to R."""
    task = answers.study["task"]["name"]
    names = conditions_of(answers.study)
    fixed = " * ".join(names) or "1"
    model = (
        f"model <- glmer(correct ~ {fixed} + (1 | participant) + (1 | stimulus),\n"
        '               data = main, family = binomial("logit"))'
        if task in ("identify", "count", "compare", "staircase", "quest")
        else f"model <- lmer(abs(error) ~ {fixed} + (1 | participant) + (1 | stimulus),\n"
        "              data = main)"
    )
    factors = "".join(f"main${name} <- factor(main${name})\n" for name in names)
    return (
        f"# {answers.study['title']}: a mixed model to start from\n"
        "library(lme4)\n"
        f'rows <- read.csv("{table}", stringsAsFactors = FALSE)\n'
        'main <- subset(rows, phase == "main")\n'
        f"{factors}{model}\nprint(summary(model))\n"
    )
