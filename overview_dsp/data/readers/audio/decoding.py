"""Audio files as blocks of samples, decoded by libsndfile."""

from __future__ import annotations

import contextlib
import mmap
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.loudness import MIN_RATE
from overview_dsp.data.readers.audio.channels import layout_of, weights_of, weights_of_mask
from overview_dsp.data.readers.data_file import DataFile, signature
from overview_dsp.errors import InputError
from overview_dsp.files.toml import load_toml

_TABLES = load_toml(__file__, "tables.toml")
_VERSIONS = {3: "1", 2: "2", 0: "2_5"}  # MPEG versions by their codes in the header of a frame


def frame_of(header: bytes) -> tuple[int, float] | None:
    """Return the length of an MPEG audio frame in bytes and in s; None if `header` is not one."""
    if len(header) < 4 or header[0] != 0xFF or header[1] & 0xE0 != 0xE0:
        return None
    version, layer = _VERSIONS.get(header[1] >> 3 & 3), 4 - (header[1] >> 1 & 3)
    bitrate, rate, padded = header[2] >> 4, header[2] >> 2 & 3, header[2] >> 1 & 1
    if version is None or layer == 4 or bitrate in (0, 15) or rate == 3:
        return None
    kbits = _TABLES["mpeg_1_kbits" if version == "1" else "mpeg_2_kbits"]
    bits, hz = 1000 * kbits[str(layer)][bitrate - 1], _TABLES["mpeg_rates"][version][rate]
    if layer == 1:
        return (12 * bits // hz + padded) * 4, 384 / hz
    samples = 576 if layer == 3 and version != "1" else 1152
    return samples // 8 * bits // hz + padded, samples / hz


def begins_with_frames(head: bytes) -> bool:
    """Return whether a file begins with two MPEG frames of the same type."""
    frame = frame_of(head[:4])
    if frame is None:
        return False
    following = head[frame[0] : frame[0] + 4]
    same = frame_of(following) is not None and head[1] == following[1]
    return same and head[2] & 0x0C == following[2] & 0x0C


def mpeg_duration(data: mmap.mmap) -> tuple[float, bool]:
    """Return the duration of all MPEG frames, s, and whether the last one is complete.

    Returns (0, True) if other data are between the frames.
    """
    offset, seconds = _id3_bytes(data), 0.0
    while offset + 4 <= len(data):
        header = data[offset : offset + 4]
        frame = frame_of(header)
        if frame is None:
            # a tag may follow the last frame
            return (seconds, True) if header[:3] in (b"TAG", b"APE", b"ID3") else (0.0, True)
        if offset + frame[0] > len(data):
            return seconds, False
        offset, seconds = offset + frame[0], seconds + frame[1]
    return seconds, offset == len(data)


def _id3_bytes(data: mmap.mmap) -> int:
    """Return the size of an ID3v2 tag at the beginning; 0 without one."""
    if data[:3] != b"ID3":
        return 0
    size = 0
    for byte in data[6:10]:
        size = size << 7 | byte & 0x7F
    return 10 + size


MAX_DECODED_MB = 16_384
"""Maximum size of a recording after decoding, as 16-bit samples, in megabytes (2**20 bytes).

This is 27 hours of stereo at 44.1 kHz. A small FLAC file of silence may contain months.
"""

MAX_SAMPLES_PER_S = 4_000_000
"""Maximum samples per second, all channels together: 80 channels at 48 kHz."""

_SUFFIXES_WITHOUT_SIGNATURE = frozenset(
    {"htk", "mpc2k", "sds", "sd2", "sf", "ircam", "xi", "wve", "paf", "pvf", "avr"}
)
_TRUNCATED = re.compile(r"^\s*(\S[^:\n]*?)\s*: (\d+) \(should be (\d+)\)", re.MULTILINE)
_MASK = re.compile(r"^\s*Channel Mask\s*: 0x([0-9A-F]+)", re.MULTILINE)
# the chunks with the samples; for W64 and RF64 libsndfile reports only the size of the file
_SAMPLE_CHUNKS = {"data", "SSND", "Data Size"}
_FILE_CHUNKS = {"W64": "riff", "RF64": "Riff size"}
# programs write a size of at least this value when they do not know the size (0xffffffff)
_UNKNOWN_FROM = 0x7FFFF000
_OGG_LAST_PAGE = 0x04
_TAIL_BYTES = 65_536 + 512
"""Bytes at the end of an Ogg stream that contain its last page; a page has up to 65307 bytes."""


@dataclass(frozen=True)
class Recording:
    """Open audio file.

    `where`: path for messages.
    `sample_rate`: sample rate, Hz.
    `frames`: number of frames in the header.
    `weights`: weight of each channel's power in the loudness.
    `kind`: format, encoding, channels and rate, for display.
    `notes`: assumptions about the file.
    """

    where: str
    sample_rate: int
    frames: int
    weights: tuple[float, ...]
    kind: str
    notes: tuple[str, ...]
    _file: Any

    def blocks(self, frames: int) -> Iterator[NDArray[np.floating[Any]]]:
        """Yield the samples in order, float32 or float64 (frames, channels).

        The last block is shorter. Each block overwrites the previous one.

        InputError: the data are truncated or cannot be decoded. The message contains the time.
        """
        import soundfile

        precise = self._file.subtype == "DOUBLE"
        buffer = np.empty((frames, len(self.weights)), np.float64 if precise else np.float32)
        done = 0
        while done < self.frames:
            try:
                block = self._file.read(out=buffer)
            except soundfile.LibsndfileError as error:
                raise self._broken(done, _reason(error)) from error
            if len(block) == 0:
                expected_s = self.frames / self.sample_rate
                raise self._broken(done, f"its header specifies {expected_s:.1f} s")
            done += len(block)
            yield block

    def _broken(self, done: int, reason: str) -> InputError:
        return InputError(
            f"{self.where}: the sound ends after {done / self.sample_rate:.1f} s "
            f"({reason}); {_repair(self.where)}"
        )


def is_recording(source: DataFile) -> bool:
    """Return whether the file is a recording, including formats that must be converted first."""
    if source.head_text is not None:  # a table may begin with MAC or ID3
        return False
    if any(signature(source.head, kind) for kind in ("unsupported", "recording")):
        return True
    if begins_with_frames(source.head):
        return True
    # formats without a signature, by their suffix: libsndfile would search any other file for MPEG
    # frames and print an error
    if source.path.suffix[1:].lower() not in _SUFFIXES_WITHOUT_SIGNATURE:
        return False
    import soundfile

    try:
        with open(source.path, "rb") as stream:
            soundfile.SoundFile(stream.fileno(), closefd=False).close()
    except (OSError, soundfile.LibsndfileError):
        return False
    return True


@contextlib.contextmanager
def open_recording(source: DataFile, max_mb: float | None = None) -> Iterator[Recording]:
    """Open an audio file.

    `source`: file for which `is_recording` is true.
    `max_mb`: maximum size, as `LoadOptions.max_mb`; None: `MAX_DECODED_MB`.

    InputError: the format is not supported, or the file is invalid, truncated, without samples or
    too long.
    """
    unsupported = signature(source.head, "unsupported")
    if unsupported:
        raise InputError(
            f"{source.where}: {unsupported}, which is not supported; convert it: ffmpeg -i "
            f"{_quoted(source.path.name)} {_quoted(source.path.stem + '.wav')}"
        )
    import soundfile

    try:
        # libsndfile gets no file name, so that it ignores the suffix
        with open(source.path, "rb") as stream:
            try:
                file = soundfile.SoundFile(stream.fileno(), closefd=False)
            except soundfile.LibsndfileError as error:
                if source.head.startswith(b"MATLAB"):
                    raise InputError(
                        f"{source.where}: a MATLAB file without sound; write its columns as CSV "
                        "(writematrix, or scipy.io.loadmat in Python)"
                    ) from error
                raise InputError(
                    f"{source.where}: invalid or unknown audio file ({_reason(error)}); "
                    f"{_repair(source.where)}"
                ) from error
            with file:
                yield _recording_of(source, file, max_mb)
    except OSError as error:
        raise InputError(f"{source.where}: cannot be read ({error.strerror})") from error


def _recording_of(source: DataFile, file: Any, max_mb: float | None) -> Recording:
    where, rate, frames, channels = source.where, file.samplerate, file.frames, file.channels
    log: str = file.extra_info
    notes = list(_length_notes(source, file, log))
    if frames <= 0:
        raise InputError(f"{where}: the audio file has no samples; {_repair(where)}")
    if rate < MIN_RATE or rate * channels > MAX_SAMPLES_PER_S:
        raise InputError(
            f"{where}: {_channels(channels)} at {rate} Hz; must be at least {MIN_RATE} Hz and at "
            f"most {MAX_SAMPLES_PER_S} samples per second, all channels together: resample the "
            "file or reduce the number of channels"
        )
    limit = max_mb if max_mb is not None else float(MAX_DECODED_MB)
    size = frames * channels * 2 / 2**20
    if size > limit:
        raise InputError(
            f"{where}: {size:.0f} MB of samples ({frames / rate / 3600.0:.1f} h), more than the "
            f"{limit:g} MB allowed; cut the file into parts, or raise the limit with max_mb "
            "(--read max-mb=MB)"
        )
    mask = _MASK.search(log)
    weights = weights_of_mask(int(mask[1], 16), channels) if mask else None
    if weights is None:
        layout = layout_of(channels, file.subtype in ("VORBIS", "OPUS"))
        weights = weights_of(layout) if layout else (1.0,) * channels
        if channels > 2:
            unknown = "equally loud, as there is no standard layout"
            notes.append(
                f"the {channels} channels were read as {' '.join(layout or ()) or unknown}"
            )
    if not any(weights):
        weights = (1.0,) * channels  # a single LFE channel would have no loudness
    kind = f"{file.format} {file.subtype}, {_channels(channels)}, {rate} Hz"
    return Recording(where, rate, frames, weights, kind, tuple(notes), file)


def _length_notes(source: DataFile, file: Any, log: str) -> Iterator[str]:
    """Yield notes about an uncertain length; InputError if the end of the sound is missing."""
    chunks = {*_SAMPLE_CHUNKS, _FILE_CHUNKS.get(file.format, "data")}
    for name, expected, actual in _TRUNCATED.findall(log):
        if name not in chunks or int(expected) <= int(actual):
            continue
        if _UNKNOWN_FROM <= int(expected) < 2**32:
            yield "its header has no length; the sound was read to the end of the file"
            continue
        part = int(actual) / int(expected)
        raise InputError(
            f"{source.where}: truncated: it has {100.0 * part:.0f} % of the sound that its header "
            f"specifies ({file.frames / file.samplerate:.1f} s); {_repair(source.where)}"
        )
    if file.format == "OGG" and not _ogg_ends(source):
        yield "the Ogg stream has no end mark: it may be truncated"
    if file.format == "MP3":
        yield from _mpeg_notes(source, file)


def _mpeg_notes(source: DataFile, file: Any) -> Iterator[str]:
    """Yield notes about MPEG frames that the decoder ignored."""
    with (
        open(source.path, "rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        seconds, whole = mpeg_duration(data)
    if not whole:
        yield "its last frame is incomplete: the file may be truncated"
    read_s = file.frames / file.samplerate
    if seconds > 1.0 + 1.01 * read_s:
        yield (
            f"its frames last {seconds:.1f} s, of which {read_s:.1f} s were read, because no "
            f"header contains the length; {_repair(source.where)}"
        )


def _ogg_ends(source: DataFile) -> bool:
    with open(source.path, "rb") as stream:
        stream.seek(max(0, source.size - _TAIL_BYTES))
        tail = stream.read()
    last = tail.rfind(b"OggS")
    return 0 <= last < len(tail) - 6 and bool(tail[last + 5] & _OGG_LAST_PAGE)


def _reason(error: Any) -> str:
    """Return the message of libsndfile without its prefix and final period."""
    message = str(error.error_string).removeprefix("Error : ").strip(" .")
    return message or f"libsndfile error {error.code}"


def _repair(where: str) -> str:
    return f"download it again, or try to repair it: ffmpeg -i {_quoted(where)} repaired.wav"


def _quoted(name: str) -> str:
    return f"'{name}'" if " " in name else name


def _channels(channels: int) -> str:
    return {1: "mono", 2: "stereo"}.get(channels, f"{channels} channels")
