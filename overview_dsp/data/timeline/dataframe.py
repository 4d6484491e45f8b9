"""Columns as a pandas DataFrame, where pandas is installed."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any

from overview_dsp.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame


def dataframe(columns: Mapping[str, Any]) -> DataFrame:
    """Make a DataFrame of columns of equal length; InputError says how to install pandas."""
    try:
        from pandas import DataFrame
    except ImportError as error:
        raise InputError(
            'a DataFrame needs pandas: pip install "overview-dsp[dataframes]"'
        ) from error
    return DataFrame(dict(columns))


def moments(start: datetime, time_s: Any) -> Any:
    """Make calendar moments of seconds from a start, in its zone."""
    from pandas import Timestamp, to_timedelta

    return Timestamp(start) + to_timedelta(time_s, unit="s")
