from __future__ import annotations

import os
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from overview_dsp import installation
from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.cardiac.wfdb_header import looks_like_header, parse_header
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.make_cardiac import (
    agreement,
    annotate,
    beat_times,
    ecg,
    pulse_wave,
    write_record,
)
from tests.data.readers.outcome import timeline_or_one_line

pytest.importorskip("wfdb", reason="needs the extra [ecg]")

HYPOTHESIS = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
SECONDS = 30.0
RATE = 250.0


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """The header of a record of two signals without annotations."""
    leads = {name: ecg(beat_times(SECONDS), SECONDS, RATE, seed=s) for s, name in enumerate("ab")}
    return write_record(tmp_path, {"V1": leads["a"], "MLII": leads["b"]}, RATE)


def beats_of(timeline: Timeline) -> Any:
    other = ("missed_beat", "rhythm", "signal_quality")
    return np.array([event.time_s for event in timeline.events if event.kind not in other])


def refused(path: Path, words: str, **options: Any) -> str:
    with pytest.raises(InputError, match=words) as caught:
        load_timeline(path, **options)
    text = str(caught.value)
    assert text.count("\n") <= 1  # the second line: what it comes nearest to
    return text


# --- what a record becomes -------------------------------------------------------------------


def test_a_record_without_annotations_has_its_beats_found(record: Path) -> None:
    timeline = load_timeline(record)
    assert timeline.title == "made_up"
    assert timeline.duration_s == SECONDS
    assert agreement(beats_of(timeline), beat_times(SECONDS)) == (1.0, 1.0)
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "bpm"
    assert timeline.intensity_at(15.0) == pytest.approx(70.0, abs=2.0)
    assert "MLII at 250 Hz" in timeline.provenance
    assert "found in MLII (ECG)" in timeline.provenance
    assert timeline.notes[0].startswith(f"{len(beat_times(SECONDS))} beats, mean heart rate ")


def test_every_file_of_a_record_stands_for_it(record: Path) -> None:
    whole = load_timeline(record)
    assert load_timeline(record.with_suffix(".dat")) == whole
    noted = annotate(record, [100, 300], ["N", "V"])
    told = load_timeline(record)
    assert told.kinds() == {"beat": 1, "premature_ventricular": 1}
    assert load_timeline(noted) == told
    assert load_timeline(record.with_suffix(".dat")) == told


def test_a_file_of_another_kind_beside_a_record_is_not_the_record(record: Path) -> None:
    np.save(record.with_suffix(".npy"), np.arange(50.0) % 7.0)
    assert load_timeline(record.with_suffix(".npy"), rate=10.0).duration_s == 4.9
    record.with_suffix(".wav").write_bytes(b"RIFF\x24\0\0\0WAVE")
    refused(record.with_suffix(".wav"), "made_up.wav: invalid or unknown audio file")


def test_an_annotation_file_that_is_given_outranks_the_usual_one(record: Path) -> None:
    annotate(record, [100, 300], ["N", "V"])
    other = annotate(record, [100, 300, 500], ["N", "N", "A"], "qrs")
    assert load_timeline(other).kinds() == {"beat": 2, "premature_atrial": 1}
    assert load_timeline(record).kinds() == {"beat": 1, "premature_ventricular": 1}


def test_kinds_and_words_of_annotations_are_kept(record: Path) -> None:
    import wfdb

    frames = np.arange(1, 9) * 200
    wfdb.wrann(
        "made_up",
        "atr",
        frames,
        symbol=["+", "N", "L", "A", "V", "~", "x", "p"],
        aux_note=["(AFIB", "", "", "", "", "", "", ""],
        write_dir=str(record.parent),
    )
    timeline = load_timeline(record)
    assert timeline.kinds() == {
        "rhythm": 1,
        "beat": 1,
        "bundle_branch_block": 1,
        "premature_atrial": 1,
        "premature_ventricular": 1,
        "signal_quality": 1,
        "blocked_atrial": 1,
    }
    assert timeline.events[0].label == "rhythm (AFIB"
    assert [event.time_s for event in timeline.events] == [i * 200 / 250 for i in range(1, 8)]
    assert "1 annotations of waves and measurements were omitted" in timeline.notes


def test_annotations_without_beats_leave_the_search_to_the_detector(record: Path) -> None:
    annotate(record, [10], ["+"])
    timeline = load_timeline(record)
    assert timeline.kinds()["beat"] == len(beat_times(SECONDS))
    assert timeline.kinds()["rhythm"] == 1
    assert any("has no beats" in note for note in timeline.notes)


