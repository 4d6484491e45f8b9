from __future__ import annotations

import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.audio import decoding
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.make_crowd import murmur, swelled, write_long
from tests.data.readers.outcome import timeline_or_one_line

RATE = 44_100
HYPOTHESIS = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def load(path: Path, sound: Any, rate: int = RATE, **options: Any) -> Timeline:
    soundfile.write(path, sound, rate)
    return load_timeline(path, **options)


def refused(path: Path, words: str, **options: Any) -> str:
    with pytest.raises(InputError, match=words) as caught:
        load_timeline(path, **options)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(str(path))
    return text


# --- what is heard ---------------------------------------------------------------------------


def test_a_recording_becomes_its_short_term_loudness(tmp_path: Path) -> None:
    time_s = np.arange(RATE * 20) / RATE
    gain = np.where(time_s < 10.0, 10 ** (-23 / 20), 10 ** (-33 / 20))
    sound = np.stack([gain * np.sin(2 * np.pi * 997 * time_s)] * 2, axis=1)
    timeline = load(tmp_path / "x.wav", sound)
    assert timeline.duration_s == 20.0
    assert timeline.title == "x"
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "LUFS"
    assert timeline.intensity_at([0.0, 5.0, 8.4, 11.6, 20.0]) == pytest.approx(
        [-23, -23, -23, -33, -33], abs=0.1
    )
    # half of the window is 10 dB quieter
    assert timeline.intensity_at(10.0) == pytest.approx(-23 + 10 * np.log10(0.55), abs=0.1)
    assert "WAV PCM_16, stereo, 44100 Hz" in timeline.provenance
    assert any("integrated loudness -2" in note for note in timeline.notes)


def test_map_chooses_the_curve(tmp_path: Path) -> None:
    sound = swelled(murmur(40.0), 20.0, 6.0, 12.0)
    loudness = load(tmp_path / "x.flac", sound)
    momentary = load(tmp_path / "x.flac", sound, map="momentary")
    excitement = load(tmp_path / "x.flac", sound, map="excitement")
    assert loudness == load(tmp_path / "x.flac", sound, map="loudness")
    assert momentary.events == excitement.events == loudness.events
    # over 0.4 s the rise is all there half a second after it, over 3 s it isn't
    assert momentary.intensity_at(20.7) > loudness.intensity_at(20.7) + 1.0
    assert excitement.intensity is not None
    assert excitement.intensity.unit == "LU"
    assert excitement.intensity_at(23.0) == pytest.approx(12.0, abs=1.5)
    assert excitement.intensity_at(5.0) < 2.0
    refused(
        tmp_path / "x.flac",
        "map is 'level'; must be one of loudness, momentary, excitement",
        map="level",
    )


def test_options_for_other_formats_are_refused(tmp_path: Path) -> None:
    load(tmp_path / "x.wav", murmur(1.0))
    refused(tmp_path / "x.wav", "rate does not apply", rate=44_100.0)


@pytest.mark.parametrize("rate", [8000, 44_100, 48_000])
@pytest.mark.parametrize("db", [7.0, 12.0, 20.0])
def test_a_cheer_over_a_murmur_is_found(rate: int, db: float, tmp_path: Path) -> None:
    sound = swelled(murmur(120.0, rate), 40.0, 8.0, db, rate)
    timeline = load(tmp_path / "x.wav", sound, rate)
    (cheer,) = timeline.events
    assert cheer.kind == "cheer"
    assert 40.0 <= cheer.time_s <= 48.0
    assert cheer.weight == pytest.approx(db / 10.0, abs=0.2)
    assert cheer.label.startswith("0:4")
    assert cheer.label.endswith(" LU")


def test_two_cheers_are_two_and_the_louder_weighs_more(tmp_path: Path) -> None:
    sound = swelled(swelled(murmur(90.0), 20.0, 5.0, 10.0), 60.0, 5.0, 18.0)
    first, second = load(tmp_path / "x.wav", sound).events
    assert first.weight < second.weight
    assert 20.0 <= first.time_s <= 25.0
    assert 60.0 <= second.time_s <= 65.0


