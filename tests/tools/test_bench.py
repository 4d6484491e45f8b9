"""The other ways to do the same work do it: their results, and how they are timed and shown."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict

import numpy as np
import pytest
from click.testing import CliRunner

from overview_dsp.design.presets.library import load_preset
from overview_dsp.kernels import layout
from overview_dsp.measure import bench as speeds
from overview_dsp.measure.bench import RATE, Contender, prepared, reset_and_feed, run_in_turn
from tests.cli.running import overview
from tests.examples import preset_with
from tools.bench import c_rows, programs, solvers
from tools.bench.__main__ import command
from tools.bench.building import PEERS, MissingError, built
from tools.bench.disk import Disk, disk_alone
from tools.bench.picture import draw
from tools.bench.plain_settings import plain_scene, plain_settings
from tools.bench.report import Report, lines
from tools.bench.scaling import Cost, Memory
from tools.bench.table_sizes import TableOf

NEAR = 1e-9
"""Of the highest torque."""

NEAR_GOALS = 1e-6
"""The same: at the edge of a goal as narrow as football's two ways to round part a little."""


@pytest.fixture(scope="module")
def engine():
    return prepared()


@pytest.fixture(scope="module")
def disk(engine):
    return Disk.of(engine)


@pytest.fixture(scope="module")
def torque(engine, disk):
    return disk_alone(engine, disk)


@pytest.fixture(scope="module")
def wide():
    """An engine on wide ridges, its disk and the disk's torque."""
    engine = prepared(preset=preset_with(height=20.0, width=1.0))
    disk = Disk.of(engine)
    return engine, disk, disk_alone(engine, disk)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    try:
        return built(PEERS / "plain_voice.c", c_rows.PLAIN, tmp_path_factory.mktemp("c"))
    except MissingError as missing:
        pytest.skip(f"needs a C compiler: {missing}")


@pytest.fixture(scope="module")
def plain(engine, disk, library):
    return c_rows.PlainC(library, disk, plain_settings(engine))


def test_the_disk_alone_is_the_disk_of_a_python_loop(disk, torque):
    expected = solvers.plain_loop(disk, 5_000)
    assert np.allclose(torque[:5_000], expected, rtol=1e-9, atol=1e-12)
    assert np.abs(torque).max() > 0.01


def test_the_disk_on_a_coarser_table_makes_the_same_movement(engine, disk, torque, wide):
    assert np.array_equal(TableOf(layout.CELLS, engine, disk).torque(), torque)
    # a goal of 11 cells is lost on a coarser table, what is wider is not
    engine, disk, torque = wide
    coarser = TableOf(16_384, engine, disk).torque()
    assert (coarser - torque).std() < 1e-3 * torque.std()


def test_the_textbook_disk_in_c_is_ours(plain, torque, wide, library):
    assert np.abs(plain.torque() - torque).max() < NEAR_GOALS * np.abs(torque).max()
    engine, disk, torque = wide
    found = c_rows.PlainC(library, disk, plain_settings(engine)).torque()
    assert np.abs(found - torque).max() < NEAR * np.abs(torque).max()


def test_the_textbook_voice_in_c_sounds_like_ours(plain):
    frames = 4 * RATE
    ours_, theirs = np.zeros((2, frames, 2), dtype=np.float32)
    # it has neither a clutch nor gains for slow hands and the recoil
    without = ("clutch.max_speed_ratio", "tactor.slow_gain_exponent", "tactor.recoil_gain_exponent")
    engine = prepared(preset=load_preset("football").with_changes(dict.fromkeys(without, 0.0)))
    reset_and_feed(engine).process(ours_)
    plain.voice(plain_scene(engine), *c_rows.sweep_input(frames), theirs)
    level = 20.0 * np.log10(theirs.std(axis=0) / ours_.std(axis=0))
    assert np.abs(level).max() < 0.5
    assert np.corrcoef(ours_[:, 1], theirs[:, 1])[0, 1] > 0.99


