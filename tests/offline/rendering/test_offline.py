from __future__ import annotations

import csv
import math
import os
import subprocess
import sys
import textwrap
import warnings
from pathlib import Path

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.kernels.layout import CELLS, TRACE_COLUMNS
from overview_dsp.kernels.motion import NEAR_REST
from overview_dsp.offline.rendering import offline, schedule
from tests.examples import preset_with, timeline_of

RATE = 8000
TIMELINE = timeline_of(5.0, 30.0, 31.0, 62.5, 90.0)
PRESET = preset_with(height=30.0, width=1.0)
GESTURE = ov.sweep(0.3) + ov.pause(0.2) + ov.tap(0.7, 0.15)


def equal(one: ov.RenderResult, other: ov.RenderResult) -> bool:
    if (one.trace is None) != (other.trace is None):
        return False
    same = np.array_equal(one.samples, other.samples)
    if one.trace is not None and other.trace is not None:
        same = same and all(np.array_equal(one.trace[c], other.trace[c]) for c in TRACE_COLUMNS)
    return same and all(
        np.array_equal(getattr(one.strikes, name), getattr(other.strikes, name))
        for name in ("time_s", "event", "torque", "level")
    )


# --- arrays --------------------------------------------------------------------------------------


def test_a_result_has_two_channels_a_trace_and_the_strikes():
    result = ov.render(TIMELINE, PRESET, GESTURE, RATE)
    frames = len(result.samples)
    assert result.samples.dtype == np.float32
    assert result.samples.shape == (frames, 2)
    assert result.sample_rate == RATE
    assert result.trace is not None
    assert tuple(result.trace) == TRACE_COLUMNS
    for name in TRACE_COLUMNS:
        column = result.trace[name]
        assert column.dtype == np.float64
        assert column.shape == (frames,)
        assert np.isfinite(column).all()
        assert column is getattr(result.trace, name)
    assert np.allclose(result.trace.time, np.arange(1, frames + 1) / RATE)
    # there and back; the tap takes the disk on its way to the sweep's end, which it doesn't reach
    assert result.strikes.event.tolist() == [0, 1, 2, 3, 4, 3, 2, 1, 0]
    assert (np.diff(result.strikes.time_s) > 0.0).all()


def test_the_trace_is_optional_and_changes_no_bit():
    with_trace = ov.render(TIMELINE, PRESET, GESTURE, RATE)
    without = ov.render(TIMELINE, PRESET, GESTURE, RATE, trace=False)
    assert without.trace is None
    assert np.array_equal(with_trace.samples, without.samples)


def test_an_unknown_column_is_a_key_error():
    result = ov.render(TIMELINE, PRESET, ov.tap(0.1, 0.01), RATE, tail="none")
    assert result.trace is not None
    with pytest.raises(KeyError):
        result.trace["omega2"]


def test_the_same_arguments_give_the_same_bits_and_another_seed_another_grain():
    def rendered(seed: int) -> ov.RenderResult:
        preset = PRESET.with_values(texture__gain_db=0.0)
        return ov.render(TIMELINE, preset, GESTURE, RATE, seed)

    one, other = rendered(3), rendered(4)
    assert equal(one, rendered(3))
    frames = min(len(one.samples), len(other.samples))
    assert not np.array_equal(one.samples[:frames, 0], other.samples[:frames, 0])
    assert np.array_equal(one.samples[:frames, 1], other.samples[:frames, 1])


def test_no_peak_passes_the_ceiling_and_the_end_is_exact_silence(match, football):
    result = ov.render(match, football, ov.sweep(0.3), RATE, trace=False)
    assert np.abs(result.samples).max() <= 10.0 ** (-1.0 / 20.0)
    assert not result.samples[-round(schedule.REST_S * RATE) :].any()


