"""Transcripts, labels, subtitles and cue points of all passed events."""

from __future__ import annotations

import csv
import json
import re
import struct
from itertools import pairwise

import numpy as np
import pytest
import soundfile
from scipy.signal import resample_poly

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_dsp.files.sound import add_cues
from overview_dsp.offline.rendering.event_log import of_events, passed_events, save_transcript
from overview_dsp.offline.rendering.limiter import Limiter, TruePeaks
from tests.cli.running import MATCH, overview
from tests.parameters import first_in_gate


@pytest.fixture(scope="module")
def result(match, football):
    return ov.render(match, football, ov.sweep(1.0), sample_rate=8000)


@pytest.fixture(scope="module")
def passed(result, match):
    return passed_events(result.strikes, match)


def test_every_passed_event_is_listed_with_time_and_level(result, match, passed):
    strikes = result.strikes.of_events()
    assert [one.time_s for one in passed] == strikes.time_s.tolist()
    assert [one.event for one in passed] == [match.events[i] for i in strikes.event]
    strongest = passed[int(strikes.level.argmax())]
    assert (strongest.below_db, strongest.strength) == (0.0, "strong")
    assert {one.strength for one in passed} == {"strong", "medium", "weak"}


def written(passed, path):
    save_transcript(passed, path)
    return path.read_text()


def test_text_is_a_line_an_event(passed, tmp_path):
    lines = written(passed, tmp_path / "a.txt").splitlines()
    assert len(lines) == len(passed)
    goal = next(one for one in passed if one.event.kind == "goal")
    assert f"{goal.time_s:.2f} s goal, {goal.event.label}, strong" in lines


def test_json_labels_and_markers_name_the_same_events(passed, tmp_path):
    told = json.loads(written(passed, tmp_path / "a.json"))
    labels = [
        line.split("\t") for line in written(passed, tmp_path / "a.audacity.txt").splitlines()
    ]
    (head, *markers) = csv.reader(written(passed, tmp_path / "a.csv").splitlines())
    assert head == ["#", "Name", "Start", "End", "Length"]
    assert len(told) == len(labels) == len(markers) == len(passed)
    for one, record, (start, end, words), marker in zip(passed, told, labels, markers, strict=True):
        assert record["kind"] == one.event.kind
        assert record["time_s"] == pytest.approx(one.time_s, abs=1e-4)
        assert float(start) == float(end) == pytest.approx(one.time_s, abs=1e-6)
        assert words == marker[1] == one.text
        minutes, seconds = marker[2].split(":")
        assert 60 * int(minutes) + float(seconds) == pytest.approx(one.time_s, abs=6e-4)


def seconds(clock):
    hours, minutes, rest = clock.split(":")
    return 3600 * int(hours) + 60 * int(minutes) + float(rest)


def test_subtitles_can_be_read_and_name_the_strongest_events(passed, tmp_path):
    text = written(passed, tmp_path / "a.vtt")
    assert text.startswith("WEBVTT\n\n")
    cue = r"^(\d\d:\d\d:\d\d\.\d{3}) --> (\d\d:\d\d:\d\d\.\d{3})\n((?:.+\n)+)"
    cues = [(seconds(a), seconds(b), words) for a, b, words in re.findall(cue, text, re.M)]
    for start, end, words in cues:
        assert 0.7 - 1e-3 <= end - start <= 1.5 + 1e-3
        inside = [one for one in passed if start - 6e-4 <= one.time_s < start + 0.7 - 6e-4]
        shown = words.splitlines()
        assert len(shown) == min(len(inside), 3)
        assert max(inside, key=lambda one: -one.below_db).text in words
        weaker = len(inside) - len(shown)
        assert shown[-1].endswith(f"(and {weaker} weaker)") == (weaker > 0)
    assert all(end <= start for (_, end, _), (start, _, _) in pairwise(cues))
    assert sum(
        start <= one.time_s + 6e-4 < start + 0.7 for one in passed for start, *_ in cues
    ) == len(passed)