def test_annotations_beyond_the_end_are_left_out_and_noted(record: Path) -> None:
    annotate(record, [100, 300, 99_999], ["N", "N", "N"])
    timeline = load_timeline(record)
    assert timeline.kinds() == {"beat": 2}
    assert any("after the end" in note for note in timeline.notes)


def test_a_signal_is_chosen_by_name_or_number(record: Path) -> None:
    assert "V1 at" in load_timeline(record, value="v1").provenance
    assert "V1 at" in load_timeline(record, value="1").provenance
    refused(record, "no signal is called 'V9'; available: V1, MLII", value="V9")


def test_map_chooses_rate_or_variability(record: Path) -> None:
    timeline = load_timeline(record, map="variability")
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "ms"
    refused(record, "map is 'level'; must be one of rate, variability for a heart", map="level")


def test_missing_and_flat_stretches_are_gaps(tmp_path: Path) -> None:
    lead = ecg(beat_times(60.0), 60.0, RATE)
    lead[round(10 * RATE) : round(14 * RATE)] = np.nan
    lead[round(30 * RATE) : round(40 * RATE)] = -1.0
    timeline = load_timeline(write_record(tmp_path, {"II": lead}, RATE))
    assert timeline.gaps == ((10.0, 14.0), (30.0, 40.0))
    assert "missed_beat" not in timeline.kinds()
    assert timeline.intensity_at([12.0, 35.0]).tolist() == [0.0, 0.0]
    assert timeline.intensity_at(20.0) == pytest.approx(70.0, abs=3.0)


def test_a_missed_beat_is_an_event(tmp_path: Path) -> None:
    beats = beat_times(60.0)
    lead = ecg(np.delete(beats, 30), 60.0, RATE)
    timeline = load_timeline(write_record(tmp_path, {"II": lead}, RATE))
    assert timeline.event("missed_beat", 1).time_s == pytest.approx(beats[30], abs=0.1)
    assert timeline.kinds()["missed_beat"] == 1


@pytest.mark.parametrize("fmt", ["16", "24", "32", "80", "212", "508", "516", "524"])
def test_every_storage_format_gives_the_same_beats(fmt: str, tmp_path: Path) -> None:
    lead = ecg(beat_times(SECONDS), SECONDS, RATE)
    header = write_record(tmp_path, {"II": lead, "V2": 0.5 * lead}, RATE, fmt)
    assert agreement(beats_of(load_timeline(header)), beat_times(SECONDS)) == (1.0, 1.0)


def raw_record(folder: Path, fmt: str, samples: Any, extra: bytes = b"") -> Path:
    """A record wfdb doesn't write: `samples` as they lie in the file."""
    (folder / "raw.dat").write_bytes(extra + samples.tobytes())
    offset = f"+{len(extra)}" if extra else ""
    (folder / "raw.hea").write_text(
        f"raw 1 {RATE:g} {round(SECONDS * RATE)}\nraw.dat {fmt}{offset} 100 12 0 0 0 0 ECG\n"
    )
    return folder / "raw.hea"


def test_three_samples_in_four_bytes_are_read(tmp_path: Path) -> None:
    lead = np.rint(100.0 * ecg(beat_times(SECONDS), SECONDS, RATE)).astype(np.int64) & 0x3FF
    one, two, three = lead.reshape(-1, 3).T
    pairs = np.stack(
        [(three & 0x1F) << 11 | one << 1, (three >> 5) << 11 | two << 1], axis=1
    ).astype("<u2")
    packed = (one | two << 10 | three << 20).astype("<u4")
    for fmt, samples in (("310", pairs), ("311", packed)):
        timeline = load_timeline(raw_record(tmp_path, fmt, samples))
        assert agreement(beats_of(timeline), beat_times(SECONDS)) == (1.0, 1.0)


def test_formats_61_and_160_and_offsets_are_read(tmp_path: Path) -> None:
    lead = np.rint(100.0 * ecg(beat_times(SECONDS), SECONDS, RATE))
    big = raw_record(tmp_path, "61", lead.astype(">i2"))
    assert agreement(beats_of(load_timeline(big)), beat_times(SECONDS)) == (1.0, 1.0)
    shifted = raw_record(tmp_path, "160", (lead + 32768).astype("<u2"), b"header")
    assert agreement(beats_of(load_timeline(shifted)), beat_times(SECONDS)) == (1.0, 1.0)


