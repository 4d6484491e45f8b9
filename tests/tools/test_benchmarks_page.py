"""docs/benchmarks.md: its tables are what `tools/write_benchmarks.py` writes of a report."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.measure import bench as speeds
from overview_dsp.measure.bench import Contender, run_in_turn, this_machine
from tools.bench import many_voices, scaling, solvers
from tools.bench.building import MissingError
from tools.bench.live.latency import LatencyResult
from tools.bench.live.table import LoadRow
from tools.bench.live.table import Report as LiveReport
from tools.bench.report import NEIGHBOURS, Report
from tools.bench.scaling import Cost, Memory

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
NUMBER = r"\d[\d.]*(?:e[+-]\d+)?"
FIGURE = re.compile(rf"({NUMBER}( to {NUMBER})?)?")


def tables(text):
    """Of each Markdown table, its head and its rows, as lists of cells."""
    found = []
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        rows = [[cell.strip() for cell in line[1:-1].split("|")] for line in block.splitlines()]
        found.append((rows[0], rows[2:]))
    return found


def without_numbers(name):
    """A row's name without what another machine changes: cores, lanes, errors."""
    return re.sub(NUMBER, "N", name.partition(", merged")[0])


def tool(name):
    """A script of `tools`, as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    # where dataclasses look for their own module
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def writer():
    return tool("write_benchmarks")


def marked(text, what):
    parts = text.split(f"<!-- bench: {what} -->\n")
    assert len(parts) == 2, what
    return parts[1].partition("<!-- end of bench -->")[0]


def test_the_tables_of_the_page_hold_figures_and_each_group_of_the_bench_has_one():
    found = tables(marked(PAGE, "speeds"))
    heads = [head[0] for head, _ in found]
    assert heads == [
        "the full voice",
        "the disk alone",
        "many voices, wall clock",
        "the kernel alone, wall clock",
        "what a second costs",
    ]
    for head, rows in found:
        assert rows
        for row in rows:
            assert len(row) == len(head)
            assert all(FIGURE.fullmatch(cell) for cell in row[1:]), row


def test_every_row_of_the_page_is_one_that_the_bench_measures(monkeypatch):
    # of the solvers only the names are needed
    monkeypatch.setattr(solvers, "solved", lambda *given: np.zeros(1))
    monkeypatch.setattr(solvers, "error", lambda *given: 1e-6)
    measured = speeds.contenders() + many_voices.contenders()
    for add in NEIGHBOURS:
        try:
            measured += add()
        except MissingError as missing:
            pytest.skip(f"needs what the bench compares with: {missing}")
    known = {(row.group, without_numbers(row.name)) for row in measured}
    for head, rows in tables(marked(PAGE, "speeds"))[:-1]:
        assert {(head[0], without_numbers(row[0])) for row in rows} <= known


def test_every_cost_of_the_page_is_one_that_the_bench_measures(monkeypatch):
    monkeypatch.setattr(
        scaling,
        "series",
        lambda name, cases, *_: [Cost(name, case.entry, 1, 1, 1, 0) for case in cases],
    )
    known = {f"{cost.series}: {cost.entry}" for cost in scaling.measure(1, 600.0)}
    _, rows = tables(marked(PAGE, "speeds"))[-1]
    assert {row[0].partition(", merged")[0] for row in rows} <= known


def test_a_report_replaces_what_stands_between_the_markers_and_nothing_else(writer):
    contenders = [Contender("a group", name, lambda: 2.0) for name in ("overView", "theirs")]
    costs = [Cost("events", "100000 events", 1.5, 1.4, 1.6, 16_384)]
    rows = run_in_turn(contenders, 2)
    report = Report(2, rows, 3.0, costs, Memory(300.0, 60.0, 301.0), ["no Faust"])
    found = {"machine": "a machine", "date": "2001-02-03", **asdict(report)}
    page = writer.filled(PAGE, "speeds", writer.speeds(json.loads(json.dumps(found))))
    written = marked(page, "speeds")
    assert "2001-02-03, a machine" in written
    assert "301 MB after a stream of 60 s" in written
    assert "Left out: no Faust." in written
    assert tables(written) == [
        (
            ["a group", "x realtime", "of the first", "lowest to highest"],
            [["overView", "2", "1", "1 to 1"], ["theirs", "2", "1", "1 to 1"]],
        ),
        (
            ["what a second costs", "of the first", "lowest to highest"],
            [["events: 100000 events, merged to 16384 strikes", "1.50", "1.4 to 1.6"]],
        ),
    ]
    assert page.replace(written, "") == PAGE.replace(marked(PAGE, "speeds"), "")
    with pytest.raises(SystemExit, match="not 0"):
        writer.filled("no markers", "speeds", "")


def test_a_live_report_is_written_as_the_command_prints_it(writer):
    load = [
        LoadRow(callback, loaded, 1.0, 2.0, 3.0, 100, 0, 0, 0.1, 0.0, 0.2)
        for callback, loaded in (("native", True), ("python", True))
    ]
    latency = [LatencyResult(64, 30, 3.35, 5.36, 161.0, 257.0, 0, 5.33)]
    report = LiveReport(48_000, 256, 60.0, 5, load, 1.0, False, latency, 383, [])
    found = {"machine": "a machine", "date": "2001-02-03", **asdict(report)}
    page = writer.filled(PAGE, "live", writer.live(json.loads(json.dumps(found))))
    written = marked(page, "live")
    assert "2001-02-03, a machine" in written
    assert "python, load" in written
    assert "\n64         1.33      30        3.35" in written
    assert page.replace(written, "") == PAGE.replace(marked(PAGE, "live"), "")


def test_first_starts_are_a_row_for_each_command(writer):
    starts = [
        {"command": "demo", "imports_s": 0.987, "first_sound_s": 1.0, "whole_s": 2.0},
        {"command": "serve", "imports_s": 0.5, "first_sound_s": 0.25, "whole_s": None},
    ]
    report = {"machine": "a machine", "date": "2001-02-03", "first_starts": starts}
    assert writer.what_of(report) == "first starts"
    written = marked(
        writer.filled(PAGE, "first starts", writer.first_starts(report)), "first starts"
    )
    assert "2001-02-03, a machine" in written
    ((head, rows),) = tables(written)
    assert rows == [
        ["`overview demo`", "0.99", "1.00", "2.00"],
        ["`overview serve`", "0.50", "0.25", ""],
    ]
    ((head_of_page, shown),) = tables(marked(PAGE, "first starts"))
    assert head_of_page == head
    assert [row[0].strip("`").split()[1] for row in shown] == list(
        tool("measure_first_starts").COMMANDS
    )
    assert all(FIGURE.fullmatch(cell) for row in shown for cell in row[1:])


def test_a_machine_is_a_line():
    line = this_machine()
    assert "\n" not in line
    assert " core" in line
    assert "numba" in line