# --- tails ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("tail", [0.0, 0.25, 1])
def test_a_tail_in_seconds_is_exact(tail):
    bare = ov.render(TIMELINE, PRESET, GESTURE, RATE, tail="none", trace=False)
    result = ov.render(TIMELINE, PRESET, GESTURE, RATE, tail=tail, trace=False)
    assert len(result.samples) == len(bare.samples) + round(tail * RATE)
    assert np.array_equal(result.samples[: len(bare.samples)], bare.samples)


def test_without_a_tail_the_render_stops_with_the_gesture():
    # the release has a frame of its own
    gesture = ov.tap(0.5, 0.1)
    result = ov.render(TIMELINE, PRESET, gesture, RATE, tail="none", trace=False)
    assert len(result.samples) == round(0.1 * RATE) + 1
    rest = gesture + ov.pause(0.1)
    result = ov.render(TIMELINE, PRESET, rest, RATE, tail="none", trace=False)
    assert len(result.samples) == round(0.2 * RATE)


def test_the_tail_ends_when_the_disk_has_rested_in_silence_and_no_frame_earlier():
    result = ov.render(TIMELINE, PRESET, GESTURE, RATE)
    longer = ov.render(TIMELINE, PRESET, GESTURE, RATE, tail=10.0)
    frames, quiet = len(result.samples), round(schedule.REST_S * RATE)
    assert np.array_equal(result.samples, longer.samples[:frames])
    assert not longer.samples[frames:].any()
    assert len(longer.strikes) == len(result.strikes)
    assert result.trace is not None
    active = result.samples.any(axis=1) | (np.abs(result.trace.cursor) * CELLS >= NEAR_REST)
    assert not active[-quiet:].any()
    assert active[-quiet - 1]


def test_a_gesture_that_ends_at_rest_is_rendered_to_its_end():
    gesture = ov.tap(0.3, 0.1) + ov.pause(8.0)
    result = ov.render(TIMELINE, PRESET, gesture, RATE, trace=False)
    assert not result.samples[-RATE:].any()
    assert len(result.samples) == round((8.1 + schedule.REST_S) * RATE)


def test_a_disk_that_does_not_settle_ends_the_render_after_thirty_seconds():
    slow = PRESET.with_values(disk__k1=1e-5, surface__friction=0.05)
    gesture = ov.tap(0.8, 0.1)
    result = ov.render(TIMELINE, slow, gesture, 2000, trace=False)
    assert len(result.samples) == round(0.1 * 2000) + 1 + 30 * 2000


def test_an_empty_gesture_is_an_empty_result():
    result = ov.render(TIMELINE, PRESET, ov.pause(0.0), RATE, tail="none")
    assert result.samples.shape == (0, 2)
    assert result.trace is not None
    assert result.trace.time.shape == (0,)
    assert len(result.strikes) == 0


@pytest.mark.parametrize("tail", [-1.0, math.nan, math.inf, 1e9, "soon", "", True])
def test_a_bad_tail_is_an_error_of_one_line_with_the_range(tail):
    with pytest.raises(ov.InputError, match=r"rest, none or seconds from 0 to 86400"):
        ov.render(TIMELINE, PRESET, GESTURE, RATE, tail=tail)
    if isinstance(tail, str):
        with pytest.raises(ov.InputError, match=r"rest, none or seconds from 0 to 86400"):
            schedule.tail_of(tail)


def test_a_tail_is_read_from_text():
    given = ["rest", "none", "0", "1.5"]
    assert [schedule.tail_of(text) for text in given] == ["rest", "none", 0.0, 1.5]


# --- blocks --------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1, 7, 64, 1000, 4095, 100_000])
def test_any_block_size_gives_the_same_bits_and_ends_at_the_same_frame(monkeypatch, size):
    gesture = ov.sweep(0.05, 0.0, 0.4)
    whole = ov.render(TIMELINE, PRESET, gesture, 2000)
    monkeypatch.setattr(offline, "BLOCK", size)
    assert equal(whole, ov.render(TIMELINE, PRESET, gesture, 2000))