def test_several_samples_a_frame_count_for_the_rate(tmp_path: Path) -> None:
    lead = np.rint(100.0 * ecg(beat_times(SECONDS), SECONDS, 500.0)).astype("<i2")
    (tmp_path / "x.dat").write_bytes(lead.tobytes())
    (tmp_path / "x.hea").write_text(f"x 1 125 {len(lead) // 4}\nx.dat 16x4 100 16 0 0 0 0 II\n")
    timeline = load_timeline(tmp_path / "x.hea")
    assert "II at 500 Hz" in timeline.provenance
    assert timeline.duration_s == SECONDS
    assert agreement(beats_of(timeline), beat_times(SECONDS)) == (1.0, 1.0)


def test_a_header_without_a_length_takes_the_files(record: Path) -> None:
    text = record.read_text()
    record.write_text(text.replace(f" {round(SECONDS * RATE)}", "", 1))
    timeline = load_timeline(record)
    assert timeline.duration_s == SECONDS
    assert agreement(beats_of(timeline), beat_times(SECONDS)) == (1.0, 1.0)
    record.write_text(text.replace(f" {round(SECONDS * RATE)}", " 0", 1))
    refused(record, r"made_up\.hea: line 1: the length is 0 frames")


def test_the_pleth_of_a_record_without_ecg_is_a_pulse_wave(tmp_path: Path) -> None:
    signals = {
        "RESP": np.sin(np.arange(125 * 30) / 125.0),
        "PLETH": pulse_wave(beat_times(30.0), 30.0, 125.0) / 100.0,
    }
    timeline = load_timeline(write_record(tmp_path, signals, 125.0))
    assert "PLETH (pulse wave)" in timeline.provenance
    assert min(agreement(beats_of(timeline), beat_times(30.0))) >= 0.95


def test_the_start_of_a_record_is_kept(tmp_path: Path) -> None:
    lead = ecg(beat_times(SECONDS), SECONDS, RATE)
    header = write_record(
        tmp_path, {"II": lead}, RATE, base_datetime=datetime(1994, 5, 16, 12, 48, 46)
    )
    assert load_timeline(header).start == datetime(1994, 5, 16, 12, 48, 46)


def test_segments_follow_each_other_with_gaps_between(tmp_path: Path) -> None:
    beats = beat_times(90.0)
    lead = ecg(beats, 90.0, RATE)
    third = round(30 * RATE)
    write_record(tmp_path, {"II": lead[:third]}, RATE, name="one")
    write_record(tmp_path, {"V1": lead[:third], "II": lead[2 * third :]}, RATE, name="two")
    (tmp_path / "all.hea").write_text(
        f"all/4 2 {RATE:g} {3 * third}\nlayout 0\none {third}\n~ {third}\ntwo {third}\n"
    )
    (tmp_path / "layout.hea").write_text(f"layout 2 {RATE:g} 0\n~ 0 200 12 0 0 0 0 II\n~ 0\n")
    timeline = load_timeline(tmp_path / "all.hea")
    assert timeline.duration_s == 90.0
    assert timeline.gaps == ((30.0, 60.0),)
    kept = beats[(beats < 29.95) | (beats > 60.05)]
    assert min(agreement(beats_of(timeline), kept)) >= 0.97


def test_the_part_read_is_reported(record: Path) -> None:
    parts: list[float] = []
    load_timeline(record, progress=parts.append)
    assert parts[-1] == 1.0


def test_annotations_alone_make_a_timeline(tmp_path: Path) -> None:
    (tmp_path / "made_up.hea").write_text("made_up 0 250 7500\n")
    annotate(tmp_path / "made_up.hea", [100, 300, 500], ["N", "N", "V"])
    for name in ("made_up.hea", "made_up.atr"):
        timeline = load_timeline(tmp_path / name)
        assert timeline.kinds() == {"beat": 2, "premature_ventricular": 1}
        assert timeline.duration_s == 30.0
    (tmp_path / "made_up.atr").unlink()
    refused(tmp_path / "made_up.hea", "neither signals nor annotated beats")


