"""Charts as JSON documents of MAIDR: lines, bars, histograms and points, by x.

Their schema is that of https://github.com/xability/maidr. Numbers and dates on the x axis are the
times; names are one second apart, and events.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.series.series_reader import series_timeline
from overview_dsp.data.readers.tables.memory import table_of
from overview_dsp.data.readers.tables.time_column import as_number
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import FORMS, moment
from overview_dsp.errors import InputError, quoted

KIND = "bar"
"""Kind of the events of an x axis with names."""

Points = list[tuple[Any, Any]]


def sniff(source: DataFile) -> bool:
    """Return whether the file is a chart: layers with a type, axes and data."""
    if not source.looks_like_json or not isinstance(source.json, dict):
        return False
    layers = _layers(source.json)
    return bool(layers) and all({"type", "axes", "data"} <= layer.keys() for layer in layers)


def matches(source: DataFile) -> list[str]:
    """Return the names of the chart's lines."""
    return list(_lines(source.json))


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a line of a chart (takes `match`, `map`); InputError lists them, or names a value."""
    lines = _lines(source.json)
    chosen = [n for n in lines if options.match in (None, n)]
    if not lines:
        kinds = ", ".join(sorted({quoted(layer["type"]) for layer in _layers(source.json)}))
        raise InputError(
            f"a chart of type {kinds} has no points with x and y; line, bar, hist and point can be "
            "read"
        )
    if len(chosen) != 1:
        listed = ", ".join(map(quoted, list(lines)[:8]))
        raise InputError(f"{len(lines)} lines; choose one with match (--select): {listed}")
    x_name, y_name, points = lines[chosen[0]]
    if y_name == x_name:
        x_name, y_name = "x", y_name if y_name != "x" else "y"
    places = [as_number(x) for x, _ in points]
    if None not in places:
        points.sort(key=lambda point: as_number(point[0]) or 0.0)
    only = replace(options, match=None, value=y_name)
    values = {y_name: [y for _, y in points]}
    if not all(isinstance(x, str) and not _is_moment(x) for x, _ in points):
        table = table_of({x_name: [x for x, _ in points], **values})
        only = replace(only, time=x_name)
        return series_timeline(replace(table, kind="chart"), only, chosen[0])
    table = replace(table_of(values), kind="chart")
    found = series_timeline(table, replace(only, rate=1.0), chosen[0])
    bars = (Event(float(i), KIND, f"{x}: {y}") for i, (x, y) in enumerate(points))
    note = f"the names of {quoted(x_name)} stand one second apart"
    return replace(found, events=tuple(bars), notes=(note, *found.notes))


def _is_moment(text: str) -> bool:
    return as_number(text) is not None or any(moment(text, form) for form in FORMS)


def _layers(document: Any) -> list[dict[str, Any]]:
    """Return the layers of all subplots, or the document of a chart with one."""
    if not isinstance(document.get("subplots"), list):
        return [document]
    rows = [row for row in document["subplots"] if isinstance(row, list)]
    plots = [plot for row in rows for plot in row if isinstance(plot, dict)]
    layers = [one for plot in plots if isinstance(one := plot.get("layers"), list)]
    return [one for some in layers for one in some if isinstance(one, dict)]


def _lines(document: Any) -> dict[str, tuple[str, str, Points]]:
    """Return names of the axes and points by name of the line."""
    found: dict[str, tuple[str, str, Points]] = {}
    names: Counter[str] = Counter()
    for layer in _layers(document):
        axes = layer["axes"] if isinstance(layer["axes"], dict) else {}
        x, y = (_label(axes.get(axis), axis) for axis in "xy")
        title = str(layer.get("title") or document.get("title") or layer["type"])
        for fill, points in _groups(layer["data"]):
            name = f"{title}, {fill}" if fill else title
            names[name] += 1
            if names[name] > 1 or name in found:
                name = f"{name} ({names[name]})"
            if layer.get("orientation") == "horz":
                found[name] = (y, x, [(b, a) for a, b in points])
            else:
                found[name] = (x, y, points)
    return found


def _label(axis: Any, name: str) -> str:
    label = axis.get("label") if isinstance(axis, dict) else axis
    return label if isinstance(label, str) and label else name


def _groups(data: Any) -> Iterator[tuple[str, Points]]:
    """Yield what distinguishes each group of points, and the points."""
    if isinstance(data, dict):
        columns = [data.get(name) for name in "xy"]
        # a heat map has points beside the names of its rows and columns
        if "points" not in data and all(isinstance(column, list) for column in columns):
            data = [{"x": x, "y": y} for x, y in zip(*columns, strict=False)]
        else:
            data = data.get("points")
    entries = data if isinstance(data, list) else []
    groups = entries if entries and all(isinstance(one, list) for one in entries) else [entries]
    for group in groups:
        fills: dict[str, Points] = {}
        for one in group:
            if isinstance(one, dict) and {"x", "y"} <= one.keys():
                if any(isinstance(one[axis], list | dict) for axis in "xy"):
                    raise InputError(f"the point {quoted(one)}; x and y must be numbers or texts")
                fills.setdefault(str(one.get("fill") or ""), []).append((one["x"], one["y"]))
        yield from fills.items()
