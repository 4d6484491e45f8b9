"""ECG and pulse waves as tables: made-up ones with every quirk, and other people's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.make_cardiac import agreement, beat_times, ecg
from tests.data.readers.make_noise import electrode_noise
from tests.data.readers.outcome import timeline_or_one_line

SECONDS = 20.0
RATE = 250.0
BEATS = beat_times(SECONDS)
LEAD = ecg(BEATS, SECONDS, RATE)
TIMES = np.arange(len(LEAD)) / RATE


def beats_of(timeline: Timeline) -> Any:
    return np.array([event.time_s for event in timeline.events if event.kind != "missed_beat"])


def write(folder: Path, lines: list[str], name: str = "lead.csv", encoding: str = "utf-8") -> Path:
    (folder / name).write_text("\n".join(lines) + "\n", encoding=encoding)
    return folder / name


def refused(path: Path, words: str, **options: Any) -> None:
    with pytest.raises(InputError, match=words) as caught:
        load_timeline(path, **options)
    assert "\n" not in str(caught.value)


def test_bare_samples_with_a_rate_have_their_beats_found(tmp_path: Path) -> None:
    timeline = load_timeline(write(tmp_path, [f"{v:.4f}" for v in LEAD]), rate=RATE)
    assert agreement(beats_of(timeline), BEATS) == (1.0, 1.0)
    assert timeline.duration_s == SECONDS
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "bpm"
    assert timeline.title == "lead"


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize(
    ("header", "scale"),
    [("time_s", 1.0), ("time (ms)", 1e3), ("timestamp_us", 1e6), ("t", 1.0), ("time", 1e3)],
)
def test_a_column_of_times_gives_the_rate(
    tmp_path: Path, separator: str, header: str, scale: float
) -> None:
    name = header.replace(" ", "_") if separator == " " else header
    rows = [f"{t * scale:.6g}{separator}{v:.4f}" for t, v in zip(TIMES, LEAD, strict=True)]
    path = write(tmp_path, [f"{name}{separator}ecg", *rows])
    timeline = load_timeline(path)
    assert agreement(beats_of(timeline), BEATS) == (1.0, 1.0)
    assert timeline.duration_s == pytest.approx(SECONDS, rel=1e-4)


def test_decimal_commas_byte_order_marks_and_comments_are_read(tmp_path: Path) -> None:
    rows = [f"{t:.3f};{v:.4f}".replace(".", ",") for t, v in zip(TIMES, LEAD, strict=True)]
    path = write(tmp_path, ["# Gerät 7", "Zeit;EKG", *rows], encoding="utf-8-sig")
    assert agreement(beats_of(load_timeline(path)), BEATS) == (1.0, 1.0)


def test_clock_times_and_dates_are_read_and_the_first_date_kept(tmp_path: Path) -> None:
    clocks = [f"[{int(t // 60)}:{t % 60:06.3f}],{v:.4f}" for t, v in zip(TIMES, LEAD, strict=True)]
    assert agreement(beats_of(load_timeline(write(tmp_path, ["time,MLII", *clocks]))), BEATS) == (
        1.0,
        1.0,
    )
    start = np.datetime64("2024-03-01T10:00:00.000000")
    stamps = start + (TIMES * 1e6).astype("timedelta64[us]")
    rows = [f"{stamp},{v:.4f}" for stamp, v in zip(stamps, LEAD, strict=True)]
    timeline = load_timeline(write(tmp_path, ["date,ecg", *rows]))
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-03-01T10:00:00"
    assert agreement(beats_of(timeline), BEATS) == (1.0, 1.0)


def test_the_signal_is_chosen_by_name_number_or_by_being_the_only_one(tmp_path: Path) -> None:
    rows = [f"{i},{0.1 * v:.4f},{v:.4f}" for i, v in enumerate(LEAD)]
    path = write(tmp_path, ["sample,temperature,chest", *rows])
    for value in ("chest", "3"):
        timeline = load_timeline(path, rate=RATE, value=value)
        assert timeline.provenance.startswith("ECG, chest at 250 Hz")
    refused(path, "2 columns may be the signal: temperature, chest; choose one", rate=RATE)
    refused(path, "no column of samples is called 'back'; available: ", rate=RATE, value="back")
    named = write(tmp_path, ["sample,temperature,ecg", *rows], "named.csv")
    assert "ecg at" in load_timeline(named, rate=RATE).provenance


def test_samples_called_ecg_without_times_ask_for_the_rate(tmp_path: Path) -> None:
    refused(
        write(tmp_path, ["ecg", *(f"{v:.4f}" for v in LEAD)]), "has no times; set the option rate"
    )


def test_missing_samples_and_a_lead_that_is_off_are_gaps(tmp_path: Path) -> None:
    entries = [f"{v:.4f}" for v in LEAD]
    entries[1000:1500] = ["NaN"] * 500
    entries[3000:4000] = ["-1"] * 1000
    timeline = load_timeline(write(tmp_path, entries), rate=RATE)
    assert timeline.gaps == ((4.0, 6.0), (12.0, 16.0))
    assert not any(start < t < end for t in beats_of(timeline) for start, end in timeline.gaps)


def test_a_hole_between_the_times_is_a_gap(tmp_path: Path) -> None:
    rows = [f"{t:.3f},{v:.4f}" for t, v in zip(TIMES, LEAD, strict=True) if not 8.0 <= t < 11.0]
    timeline = load_timeline(write(tmp_path, ["time,ecg", *rows]))
    ((start, end),) = timeline.gaps
    assert (start, end) == (pytest.approx(8.0, abs=0.01), pytest.approx(11.0, abs=0.01))
    assert timeline.duration_s == pytest.approx(SECONDS, abs=0.01)
    kept = BEATS[(BEATS < 7.95) | (BEATS > 11.05)]
    assert min(agreement(beats_of(timeline), kept)) >= 0.95


def test_times_in_whole_milliseconds_give_the_mean_rate(tmp_path: Path) -> None:
    lead = ecg(BEATS, SECONDS, 360.0)
    rows = [f"{round(i / 0.36)},{v:.4f}" for i, v in enumerate(lead)]
    timeline = load_timeline(write(tmp_path, ["time [ms],ecg", *rows]))
    assert timeline.gaps == ()
    assert agreement(beats_of(timeline), BEATS) == (1.0, 1.0)
    assert timeline.duration_s == pytest.approx(SECONDS, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda rows: [*rows[:100], "1.0,oops", *rows[100:]], "line 102.*oops"),
        (
            lambda rows: [*rows[:100], "0.1,1.0", *rows[100:]],
            "row 101 .* before that in the previous row",
        ),
        (lambda rows: [*rows[:100], "", "9.9", *rows[100:]], "line 103"),
    ],
)
def test_a_broken_row_gives_a_one_line_error_that_names_it(
    tmp_path: Path, change: Any, words: str
) -> None:
    rows = [f"{t:.3f},{v:.4f}" for t, v in zip(TIMES, LEAD, strict=True)]
    refused(write(tmp_path, ["time,ecg", *change(rows)]), words)


def test_unsuitable_heart_tables_give_a_one_line_error(tmp_path: Path) -> None:
    flat = write(tmp_path, ["1.0"] * 5000)
    refused(flat, "no heartbeat was found", rate=RATE)
    lead = write(tmp_path, [f"{v:.4f}" for v in LEAD], "lead2.csv")
    refused(lead, "more than the", rate=RATE, max_mb=0.01)
    refused(lead, "the rate is 200000 Hz; must be 50 to 100000", rate=200_000.0)


def test_a_series_of_heart_rates_is_no_signal(tmp_path: Path) -> None:
    rows = [f"2024-01-{day:02d},{60 + day % 7}" for day in range(1, 29)]
    path = write(tmp_path, ["date,heart_rate", *rows])
    timeline = timeline_or_one_line(lambda: load_timeline(path))
    assert timeline is None or "beat" not in timeline.kinds()


def test_a_table_with_words_in_it_is_no_hearts_whatever_the_rate(tmp_path: Path) -> None:
    rows = [f"AAPL,{v:.4f}" for v in LEAD]
    timeline = load_timeline(write(tmp_path, ["ticker,level", *rows]), rate=RATE)
    assert "beat" not in timeline.kinds()
    assert timeline.provenance.startswith("a CSV table, column 'level'")


def test_a_noisy_stretch_is_a_gap_that_says_why(tmp_path: Path) -> None:
    noisy = ecg(beat_times(90.0), 90.0, RATE)
    second = round(RATE)
    middle = slice(30 * second, 50 * second)
    noisy[middle] += electrode_noise(20.0, RATE, 1)
    noisy[-4 * second :] = 0.0
    timeline = load_timeline(write(tmp_path, [f"{v:.4f}" for v in noisy]), rate=RATE)
    assert timeline.gap_reasons == ("too noisy to find beats", "no signal")
    (start, end), silent = timeline.gaps
    assert 24.0 < start < 34.0
    assert 46.0 < end < 56.0
    assert silent == (86.0, 90.0)
    assert not any(start < event.time_s < end for event in timeline.events)
    assert any("too noisy to find beats, which makes gaps" in note for note in timeline.notes)


def test_noise_alone_gives_a_one_line_error_that_says_so(tmp_path: Path) -> None:
    samples = electrode_noise(60.0, RATE, 5)
    path = write(tmp_path, [f"{v:.4f}" for v in samples])
    refused(path, r"no heartbeat was found \(\d+ s of it are too noisy to find beats\)", rate=RATE)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_damage_ends_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject
) -> None:
    rows = [f"{t:.3f},{v:.3f}" for t, v in zip(TIMES[:1500], LEAD[:1500], strict=True)]
    text = "\n".join(["time,ecg", *rows]) + "\n"
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, min(len(text), 400)) | st.integers(0, len(text)))
        put = data.draw(
            st.sampled_from(["", "\n", ",", ";", "nan", "-", "1e300", "inf", '"', "\0", "9" * 400])
            | st.text(max_size=3)
        )
        text = text[:at] + put + text[at + data.draw(st.integers(0, 2000)) :]
    path = tmp_path / "damaged.csv"
    path.write_text(text, encoding="utf-8")
    rate = data.draw(st.none() | st.sampled_from([60.0, 250.0, 5e4]))
    timeline_or_one_line(lambda: load_timeline(path, rate=rate))


# --- other people's tables -------------------------------------------------------------------


def test_the_noisy_ecg_has_its_annotated_beats(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "ecg" / "118e24.csv", rate=360.0)
    told = np.loadtxt(data_folder / "ecg" / "118e24_ann.csv", delimiter=",") / 360.0
    sensitivity, precision = agreement(beats_of(timeline), np.ravel(told))
    assert min(sensitivity, precision) >= 0.99
    assert timeline.duration_s == 120.0


def test_the_european_ecg_has_its_mean_rate(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "ecg" / "e0103.csv", rate=250.0)
    assert timeline.duration_s == 120.0
    intervals = np.diff(beats_of(timeline)) * 1000.0
    assert 60_000.0 / intervals.mean() == pytest.approx(59.697, abs=0.2)
    assert intervals.mean() == pytest.approx(1005.08, abs=3.0)


def test_a_ppg_recording_is_read_as_a_pulse_wave(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "ecg" / "heartpy_data_ppg_100hz.csv", rate=100.0)
    assert timeline.provenance.startswith("pulse wave")
    assert timeline.duration_s == pytest.approx(24.83)
    assert 20 <= len(beats_of(timeline)) <= 40


def test_a_hole_between_the_times_leaves_the_rate_as_it_is(tmp_path: Path) -> None:
    rows = [f"{t:.3f},{v:.4f}" for t, v in zip(TIMES, LEAD, strict=True) if not 8.0 <= t < 11.0]
    timeline = load_timeline(write(tmp_path, ["time,ecg", *rows]))
    assert "at 250 Hz" in timeline.provenance