def test_a_cheer_at_either_end_is_found(tmp_path: Path) -> None:
    for at in (-1.0, 55.0):
        (cheer,) = load(tmp_path / "x.wav", swelled(murmur(60.0), at, 20.0, 12.0)).events
        assert cheer.kind == "cheer"


@pytest.mark.parametrize("seed", range(4))
def test_a_steady_murmur_gives_no_event(seed: int, tmp_path: Path) -> None:
    assert load(tmp_path / "x.wav", murmur(300.0, 16_000, seed=seed), 16_000).events == ()


def test_a_murmur_that_grows_slowly_gives_no_event(tmp_path: Path) -> None:
    rate = 16_000
    grows = murmur(600.0, rate) * np.linspace(0.3, 3.0, 600 * rate)
    assert load(tmp_path / "x.wav", grows, rate).events == ()


def test_muted_stretches_do_not_make_a_murmur_a_cheer(tmp_path: Path) -> None:
    sound = murmur(200.0, 16_000)
    sound[50 * 16_000 : 90 * 16_000] = 0.0
    timeline = load(tmp_path / "x.wav", sound, 16_000)
    assert timeline.events == ()
    assert timeline.gaps == ()  # silence is data
    assert timeline.intensity_at(70.0) == -70.0


def test_a_whistle_over_a_murmur_is_a_burst(tmp_path: Path) -> None:
    sound = murmur(60.0)
    first, length = round(30.2 * RATE), round(0.8 * RATE)
    sound[first : first + length] += 0.3 * np.sin(2 * np.pi * 4000 * np.arange(length) / RATE)
    (burst,) = load(tmp_path / "x.wav", sound).events
    assert burst.kind == "burst"
    assert burst.time_s == pytest.approx(30.6, abs=0.2)


def test_silence_alone_is_flat_and_without_events(tmp_path: Path) -> None:
    timeline = load(tmp_path / "x.wav", np.zeros(RATE * 5))
    assert timeline.events == ()
    assert (timeline.intensity_at(np.arange(5.0)) == -70.0).all()


@pytest.mark.parametrize("bits", [0x7FC00000, 0xFF800001], ids=["quiet", "signalling"])
@pytest.mark.filterwarnings("error")
def test_missing_samples_of_a_float_file_are_a_gap(tmp_path: Path, bits: int) -> None:
    sound = murmur(20.0).astype(np.float32)
    sound[5 * RATE : 8 * RATE] = np.array([bits], np.uint32).view(np.float32)  # not a number
    sound[12 * RATE] = np.inf
    soundfile.write(tmp_path / "x.wav", sound, RATE, subtype="FLOAT")
    timeline = load_timeline(tmp_path / "x.wav")
    assert timeline.gaps == ((5.0, 8.0),)
    assert timeline.events == ()
    assert timeline.intensity_at(6.5) == 0.0
    assert timeline.intensity_at(4.5) == pytest.approx(timeline.intensity_at(15.0), abs=1.5)
    assert any("1 single samples are missing" in note for note in timeline.notes)
    soundfile.write(tmp_path / "x.wav", np.full(RATE, np.nan), RATE, subtype="FLOAT")
    refused(tmp_path / "x.wav", "no sample is a number")


def test_the_part_read_is_reported(tmp_path: Path) -> None:
    parts: list[float] = []
    write_long(tmp_path / "x.wav", 120)
    load_timeline(tmp_path / "x.wav", progress=parts.append)
    assert parts == sorted(parts)
    assert len(parts) > 5
    assert parts[-1] == 1.0


def test_the_shortest_recording_is_one_sample(tmp_path: Path) -> None:
    timeline = load(tmp_path / "x.wav", np.array([0.5]))
    assert timeline.duration_s == 1.0 / RATE


# --- formats ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["wav", "flac", "ogg", "mp3", "aiff", "w64", "rf64", "caf", "au"])
def test_every_format_gives_the_same_cheer_under_any_name(name: str, tmp_path: Path) -> None:
    if name.upper() not in soundfile.available_formats():
        pytest.skip(f"this libsndfile has no {name}")
    sound = swelled(murmur(40.0), 20.0, 6.0, 12.0)
    soundfile.write(tmp_path / "x", sound, RATE, format=name.upper())
    timeline = load_timeline(tmp_path / "x")
    assert timeline.kinds() == {"cheer": 1}
    assert timeline.duration_s == pytest.approx(40.0, abs=0.1)
    (tmp_path / "x").rename(tmp_path / "x.raw")
    assert load_timeline(tmp_path / "x.raw").kinds() == {"cheer": 1}


