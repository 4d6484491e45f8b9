"""Answers as CSV and TSV text, and a script for R."""

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
    """Return a value as cell text: lists as JSON, empty text for None."""
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
    """Return a table with a header; absent cells are `missing`."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([cell(row.get(name)) or missing for name in columns])
    return out.getvalue()


def responses_csv(answers: Answers) -> str:
    """Return a table with one row per trial."""
    return csv_text(answers.columns, answers.rows())


def forms_csv(answers: Answers) -> str:
    """Return a table with one row per item of a form."""
    columns = ["participant", "session", "list", "block", *answers.study["factors"]]
    columns = [*answers.mark, *columns, "form", "item", "value", "received_utc"]
    return csv_text(columns, answers.forms())


def r_script(answers: Answers) -> str:
    """Return an R script that fits a mixed model to the table of responses."""
    table = answers.marked("responses.csv")
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
        f"# {answers.study['title']}: a first mixed model\n"
        "library(lme4)\n"
        f'rows <- read.csv("{table}", stringsAsFactors = FALSE)\n'
        'main <- subset(rows, phase == "main")\n'
        f"{factors}{model}\nprint(summary(model))\n"
    )
