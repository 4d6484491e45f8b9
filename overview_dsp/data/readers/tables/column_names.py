"""Names of columns, by role (`column_names.toml`): the vocabulary of all readers of tables."""

from __future__ import annotations

import re
from typing import Any

from overview_dsp.files.toml import load_toml

_TABLE: dict[str, Any] = load_toml(__file__, "column_names.toml")

NAMES: dict[str, tuple[str, ...]] = {
    role: tuple(names) for role, names in _TABLE.items() if isinstance(names, list)
}
TIME_UNITS: dict[str, str] = _TABLE["time_units"]
TIME_FORMATS: dict[str, str] = _TABLE["time_formats"]
CHART_LETTERS: dict[str, str] = _TABLE["chart_letters"]
HEADER_UNITS: dict[str, str] = _TABLE["header_units"]
MINUTE_LIST: dict[str, list[str]] = _TABLE["minute_list"]
MINUTE_LIST_PERIODS: dict[str, list[str]] = _TABLE["minute_list_periods"]
PATTERNS: dict[str, re.Pattern[str]] = {
    name: re.compile("|".join(parts), re.IGNORECASE) for name, parts in _TABLE["patterns"].items()
}
TRACK_ELEMENTS: dict[str, str] = _TABLE["track_elements"]
FIT_FIELDS: dict[str, str] = _TABLE["fit_fields"]
UNIT_SUFFIX = re.compile(r"(?:in)?(ns|us|ms|s|sec|secs|seconds|min|mins|minutes|h|hrs|hours)$")
