"""Cue points with labels in WAV files: chunks after the samples, which audio editors show."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Sequence
from pathlib import Path

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, output_error

MAX_BYTES = 2**32 - 1


def cue_chunks(cues: Sequence[tuple[int, str]]) -> bytes:
    """Return the chunks `cue ` and `LIST` with labels, for pairs of sample and label."""
    points = struct.pack("<I", len(cues)) + b"".join(
        struct.pack("<II4sIII", number, sample, b"data", 0, 0, sample)
        for number, (sample, _) in enumerate(cues, 1)
    )
    labels = b"adtl" + b"".join(
        _chunk(b"labl", struct.pack("<I", number) + label.encode() + b"\0")
        for number, (_, label) in enumerate(cues, 1)
    )
    return _chunk(b"cue ", points) + _chunk(b"LIST", labels)


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + bytes(len(data) % 2)


def add_cues(path: Path, cues: Sequence[tuple[int, str]]) -> None:
    """Write cue points (samples, labels) into a WAV file, which doesn't change if that fails.

    InputError if the file isn't a WAV file, or is too large.
    """
    chunks = cue_chunks(cues)
    try:
        with open(path, "rb") as file:
            head = file.read(12)
        size = path.stat().st_size
    except OSError as error:
        raise output_error(path, error) from None
    if head[:4] != b"RIFF" or head[8:] != b"WAVE":
        raise InputError(f"{path}: cue points need a .wav file; use a transcript for other formats")
    padding = bytes(size % 2)
    if size + len(padding) + len(chunks) - 8 > MAX_BYTES:
        raise InputError(f"{path}: cue points make the WAV file larger than 4 GB; use a transcript")
    with atomic_file(path) as temporary:
        try:
            shutil.copyfile(path, temporary)
            with open(temporary, "r+b") as file:
                file.seek(0, 2)
                file.write(padding + chunks)
                file.seek(4)
                file.write(struct.pack("<I", size + len(padding) + len(chunks) - 8))
        except OSError as error:
            raise output_error(path, error) from None