# --- broken records --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    ["../../etc/passwd", "/etc/passwd", "..", "a/b.dat", "s3://x/y.dat", "C:\\x.dat", ".hidden/x"],
)
def test_a_signal_file_elsewhere_is_refused(name: str, record: Path) -> None:
    record.write_text(f"made_up 1 250 7500\n{name} 16 200 12 0 0 0 0 II\n")
    refused(record, r"made_up\.hea: line 2: the signal file is .*; must be a plain name")


def test_a_header_with_a_trillion_samples_gives_a_one_line_error(record: Path) -> None:
    record.write_text("made_up 1 250 1000000000000\nmade_up.dat 16 200 12 0 0 0 0 II\n")
    refused(record, r"made_up\.dat has \d+ bytes, but 1000000000000 frames require 2000000000000")
    record.write_text("made_up 1 250 1000000000000\nmade_up.dat 516 200 12 0 0 0 0 II\n")
    refused(record, "the signal has 1000000000000 samples; must be at most")
    record.write_text("made_up 1 250 1000000000000\n~ 0 200 12 0 0 0 0 II\n")
    refused(record, "the signal has 1000000000000 samples; must be at most")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("made_up 1 250 7500\n", "not a format that can be read"),
        (
            "made_up 2 250 7500\nmade_up.dat 16\n",
            "line 1 lists 2 signals, but 1 signal lines follow",
        ),
        ("made_up 1 250 7500\nmissing.dat 16\n", r"signal file missing\.dat cannot be opened"),
        ("made_up 1 0 7500\nmade_up.dat 16\n", "line 1: the rate is '0'; must be 0.001 to"),
        ("made_up 1 nan 7500\nmade_up.dat 16\n", "line 1: the rate is 'nan'"),
        ("made_up 1 250 7500\nmade_up.dat 16 x\n", "line 2: the gain is 'x'; must be a number"),
        ("made_up 1 250 7500\nmade_up.dat 16x0\n", "line 2: the samples per frame are 0"),
        ("made_up 1 10 7500\nmade_up.dat 16\n", "is 10 Hz; must be at least 50 to find beats"),
        ("made_up 9999 250 7500\nmade_up.dat 16\n", "number of signals is '9999'"),
        (
            "# c\n\nmade_up 2 250\nmade_up.dat 16\nmade_up.dat 212\n",
            "line 5: .*format 212; must be 16",
        ),
        (
            "made_up 1 250 7500 25:00:00 1/1/2000\nmade_up.dat 16\n",
            "line 1: the start is '25:00:00'",
        ),
        ("made_up 1 250 99999\nmade_up.dat 16\n", "the file is truncated or the header is wrong"),
        ("made_up/2 1 250 7500\na 10\n", "the header lists 2 segments, but 1 segment lines follow"),
        ("made_up/1 1 250 7500\nnone 7500\n", r"none\.hea: the header cannot be read"),
        (
            "made_up/1 1 250 7500\nmade_up 7500\n",
            "has segments; must be a record with signals|segments",
        ),
    ],
)
def test_a_broken_header_gives_a_one_line_error_that_names_the_line(
    text: str, words: str, record: Path
) -> None:
    record.write_text(text)
    refused(record, words)


def test_a_folder_in_place_of_the_signal_file_gives_a_one_line_error(record: Path) -> None:
    record.with_suffix(".dat").unlink()
    record.with_suffix(".dat").mkdir()
    refused(record, "not a regular file")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_place_of_the_signal_file_is_not_waited_for(record: Path) -> None:
    record.with_suffix(".dat").unlink()
    os.mkfifo(record.with_suffix(".dat"))
    refused(record, "not a regular file")


def test_a_record_of_noise_or_nothing_has_no_heartbeat(tmp_path: Path) -> None:
    header = write_record(tmp_path, {"II": np.zeros(5000)}, RATE)
    refused(header, "no heartbeat was found")