def test_surround_channels_are_named_in_a_note(tmp_path: Path) -> None:
    sound = np.stack([murmur(5.0, seed=s) for s in range(6)], axis=1)
    assert any(" L R C LFE Ls Rs" in note for note in load(tmp_path / "x.wav", sound).notes)
    loud_bass = sound * 0.01
    loud_bass[:, 3] = sound[:, 3]
    soundfile.write(tmp_path / "y.wav", loud_bass, RATE, format="WAVEX")
    timeline = load_timeline(tmp_path / "y.wav")
    assert timeline.intensity is not None
    assert timeline.intensity.value.max() < -55.0  # the LFE doesn't count


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (b"\0\0\0\x20ftypM4A ", r"an MP4 file .*ffmpeg -i 'x y\.m4a' 'x y\.wav'"),
        (b"\x1aE\xdf\xa3", "Matroska"),
        (b"#!AMR\n", "AMR"),
    ],
)
def test_what_libsndfile_does_not_open_says_how_to_convert_it(
    head: bytes, words: str, tmp_path: Path
) -> None:
    (tmp_path / "x y.m4a").write_bytes(head + bytes(1000))
    refused(tmp_path / "x y.m4a", words)


# --- broken files ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["wav", "aiff", "w64", "rf64", "au", "flac", "caf"])
def test_a_file_cut_off_gives_a_one_line_error(name: str, tmp_path: Path) -> None:
    path = tmp_path / "x"
    soundfile.write(path, murmur(4.0), RATE, format=name.upper())
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    assert "ffmpeg" in refused(
        path, r"truncated: it has \d+ % |sound ends after \d|invalid or unknown"
    )


def test_a_stream_of_unknown_length_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "x.wav"
    soundfile.write(path, murmur(4.0), RATE)
    data = bytearray(path.read_bytes())
    data[4:8] = data[40:44] = struct.pack("<I", 0xFFFFFFFF)  # as ffmpeg writes to a pipe
    path.write_bytes(data)
    timeline = load_timeline(path)
    assert timeline.duration_s == 4.0
    assert any("its header has no length" in note for note in timeline.notes)


def test_an_ogg_stream_without_its_end_says_so(tmp_path: Path) -> None:
    path = tmp_path / "x.ogg"
    soundfile.write(path, murmur(20.0), RATE)
    assert not any("end mark" in note for note in load_timeline(path).notes)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    assert any("end mark" in note for note in load_timeline(path).notes)


