"""Cue points of a WAV file with their labels: chunks behind its samples, that editors show."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Sequence
from pathlib import Path

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, output_error

MOST_BYTES = 2**32 - 1


def cue_chunks(cues: Sequence[tuple[int, str]]) -> bytes:
    """The chunks `cue ` and `LIST` of labels, for (sample, label) pairs."""
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
    """Write cue points into a WAV file, which stays as it was if that fails.

    Parameters
    ----------
    path
        A RIFF file.
    cues
        Samples from the beginning, with their labels.

    Raises
    ------
    InputError
        It is no WAV file, or too large for more.
    """
    chunks = cue_chunks(cues)
    try:
        with open(path, "rb") as file:
            head = file.read(12)
        size = path.stat().st_size
    except OSError as error:
        raise output_error(path, error) from None
    if head[:4] != b"RIFF" or head[8:] != b"WAVE":
        raise InputError(f"{path}: cue points are for .wav files; use a transcript for others")
    padding = bytes(size % 2)
    if size + len(padding) + len(chunks) - 8 > MOST_BYTES:
        raise InputError(f"{path}: a WAV file of 4 GB holds no cue points; use a transcript")
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