def dense(times: np.ndarray) -> ov.Gesture:
    """A take with these event times that trembles on its way up, and lets go."""
    place = np.linspace(0.0, 2.0, len(times)) + 0.1 * np.sin(np.arange(len(times)))
    touching = np.ones(len(times), dtype=bool)
    touching[-1] = False
    return ov.Gesture(times, np.clip(place, 0.0, math.pi), touching, float(times[-1]))


def test_a_take_denser_than_the_engines_ring_loses_no_event(monkeypatch):
    # 12 000 events in less than a block
    gesture = dense(np.linspace(0.0, 0.4, 12_000))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = ov.render(TIMELINE, PRESET, gesture, RATE)
    assert result.engine.meters.dropped_events == 0
    assert result.engine.meters.late_events == 0
    monkeypatch.setattr(offline, "BLOCK", 50)
    assert equal(result, ov.render(TIMELINE, PRESET, gesture, RATE))


def test_ten_thousand_events_at_one_time_are_all_applied(monkeypatch):
    times = np.concatenate([np.full(10_000, 0.1), [0.2]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = ov.render(TIMELINE, PRESET, dense(times), RATE, tail="none")
    assert result.engine.meters.dropped_events == 0
    assert result.trace is not None
    # the last of them counts
    assert result.trace.theta2[-2] == pytest.approx(dense(times).theta2[-2], rel=1e-3)


# --- files ---------------------------------------------------------------------------------------


def test_a_file_holds_the_samples_of_render_bit_for_bit(tmp_path):
    result = ov.render(TIMELINE, PRESET, GESTURE, RATE, 5)
    done = ov.render_to_file(
        TIMELINE, PRESET, GESTURE, tmp_path / "a.wav", RATE, 5, subtype="FLOAT"
    )
    back, rate = soundfile.read(tmp_path / "a.wav", dtype="float32")
    assert rate == RATE
    assert np.array_equal(back, result.samples)
    assert done.duration_s == len(back) / RATE
    assert done.peaks == tuple(np.abs(back).max(axis=0).tolist())
    assert done.strikes == len(result.strikes)
    assert os.listdir(tmp_path) == ["a.wav"]


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24"])
def test_saving_a_result_and_rendering_to_a_file_give_the_same_file(tmp_path, subtype):
    ov.render(TIMELINE, PRESET, GESTURE, RATE).save(tmp_path / "a.wav", subtype)
    ov.render_to_file(TIMELINE, PRESET, GESTURE, tmp_path / "b.wav", RATE, subtype=subtype)
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()


@pytest.mark.parametrize("suffix", ["npz", "csv"])
def test_a_trace_file_holds_the_trace_of_render_bit_for_bit(tmp_path, suffix):
    result = ov.render(TIMELINE, PRESET, GESTURE, RATE)
    path = tmp_path / f"trace.{suffix}"
    ov.render_to_file(TIMELINE, PRESET, GESTURE, tmp_path / "a.wav", RATE, trace_path=path)
    assert result.trace is not None
    if suffix == "npz":
        with np.load(path) as archive:
            columns = {name: archive[name] for name in archive.files}
    else:
        with open(path, newline="") as file:
            rows = list(csv.reader(file))
        table = np.array(rows[1:], dtype=np.float64)
        columns = dict(zip(rows[0], table.T, strict=True))
    assert tuple(columns) == TRACE_COLUMNS
    for name in TRACE_COLUMNS:
        assert np.array_equal(columns[name], result.trace[name])


def test_the_progress_goes_up_to_one(tmp_path):
    told: list[float] = []
    ov.render_to_file(
        TIMELINE, PRESET, ov.sweep(3.0), tmp_path / "a.wav", RATE, progress=told.append
    )
    assert told == sorted(told)
    assert 0.0 < told[0] < 0.5
    assert told[-1] == 1.0


@pytest.mark.parametrize("suffix", ["npz", "csv"])
def test_a_disk_that_fills_up_with_the_last_bytes_leaves_neither_file(
    tmp_path, monkeypatch, suffix
):
    close = soundfile.SoundFile.close

    def fail(file: soundfile.SoundFile) -> None:
        # libsndfile writes what it holds back when it closes
        was_open = not file.closed
        close(file)
        if was_open:
            raise soundfile.LibsndfileError(2)

    monkeypatch.setattr(soundfile.SoundFile, "close", fail)

    with pytest.raises(ov.OutputError, match=r"a\.wav: the disk is full or broken"):
        ov.render_to_file(
            TIMELINE,
            PRESET,
            GESTURE,
            tmp_path / "a.wav",
            RATE,
            trace_path=tmp_path / f"a.{suffix}",
        )
    monkeypatch.undo()
    assert os.listdir(tmp_path) == []


def test_an_exception_in_the_progress_callback_leaves_no_file(tmp_path):
    def stop(part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ov.render_to_file(
            TIMELINE,
            PRESET,
            GESTURE,
            tmp_path / "a.wav",
            RATE,
            trace_path=tmp_path / "a.npz",
            progress=stop,
        )
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("path", "trace", "rate", "tail"),
    [
        ("a.wav", "no/a.npz", RATE, "rest"),
        ("a.wav", "a.txt", RATE, "rest"),
        ("a.xyz", "a.npz", RATE, "rest"),
        ("no/a.wav", "a.csv", RATE, "rest"),
        ("a.wav", "a.csv", 8000.5, "rest"),
        ("a.wav", "a.csv", 1.0, "rest"),
        ("a.wav", "a.csv", RATE, -1.0),
        ("a.htk", "a.npz", RATE, "rest"),
    ],
)
def test_if_one_of_two_files_cannot_be_written_neither_is(tmp_path, path, trace, rate, tail):
    with pytest.raises(ov.InputError):
        ov.render_to_file(
            TIMELINE,
            PRESET,
            GESTURE,
            tmp_path / path,
            rate,
            tail=tail,
            trace_path=tmp_path / trace,
        )
    assert os.listdir(tmp_path) == []


# --- memory --------------------------------------------------------------------------------------

MEMORY = """
import resource, sys
import overview_dsp as ov

folder, rate, limit = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
timeline, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")

def peak_mb():
    try:
        # getrusage begins with the peak of the process that started this one
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024
    except OSError:
        pass
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2.0**20 if sys.platform == "darwin" else 2.0**10)

def render(seconds, trace):
    ov.render_to_file(timeline, preset, ov.sweep(seconds), f"{folder}/a.wav", rate, tail=0.0,
                      trace_path=f"{folder}/a.{trace}" if trace else None)

for one in sys.argv[4:]:
    trace, seconds = one.split(":")
    render(2.0, trace)
    short = peak_mb()
    render(float(seconds), trace)
    long = peak_mb()
    print(f"trace {trace!r}: {short:.1f} MB after 2 s, {long:.1f} MB after {seconds} s")
    if long >= limit or (limit >= 1e6 and long - short >= 12.0):
        sys.exit(1)
"""


def memory(folder: Path, rate: int, limit_mb: float, *traces: str) -> None:
    """Render with these traces (`npz:120`, its length in seconds), one process for all."""
    pytest.importorskip("resource")
    # compiled beforehand: compiling takes more memory than rendering
    ov.render(TIMELINE, PRESET, ov.tap(0.1, 0.01), rate, tail="none", trace=True)
    done = subprocess.run(
        [
            *(sys.executable, "-c", textwrap.dedent(MEMORY), str(folder)),
            *(str(rate), str(limit_mb), *traces),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_memory_does_not_grow_with_length(tmp_path):
    # of sound alone 15 MB, of a trace 30 and more
    memory(tmp_path, RATE, 1e9, ":240", "npz:60", "csv:30")


@pytest.mark.soak
@pytest.mark.parametrize("trace", ["", "npz"])
def test_an_hours_gesture_takes_less_than_400_mb(tmp_path, trace):
    memory(tmp_path, 48_000, 400.0, f"{trace}:3600")
