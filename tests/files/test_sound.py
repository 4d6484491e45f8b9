from __future__ import annotations

import math
import os

import numpy as np
import pytest
import soundfile
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.files.sound import SoundWriter, check_sound, save_sound, sound_bytes
from tests.profiles import share

RATE = 8000


def chord(frames: int = 3000) -> np.ndarray:
    """Two tones with exact silence before and after them."""
    t = np.arange(frames) / RATE
    samples = np.stack([np.sin(2765.0 * t), np.sin(1571.0 * t)], axis=1) * 0.8
    samples[: frames // 10] = samples[-frames // 10 :] = 0.0
    return samples.astype(np.float32)


def read(path):
    return soundfile.read(path, dtype="float64", always_2d=True)


@pytest.mark.parametrize(
    "suffix", ["wav", "flac", "aiff", "aif", "caf", "w64", "rf64", "au", "WAV"]
)
def test_a_lossless_format_keeps_every_sample_to_its_last_bit(tmp_path, suffix):
    path, samples = tmp_path / f"a.{suffix}", chord()
    save_sound(path, samples, RATE)
    back, rate = read(path)
    assert rate == RATE
    assert back.shape == samples.shape
    assert soundfile.info(path).subtype == "PCM_24"
    # rounded to the nearest of 24 bits
    assert np.abs(back - samples).max() <= 2.0**-24


@pytest.mark.parametrize("suffix", ["ogg", "oga", "opus", "mp3"])
def test_a_lossy_format_keeps_the_sound(tmp_path, suffix):
    if suffix == "mp3" and "MP3" not in soundfile.available_formats():
        pytest.skip("this libsndfile writes no MP3")
    path, samples = tmp_path / f"a.{suffix}", chord(RATE)
    save_sound(path, samples, RATE)
    back, rate = read(path)
    assert rate in (RATE, 48_000)  # Opus always decodes at 48 kHz
    assert len(back) / rate == pytest.approx(len(samples) / RATE, abs=0.2)
    level = math.sqrt(np.mean(back**2)) / math.sqrt(np.mean(samples**2))
    assert level == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("suffix", ["wav", "aiff", "caf", "w64"])
def test_float_samples_come_back_bit_for_bit(tmp_path, suffix):
    path, samples = tmp_path / f"a.{suffix}", chord()
    save_sound(path, samples, RATE, "float")
    back, _ = soundfile.read(path, dtype="float32")
    assert np.array_equal(back, samples)


def test_sixteen_bits_are_dithered_and_the_note_says_so(tmp_path):
    path, samples = tmp_path / "a.wav", chord()
    with SoundWriter(path, RATE, "PCM_16") as sound:
        sound.write(samples)
    assert "PCM_16" in sound.note
    assert "TPDF dither at 16 bits" in sound.note
    back, _ = read(path)
    step = 2.0**-15
    error = back - samples
    # triangular noise of two steps' width, and half a step of rounding
    assert np.abs(error).max() <= 1.6 * step
    assert np.abs(error).max() > 0.6 * step


@pytest.mark.parametrize("subtype", [None, "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
def test_finer_samples_are_not_dithered_and_the_note_says_so(tmp_path, subtype):
    with SoundWriter(tmp_path / "a.wav", RATE, subtype) as sound:
        sound.write(chord())
    assert "no dither" in sound.note


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_U8"])
def test_exact_zeros_stay_exact_zeros_under_dither(tmp_path, subtype):
    samples = chord()
    save_sound(tmp_path / "a.wav", samples, RATE, subtype)
    back, _ = read(tmp_path / "a.wav")
    assert (back[samples == 0.0] == 0.0).all()
    assert (samples == 0.0).sum() > 1000


def test_dither_carries_what_is_smaller_than_a_step(tmp_path):
    level = 0.3 * 2.0**-15
    samples = np.full((20_000, 2), level, dtype=np.float32)
    save_sound(tmp_path / "a.wav", samples, RATE, "PCM_16")
    back, _ = read(tmp_path / "a.wav")
    # plain rounding would give 0; the mean's own deviation is below a hundredth of a step
    assert back.mean() == pytest.approx(level, rel=0.1)


@settings(max_examples=share(0.6))
@given(st.lists(st.integers(0, 3000), max_size=6), st.sampled_from(["PCM_16", "FLOAT", "PCM_24"]))
def test_the_blocks_in_which_samples_come_change_no_bit(tmp_path_factory, cuts, subtype):
    folder, samples = tmp_path_factory.getbasetemp(), chord()
    save_sound(folder / "whole.wav", samples, RATE, subtype)
    with SoundWriter(folder / "cut.wav", RATE, subtype) as sound:
        for piece in np.split(samples, sorted(cuts)):
            sound.write(piece)
    assert sound.frames == len(samples)
    whole, _ = read(folder / "whole.wav")
    cut, _ = read(folder / "cut.wav")
    assert np.array_equal(whole, cut)


def test_a_long_ogg_is_written_whole(tmp_path):
    samples = np.tile(chord(), (200, 1))
    save_sound(tmp_path / "a.ogg", samples, 48_000)
    assert soundfile.info(tmp_path / "a.ogg").frames == len(samples)


@pytest.mark.parametrize(
    ("name", "rate", "subtype", "words"),
    [
        ("a.xyz", RATE, None, "no sound format has the suffix '.xyz'; use wav, flac"),
        ("a", RATE, None, "no sound format"),
        ("a.raw", RATE, None, "no sound format"),
        ("a.sd2", RATE, None, "no sound format"),
        ("a.wav", RATE, "PCM_17", "WAV has no subtype 'PCM_17'; allowed: ALAW"),
        ("a.flac", RATE, "FLOAT", "FLAC has no subtype 'FLOAT'; allowed: PCM_16"),
        (
            "a.wav",
            44_100.5,
            None,
            "is 44100.5 Hz; must be a whole number, such as 44100",
        ),
        ("a.wav", math.nan, None, "is nan Hz; must be a whole number"),
        ("a.wav", math.inf, None, "is inf Hz; must be a whole number"),
        ("a.htk", RATE, None, "HTK PCM_16 can't hold 2 channels at 8000 Hz"),
        ("a.opus", 44_100, None, "OPUS can't hold 2 channels at 44100 Hz"),
        ("a.flac", 768_000, None, "can't hold 2 channels at 768000 Hz"),
        ("no/a.wav", RATE, None, "can't be written (No such file or directory)"),
        ("file/a.wav", RATE, None, "can't be written"),
        ("folder.wav", RATE, None, "is a folder"),
    ],
)
def test_what_cannot_be_written_is_an_error_of_one_line_and_leaves_what_was_there(
    tmp_path, name, rate, subtype, words
):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.wav").mkdir()
    path = tmp_path / name
    if path.parent == tmp_path and not path.is_dir():
        path.write_text("old")
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(ov.InputError) as error:
        save_sound(path, chord(), rate, subtype)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{path}: ")
    assert words in str(error.value)
    assert sorted(os.listdir(tmp_path)) == before
    if path.is_file():
        assert path.read_text() == "old"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_file_that_is_not_finished_is_not_left_behind(tmp_path, error):
    def fail() -> None:
        with SoundWriter(tmp_path / "a.wav", RATE) as sound:
            sound.write(chord())
            raise error

    with pytest.raises(error):
        fail()
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "subtype"),
    [
        ("a.wav", None),
        ("a.wav", "PCM_16"),
        ("a.flac", None),
        ("a.aiff", "PCM_S8"),
    ],
)
def test_the_bytes_are_those_of_the_file(tmp_path, name, subtype):
    save_sound(tmp_path / name, chord(9000), RATE, subtype)
    assert sound_bytes(name, chord(9000), RATE, subtype) == (tmp_path / name).read_bytes()


@pytest.mark.parametrize("name", ["a.wav", "a.aiff", "a.caf", "a.w64"])
def test_floats_in_memory_say_nothing_of_when_they_were_written(tmp_path, name):
    save_sound(tmp_path / name, chord(), RATE, "FLOAT")
    expected = bytearray((tmp_path / name).read_bytes())
    peak = expected.find(b"PEAK")
    assert (peak >= 0) == (name in ("a.wav", "a.aiff"))
    if peak >= 0:
        assert any(expected[peak + 12 : peak + 16])
        expected[peak + 12 : peak + 16] = bytes(4)
    assert sound_bytes(name, chord(), RATE, "FLOAT") == expected


@given(
    subtype=st.sampled_from(["PCM_16", "PCM_24", "PCM_32", "PCM_U8"]),
    frames=st.integers(0, 5000),
    channels=st.integers(1, 3),
    rate=st.sampled_from([1000, 44_100, 768_000]),
    seed=st.integers(0, 2**32),
)
def test_a_wav_in_memory_has_libsndfiles_bytes(
    tmp_path_factory, subtype, frames, channels, rate, seed
):
    # louder than full scale too
    samples = np.random.default_rng(seed).normal(0.0, 0.7, (frames, channels)).astype(np.float32)
    path = tmp_path_factory.mktemp("wav") / "a.wav"
    save_sound(path, samples, rate, subtype)
    assert sound_bytes("a.wav", samples, rate, subtype) == path.read_bytes()


@pytest.mark.parametrize(
    ("name", "rate", "subtype"),
    [
        ("a.txt", RATE, None),
        ("a.wav", RATE, "PCM_12"),
        ("a.wav", 8000.5, None),
        ("a.flac", 700_000, None),
    ],
)
def test_a_sound_that_cannot_be_is_refused_without_one(name, rate, subtype):
    with pytest.raises(ov.InputError, match=r"a\."):
        check_sound(name, rate, subtype)
