"""Answers as CSV and TSV text."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from overview_studies.answers import Answers


def cell(value: Any) -> str:
    """Return a value as cell text: lists as JSON, empty text for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, list | dict):
        return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return repr(value) if isinstance(value, float) else str(value)


def one_line(text: str) -> str:
    """Return a text without line ends and control characters, for a comment or a heading."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


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