def test_a_missing_package_gives_a_one_line_error(
    record: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(name: str) -> None:
        raise ImportError(f"No module named '{name}'")

    monkeypatch.setattr(installation, "import_module", fail)
    refused(record, r"reading a WFDB record needs the package wfdb .*\[ecg\]")


def test_a_table_or_a_note_is_no_header() -> None:
    assert looks_like_header("100 2 360 650000\n100.dat 212 200\n100.dat 212 200\n")
    for text in ("1 2 3\n4 212 6\n", "hello 3\nworld 4\n", "a,b\n1,2\n", "", "x 1\n", "# only\n"):
        assert not looks_like_header(text)


GOOD = "made_up 2 250 7500 10:00:00 1/2/2003\nmade_up.dat 16 200 12 0 1 2 0 II\nmade_up.dat 16\n"


@HYPOTHESIS
@given(st.data())
@example(None)
def test_any_damage_to_a_header_ends_in_a_timeline_or_a_one_line_error(
    record: Path, data: st.DataObject | None
) -> None:
    words = GOOD
    if data is not None:
        for _ in range(data.draw(st.integers(1, 4))):
            at = data.draw(st.integers(0, len(words)))
            put = data.draw(
                st.sampled_from(
                    ["", " ", "\n", "-", "9" * 30, "/", "(", "x", "1e9", "\0", "é", "~"]
                )
                | st.text(max_size=3)
            )
            words = words[:at] + put + words[at + data.draw(st.integers(0, 6)) :]
    record.write_text(words, encoding="utf-8")
    timeline_or_one_line(lambda: load_timeline(record))


@HYPOTHESIS
@given(st.binary(max_size=200))
def test_any_header_text_parses_or_gives_a_one_line_error(tmp_path: Path, data: bytes) -> None:
    caught = None
    try:
        parse_header(data.decode("ascii", "replace"), tmp_path / "x.hea")
    except InputError as error:
        caught = error
    assert caught is None or "\n" not in str(caught)


@HYPOTHESIS
@given(st.binary(max_size=400), st.booleans())
def test_any_annotation_bytes_end_in_a_timeline_or_a_one_line_error(
    record: Path, data: bytes, valid_start: bool
) -> None:
    start = bytes.fromhex("6404c804") if valid_start else b""
    record.with_suffix(".atr").write_bytes(start + data)
    timeline_or_one_line(lambda: load_timeline(record))


@HYPOTHESIS
@given(
    st.sampled_from(["8", "16", "24", "32", "61", "80", "160", "212", "310", "311", "516", "524"]),
    st.binary(min_size=1, max_size=3000),
)
def test_any_signal_bytes_end_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, fmt: str, data: bytes
) -> None:
    (tmp_path / "x.dat").write_bytes(data)
    (tmp_path / "x.hea").write_text(f"x 1 60\nx.dat {fmt} 200 12 0 0 0 0 II\n")
    timeline_or_one_line(lambda: load_timeline(tmp_path / "x.hea"))


# --- other people's records ------------------------------------------------------------------


def test_record_100_holds_every_annotated_beat(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "ecg" / "100.hea")
    assert timeline.kinds() == {
        "rhythm": 1,
        "beat": 2239,
        "premature_atrial": 33,
        "premature_ventricular": 1,
    }
    assert timeline.duration_s == pytest.approx(1805.556, abs=1e-3)
    beats = beats_of(timeline)
    assert len(beats) == 2273
    assert beats[:3] == pytest.approx([0.2139, 1.0278, 1.8389], abs=5e-5)
    assert beats[-1] == pytest.approx(1805.5305, abs=1e-4)
    assert timeline.event("premature_atrial", 1).time_s == pytest.approx(5.678, abs=1e-3)
    assert timeline.event("premature_ventricular", 1).time_s == pytest.approx(1518.867, abs=1e-3)
    assert "mean heart rate 75.51 bpm" in timeline.notes[0]
    assert timeline.gaps == ()


def test_record_100_without_its_annotations_has_the_same_beats(
    data_folder: Path, tmp_path: Path
) -> None:
    for suffix in ("hea", "dat"):
        (tmp_path / f"100.{suffix}").write_bytes(
            (data_folder / "ecg" / f"100.{suffix}").read_bytes()
        )
    timeline = load_timeline(tmp_path / "100.hea")
    told = beats_of(load_timeline(data_folder / "ecg" / "100.hea"))
    assert agreement(beats_of(timeline), told) == (1.0, 1.0)
    # all of the 33 annotated as atrial, and the ventricular one; nothing else
    named = [event.time_s for event in timeline.events if event.kind == "premature"]
    atrial = [
        event.time_s
        for event in load_timeline(data_folder / "ecg" / "100.hea").events
        if event.kind == "premature_atrial"
    ]
    assert named == pytest.approx(atrial, abs=0.05)
    (other,) = (event for event in timeline.events if event.kind == "other_shape")
    assert other.time_s == pytest.approx(1518.867, abs=0.05)
    assert "missed_beat" not in {event.kind for event in timeline.events}
