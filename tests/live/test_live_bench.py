"""`python -m tools.bench --live` on a headless JACK server, with windows too short for figures."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from tests.live import jack_server
from tools.bench.__main__ import command
from tools.bench.live.table import BLOCKS, LOAD_CASES, SESSIONS, LoadRow, lost_ratio

needs_server = pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
BENCH = ("-m", "tools.bench", "--live", "--seconds", "1", "--rounds", "1")


def row(callback, lost_percent, loaded=True):
    return LoadRow(callback, loaded, 1.0, 2.0, 3.0, 100, 0, 0, lost_percent, 0.0, 0.0)


def test_the_ratio_of_frames_lost_is_pythons_over_natives():
    rows = [row("native", 9.0, loaded=False), row("native", 0.1), row("python", 40.0)]
    assert lost_ratio(rows, 60.0) == (pytest.approx(400.0), False)


def test_where_native_lost_nothing_the_ratio_is_a_lower_bound_by_one_block():
    rows = [row("native", -0.001), row("python", 40.0)]
    block = 100.0 * 256 / (48_000 * 60.0)
    assert lost_ratio(rows, 60.0) == (pytest.approx(40.0 / block), True)


def test_a_python_callback_that_lost_nothing_has_ratio_0():
    assert lost_ratio([row("native", 0.0), row("python", -0.002)], 60.0)[0] == 0.0


def test_what_belongs_to_live_is_refused_without_it():
    done = CliRunner().invoke(command, ["--device", "system"])
    assert done.exit_code == 2
    assert "--device belongs to --live" in done.output


@pytest.mark.realtime
@needs_server
def test_no_such_output_gives_a_one_line_error():
    with jack_server.Server(period=256) as server:
        done = server.attempt(*BENCH, "--device", "nowhere")
    assert done.returncode == 2
    assert done.stdout == ""
    lines = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1
    assert "nowhere" in lines[0]
    assert "Traceback" not in done.stderr


@pytest.mark.realtime
@needs_server
def test_the_live_bench_reports_every_row_and_block_size():
    with jack_server.Server(period=256) as server:
        report = json.loads(server.python(*BENCH, "--device", "system", "--json", timeout=300))
    assert [(cell["callback"], cell["loaded"]) for cell in report["load"]] == list(LOAD_CASES)
    assert [found["block_size"] for found in report["latency"]] == list(BLOCKS)
    assert [(row["screen"], row["moving"]) for row in report["sessions"]] == list(SESSIONS)
    headless, idle, moving = report["sessions"]
    assert headless["cpu_percent"] > 0.0
    assert idle["kb_a_second"] < moving["kb_a_second"] < 20.0
    for cell in report["load"]:
        assert cell["callbacks"] > 0
        assert 0.0 < cell["p50_us"] <= cell["p99_us"]
        assert cell["lost_low"] <= cell["lost_percent"] <= cell["lost_high"] < 100.0
    for found in report["latency"]:
        assert found["taps"] >= 1
        assert found["beyond"] == 0
        assert 0.0 < found["median_ms"] <= found["worst_ms"]