def test_words_of_a_label_cannot_break_a_file(match, tmp_path):
    event = ov.Event(1.0, "goal", 'a\tb\n"c", <i> --> & d')
    one = of_events([70.5], [1.0], [event], match)
    assert written(one, tmp_path / "a.audacity.txt").count("\t") == 2
    assert len(written(one, tmp_path / "a.txt").splitlines()) == 1
    ((_, row),) = [list(csv.reader(written(one, tmp_path / "a.csv").splitlines()))]
    assert row[1:3] == ['goal, a b "c", <i> --> & d, strong', "1:10.500"]
    body = written(one, tmp_path / "a.vtt").splitlines()
    assert body[2] == "00:01:10.500 --> 00:01:12.000"
    assert "-->" not in body[3]
    assert "<" not in body[3]


def test_another_suffix_is_an_error_of_one_line(passed, tmp_path):
    with pytest.raises(InputError, match=r"a\.srt: a transcript must be \.txt, \.json, \.vtt"):
        save_transcript(passed, tmp_path / "a.srt")


def chunks(data):
    at, found = 12, {}
    while at < len(data):
        name, size = data[at : at + 4], struct.unpack_from("<I", data, at + 4)[0]
        found[name] = data[at + 8 : at + 8 + size]
        at += 8 + size + size % 2
    assert at == len(data) == struct.unpack_from("<I", data, 4)[0] + 8
    return found


@pytest.mark.parametrize("frames", [1000, 1001])
def test_cue_points_lie_at_their_samples_and_the_sound_is_untouched(tmp_path, frames):
    path = tmp_path / "a.wav"
    samples = np.random.default_rng(0).uniform(-0.5, 0.5, (frames, 1))
    soundfile.write(path, samples, 8000, subtype="PCM_24")
    before, _ = soundfile.read(path)
    cues = [(5, "goal, 1-0, strong"), (700, "Müller")]
    add_cues(path, cues)
    after, _ = soundfile.read(path)
    np.testing.assert_array_equal(before, after)
    found = chunks(path.read_bytes())
    (count,) = struct.unpack_from("<I", found[b"cue "])
    points = [struct.unpack_from("<II4sIII", found[b"cue "], 4 + 24 * k) for k in range(count)]
    assert [(number, point[5]) for number, *point in points for point in [[number, *point]]] == [
        (1, 5),
        (2, 700),
    ]
    for _, label in cues:
        assert label.encode() + b"\0" in found[b"LIST"]


def test_cue_points_are_for_wav_files(tmp_path):
    path = tmp_path / "a.flac"
    soundfile.write(path, np.zeros(100), 8000)
    with pytest.raises(InputError, match=r"cue points need a \.wav file"):
        add_cues(path, [(1, "a")])


SHORT = ("--gesture", "tap:0.3:0.3", "--sample-rate", "8000", "--tail", "0.2")


