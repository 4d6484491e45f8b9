from __future__ import annotations

import io

import numpy as np
import pytest
import soundfile

from overview_dsp.files.sound import PACKED, with_samples


def wav(samples, subtype):
    file = io.BytesIO()
    with soundfile.SoundFile(
        file, "w", samplerate=8000, channels=samples.shape[1], subtype=subtype, format="WAV"
    ) as sound:
        sound.write(samples)
    return file.getvalue()


@pytest.mark.parametrize("subtype", PACKED)
@pytest.mark.parametrize("frames", [0, 1, 7])
def test_samples_are_packed_into_an_empty_file(subtype, frames):
    kind = np.int16 if subtype == "PCM_16" else np.int32
    limits = np.iinfo(kind)
    samples = np.random.default_rng(frames).integers(
        limits.min, limits.max, (frames, 1), kind, endpoint=True
    )
    samples[:1], samples[1:2] = limits.min, limits.max
    assert with_samples(wav(samples[:0], subtype), subtype, samples) == wav(samples, subtype)


def test_a_header_with_more_in_it_is_left_alone():
    samples = np.zeros((3, 2), np.int32)
    empty = wav(samples[:0], "PCM_24")
    assert with_samples(empty + b"LIST\0\0\0\0", "PCM_24", samples) is None
    assert with_samples(b"RF64" + empty[4:], "PCM_24", samples) is None