@pytest.mark.parametrize("build", programs.BUILDS)
def test_the_disk_in_faust_is_ours(wide, build):
    if not shutil.which("faust"):
        pytest.skip("needs Faust: apt-get install faust")
    engine, disk, torque = wide
    found = np.empty(len(torque))
    programs.FaustPeer("disk_alone", programs.BUILDS[build], engine).run([disk.angles], [found])
    assert np.abs(found - torque).max() < NEAR * np.abs(torque).max()


def test_a_solver_comes_closer_the_tighter_it_is_held(disk):
    reference = solvers.solved(disk, "DOP853", 1e-10)
    loose, tight = (
        solvers.error(solvers.solved(disk, "RK45", tolerance), reference)
        for tolerance in (1e-4, 1e-8)
    )
    assert tight < 0.01 * loose
    tolerance, error = solvers.loosest(disk, "RK45", reference, loose)
    assert tolerance >= 1e-4
    assert error <= loose


def test_ratios_are_taken_round_by_round():
    speeds = iter([0.0, 0.0, 100.0, 50.0, 10.0, 5.0, 20.0, 10.0])
    contenders = [
        Contender("a group", "ours", lambda: next(speeds)),
        Contender("a group", "theirs", lambda: next(speeds)),
    ]
    first, second = run_in_turn(contenders, 3)
    assert (first.speed, first.low, first.high) == (20.0, 10.0, 100.0)
    assert (second.ratio, second.ratio_low, second.ratio_high) == (0.5, 0.5, 0.5)


@pytest.fixture
def report():
    contenders = [Contender("a group", name, lambda: 2.0) for name in ("overView", "theirs")]
    costs = [Cost("events", "100000 events", 1.5, 1.4, 1.6, 16_384)]
    rows = run_in_turn(contenders, 2)
    return Report(2, rows, 3.0, costs, Memory(300.0, 60.0, 301.0), ["Faust is not installed"])


def test_the_table_says_what_was_merged_and_what_was_left_out(report):
    text = "\n".join(lines(report))
    assert "merged to 16384 strikes" in text
    assert "left out: Faust is not installed" in text
    assert "301 MB after a stream of 60 s" in text
    json.dumps(asdict(report), allow_nan=False)


def test_the_speeds_are_drawn(report, tmp_path):
    draw(report, tmp_path / "speeds.png")
    assert (tmp_path / "speeds.png").read_bytes().startswith(b"\x89PNG")


def test_the_bench_of_a_clone_says_what_it_does_and_refuses_a_picture_that_cannot_be_written(
    tmp_path,
):
    shown = CliRunner().invoke(command, ["--help"])
    assert shown.exit_code == 0
    assert "Example: python -m tools.bench" in shown.output
    outcome = CliRunner().invoke(command, ["--plot", str(tmp_path / "none" / "x.png")])
    assert outcome.exit_code == 2
    assert "folder" in outcome.output
    assert len(outcome.output.splitlines()) == 1


def test_the_command_measures_the_engines_own_rows_alone(monkeypatch):
    rows = [Contender(group, "overView, one call", lambda: 2.0) for group in ("one", "two")]
    monkeypatch.setattr(speeds, "contenders", lambda: rows)
    found = json.loads(overview("bench", "--rounds", "2", "--json").out)
    assert found["rounds"] == 2
    assert [(row["group"], row["speed"], row["ratio"]) for row in found["rows"]] == [
        ("one", 2.0, 1.0),
        ("two", 2.0, 1.0),
    ]
    text = overview("bench", "--rounds", "1").out
    assert found["machine"] in text
    assert "medians of 1 interleaved rounds" in text


def test_what_belongs_to_live_is_refused_without_it(tmp_path):
    for words in (["--device", "system"], ["--live", "--plot", str(tmp_path / "x.png")]):
        outcome = CliRunner().invoke(command, words)
        assert outcome.exit_code == 2
        assert "--device belongs to --live, and --plot does not" in outcome.output