def test_mpeg_frames_without_a_header_are_counted_and_a_cut_one_is_noted(tmp_path: Path) -> None:
    whole, path = tmp_path / "whole.mp3", tmp_path / "x.mp3"
    soundfile.write(whole, murmur(20.0, 44_100), 44_100, subtype="MPEG_LAYER_III")
    data = whole.read_bytes()
    # the first frame is what says how many follow
    frames = data[data.index(data[:2], 10) :]
    path.write_bytes(frames)
    notes = load_timeline(path).notes
    assert any("its frames last 20.0 s, of which" in note for note in notes)
    assert not any("is incomplete" in note for note in notes)
    path.write_bytes(frames[: len(frames) // 2 + 100])
    assert any("last frame is incomplete" in note for note in load_timeline(path).notes)
    assert not any("frame" in note for note in load_timeline(whole).notes)


def test_a_recording_too_long_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "x.flac"
    load(path, np.zeros(RATE * 30))
    assert path.stat().st_size < 50_000
    refused(path, r"3 MB of samples \(0\.0 h\), more than the 2 MB allowed.*max_mb", max_mb=2.0)
    assert load_timeline(path, max_mb=3.0).duration_s == 30.0
    monkeypatch.setattr(decoding, "MAX_DECODED_MB", 1)
    refused(path, "more than the 1 MB")


def test_a_sample_rate_or_channels_beyond_reason_give_a_one_line_error(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "x.wav", np.zeros(1000), 1000)
    refused(tmp_path / "x.wav", "mono at 1000 Hz; must be at least 4000 Hz")
    soundfile.write(tmp_path / "x.wav", np.zeros((10, 100)), 96_000)
    refused(tmp_path / "x.wav", "100 channels at 96000 Hz; .*4000000 samples per second")


def test_a_sound_file_without_samples_gives_a_one_line_error(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "x.wav", np.zeros(0), RATE)
    refused(tmp_path / "x.wav", "has no samples")


def wav(**fields: int) -> bytes:
    known = {
        "riff": 36 + 8000,
        "fmt": 16,
        "tag": 1,
        "channels": 2,
        "rate": 44_100,
        "bytes": 176_400,
        "align": 4,
        "bits": 16,
        "data": 8000,
    }
    known.update(fields)
    return (
        struct.pack(
            "<4sI4s4sIHHIIHH4sI",
            *(b"RIFF", known["riff"], b"WAVE", b"fmt ", known["fmt"], known["tag"]),
            *(known["channels"], known["rate"], known["bytes"], known["align"], known["bits"]),
            *(b"data", known["data"]),
        )
        + bytes(range(250)) * 32
    )


SIZES = {"tag": 2, "channels": 2, "align": 2, "bits": 2}


@HYPOTHESIS
@given(st.sampled_from(["riff", "fmt", "rate", "bytes", "data", *SIZES]), st.data())
def test_any_number_in_a_header_ends_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, field: str, data: st.DataObject
) -> None:
    top = 2 ** (8 * SIZES.get(field, 4)) - 1
    value = data.draw(st.sampled_from([0, 1, top, top // 2, top // 2 + 1]) | st.integers(0, top))
    (tmp_path / "x.wav").write_bytes(wav(**{field: value}))
    timeline_or_one_line(lambda: load_timeline(tmp_path / "x.wav"))


WHOLE: dict[str, bytes] = {}


def encoded(name: str, folder: Path) -> bytes:
    if name not in WHOLE:
        subtype = "FLOAT" if name == "WAV" else None
        soundfile.write(folder / "whole", murmur(0.7, 16_000), 16_000, subtype, format=name)
        WHOLE[name] = (folder / "whole").read_bytes()
    return WHOLE[name]


@HYPOTHESIS
@given(st.sampled_from(["WAV", "FLAC", "OGG", "AIFF", "MP3", "CAF", "RF64"]), st.data())
def test_any_damage_ends_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, name: str, data: st.DataObject
) -> None:
    whole = bytearray(encoded(name, tmp_path))
    if data.draw(st.booleans()):
        del whole[data.draw(st.integers(1, len(whole))) :]
    for _ in range(data.draw(st.integers(0, 6))):
        # the header is where it matters
        place = data.draw(st.integers(0, 100) | st.integers(0, len(whole) - 1))
        whole[min(place, len(whole) - 1)] = data.draw(st.integers(0, 255))
    (tmp_path / "x").write_bytes(whole)
    timeline_or_one_line(lambda: load_timeline(tmp_path / "x"))


@HYPOTHESIS
@given(
    st.sampled_from(
        [b"", b"RIFF\0\0\0\0WAVE", b"fLaC", b"OggS\0\2", b"ID3\3\0\0", b"\xff\xfb\x90d"]
    ),
    st.binary(max_size=300),
)
def test_arbitrary_bytes_end_in_a_timeline_or_a_one_line_error(
    tmp_path: Path, head: bytes, rest: bytes
) -> None:
    (tmp_path / "x").write_bytes(head + rest)
    timeline_or_one_line(lambda: load_timeline(tmp_path / "x"))


# --- other people's recordings ---------------------------------------------------------------


def test_a_football_murmur_gives_no_cheer_however_often_it_is_looped(
    data_folder: Path, tmp_path: Path
) -> None:
    path = data_folder / "crowd" / "gpf_crowd01.wav"
    assert load_timeline(path).events == ()
    sound, rate = soundfile.read(path)
    looped = load(tmp_path / "x.wav", np.concatenate([sound] * 30), rate)
    assert looped.events == ()
    assert looped.duration_s == pytest.approx(30 * 6.94, abs=0.1)


@pytest.mark.parametrize("db", [3.0, 8.0])
def test_a_real_crowd_over_a_real_murmur_is_a_cheer(
    db: float, data_folder: Path, tmp_path: Path
) -> None:
    quiet, rate = soundfile.read(data_folder / "crowd" / "gpf_crowd01.wav")
    crowd, other = soundfile.read(data_folder / "crowd" / "mdn_concert-crowd.ogg")
    times = np.arange(int(len(crowd) / other * rate)) / rate
    crowd = np.stack([np.interp(times, np.arange(len(c)) / other, c) for c in crowd.T], axis=1)
    sound = np.concatenate([quiet] * 12)
    sound *= 10.0 ** ((-17.5 - db + 9.7) / 20.0)  # the murmur this much below the crowd
    first = 30 * rate
    sound[first : first + len(crowd)] += crowd
    events = load(tmp_path / "x.wav", sound, rate).events
    if db < 5.0:
        assert events == ()
    else:
        assert [event.kind for event in events] == ["cheer"]
        assert 30.0 <= events[0].time_s <= 45.0


def test_a_real_crowd_that_comes_and_fades_is_one_cheer(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "crowd" / "mdn_concert-crowd.ogg")
    assert timeline.kinds() == {"cheer": 1}
    assert timeline.duration_s == pytest.approx(15.62, abs=0.01)
    assert timeline.events[0].time_s < 13.5


def test_a_real_whistle_over_a_real_murmur_is_a_burst(data_folder: Path, tmp_path: Path) -> None:
    quiet, rate = soundfile.read(data_folder / "crowd" / "gpf_crowd01.wav")
    whistle, _ = soundfile.read(data_folder / "crowd" / "gpf_whistle2.wav")
    sound = np.concatenate([quiet] * 10) * 0.1
    sound[20 * rate : 20 * rate + len(whistle)] += whistle
    (burst,) = load(tmp_path / "x.wav", sound, rate).events
    assert burst.kind == "burst"
    assert burst.time_s == pytest.approx(20.3, abs=0.5)
    assert load_timeline(data_folder / "crowd" / "gpf_whistle2.wav").kinds() == {"burst": 1}


# --- long ones -------------------------------------------------------------------------------

MEASURE = """
import sys, time
from overview_dsp.data.readers import load_timeline
started = time.perf_counter()
timeline = load_timeline(sys.argv[1])
seconds = time.perf_counter() - started
# not getrusage: its figure begins with that of the process this one was started from
status = open("/proc/self/status").read()
peak = int(status.split("VmHWM:")[1].split()[0]) / 1024
print(f"{seconds:.1f} s, {peak:.0f} MB", [event.time_s for event in timeline.events], sep="\\n")
"""

needs_proc = pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="this system doesn't tell a process's memory"
)


def read_apart(path: Path) -> tuple[str, list[float]]:
    """Load a file in a process of its own; returns time and memory in words, and the events."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True
    )
    figures, events = done.stdout.splitlines()
    return figures, [float(event) for event in events.strip("[]").split(",")]


@needs_proc
@pytest.mark.soak
def test_ninety_minutes_of_stereo_are_read_in_bounded_memory(tmp_path: Path) -> None:
    cheers = write_long(tmp_path / "long.wav", 5400)
    figures, found = read_apart(tmp_path / "long.wav")
    (tmp_path / "long.wav").unlink()  # a gigabyte
    print(f"90 minutes of 44.1 kHz stereo: {figures}")
    assert len(found) == len(cheers)
    assert all(0.0 <= at - cheer <= 10.0 for at, cheer in zip(found, cheers, strict=True))
    assert float(figures.split()[2]) < 300.0


@needs_proc
def test_memory_does_not_grow_with_the_length(tmp_path: Path) -> None:
    """The short version of the soak test: five minutes of sound, of 210 MB, in less than 200."""
    cheers = write_long(tmp_path / "x.wav", 300)
    figures, found = read_apart(tmp_path / "x.wav")
    assert len(found) == len(cheers)
    assert float(figures.split()[2]) < 200.0