def test_render_writes_transcripts_cues_and_stems(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview(
        *("render", MATCH, *SHORT, "-o", "a.wav", "--stems", "--cue-points"),
        *("--transcript", "a.vtt", "--transcript", "a.json", "--transcript", "-"),
    )
    assert done.code == 0, done.err
    told = json.loads((tmp_path / "a.json").read_text())
    assert told
    assert f"{told[0]['time_s']:.2f} s {told[0]['kind'].replace('_', ' ')}" in done.out
    cues = chunks((tmp_path / "a.wav").read_bytes())[b"cue "]
    assert struct.unpack_from("<I", cues)[0] == len(told)
    assert struct.unpack_from("<I", cues, 8)[0] == pytest.approx(8000 * told[0]["time_s"], abs=1)
    both, _ = soundfile.read("a.wav")
    for channel, name in enumerate(("click", "tactor")):
        stem, rate = soundfile.read(f"a.{name}.wav")
        assert rate == 8000
        np.testing.assert_array_equal(stem, both[:, channel])
    curves, _ = soundfile.read("a.trace.wav")
    assert curves.shape == (len(both), 4)
    assert 0.1 < curves[:, 0].max() <= 1.0
    assert set(np.unique(curves[:, 1])) == {0.0, 1.0}


def test_export_writes_a_transcript_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview(
        *("export", MATCH, "--gesture", "sweep:0.5", "--to", "haptic", "-o", "a.haptic"),
        *("--transcript", "a.txt", "--json"),
    )
    assert done.code == 0, done.err
    lines = (tmp_path / "a.txt").read_text().splitlines()
    assert len(json.loads(done.out)[-1]["events"]) == len(lines) > 10


def true_peak_db(samples):
    return 20.0 * np.log10(np.abs(resample_poly(samples, 16, 1)).max())


@pytest.mark.parametrize("wanted", first_in_gate([-16.0, -40.0, -30.0, -23.0]))
def test_normalized_the_click_has_its_loudness_and_the_tactor_is_as_it_was(
    tmp_path, match, football, wanted
):
    gesture = ov.sweep(1.0)
    plain = ov.render_to_file(match, football, gesture, tmp_path / "a.wav", loudness=True)
    made = ov.render_to_file(match, football, gesture, tmp_path / "b.wav", normalize=wanted)
    assert made.lufs == pytest.approx(wanted, abs=0.1)
    before, after = (soundfile.read(tmp_path / name)[0] for name in ("a.wav", "b.wav"))
    np.testing.assert_array_equal(before[:, 1], after[:, 1])
    assert true_peak_db(after[:, 0]) <= -1.0
    # how far the highest peak is from the one that the gain alone would give
    lowered = made.gain_db + true_peak_db(before[:, 0]) - true_peak_db(after[:, 0])
    assert made.limited_db == pytest.approx(lowered, abs=0.5)
    if wanted < -29.0:  # without the limiter
        assert made.limited_db == 0.0
        assert made.gain_db == pytest.approx(wanted - plain.lufs, abs=0.5)
        quiet = np.abs(before[:, 0]) > 1e-3
        gains = after[quiet, 0] / before[quiet, 0]
        np.testing.assert_allclose(gains, 10 ** (made.gain_db / 20), rtol=5e-3)


def test_the_limiter_acts_around_peaks_only_and_changes_gain_smoothly():
    rate = 48_000
    sound = np.full(rate, 0.1, np.float32)
    sound[rate // 2] = 1.0
    peaks = TruePeaks(rate)
    for part in np.array_split(sound, 7):
        peaks.feed(part)
    limiter = Limiter(peaks.finish(), peaks.step_frames, 2.0, 0.5)
    made = sound.copy()
    for part in np.array_split(made, 11):  # views
        limiter.apply(part)
    gain = made / sound
    assert made.max() <= 0.5
    away = np.abs(np.arange(rate) - rate // 2) > 0.013 * rate
    np.testing.assert_allclose(gain[away], 2.0, rtol=1e-6)
    assert np.abs(np.diff(gain)).max() < 2.0 / (0.004 * rate)


def test_no_sample_is_turned_up_beyond_the_ceiling(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview("render", MATCH, *SHORT, "-o", "a.wav", "--normalize", "-6")
    assert done.code == 0, done.err
    assert "the limiter (true peaks of -1 dBFS) allows no more" in done.out
    assert "peaks limited by up to " in done.out
    assert -2.0 < true_peak_db(soundfile.read("a.wav")[0][:, 0]) <= -1.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--normalize", "3"), "normalize is 3 LUFS; must be -60 to 0"),
        (("--normalize", "nan"), "normalize is nan LUFS; must be -60 to 0"),
        (
            ("--measure-loudness", "--sample-rate", "2000"),
            "loudness needs a whole number from 4000 Hz",
        ),
        (("--transcript", "a.srt"), "a.srt: a transcript must be"),
        (("--cue-points", "-o", "a.flac"), "a.flac: --cue-points needs a .wav file"),
        (("--stems", "--transcript", "nowhere/a.txt"), "nowhere"),
    ],
)
def test_what_cannot_be_written_is_an_error_of_one_line_before_any_work(
    tmp_path, monkeypatch, options, words
):
    monkeypatch.chdir(tmp_path)
    done = overview("render", MATCH, *SHORT, *options)
    assert done.code == 2
    assert words in done.errors[0]
    assert list(tmp_path.iterdir()) == []
