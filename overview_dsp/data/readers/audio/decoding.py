"""A sound file as blocks of samples, by libsndfile; what it can't read becomes one clear line."""

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
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.errors import InputError

_V1, _V2, _V25 = 3, 2, 0
_L1, _L2, _L3 = 3, 2, 1
_RATES = {
    _V1: (44_100, 48_000, 32_000),
    _V2: (22_050, 24_000, 16_000),
    _V25: (11_025, 12_000, 8000),
}
# kbit/s for the bitrate indices 1 to 14
_KBITS = {
    (True, _L1): (32, 64, 96, 128, 160, 192, 224, 256, 288, 320, 352, 384, 416, 448),
    (True, _L2): (32, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320, 384),
    (True, _L3): (32, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320),
    (False, _L1): (32, 48, 56, 64, 80, 96, 112, 128, 144, 160, 176, 192, 224, 256),
    (False, _L2): (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 144, 160),
    (False, _L3): (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 144, 160),
}


def frame_of(header: bytes) -> tuple[int, float] | None:
    """Return the length of the frame that begins with these four bytes, in bytes and in s.

    None if no frame does.
    """
    if len(header) < 4 or header[0] != 0xFF or header[1] & 0xE0 != 0xE0:
        return None
    version, layer = header[1] >> 3 & 3, header[1] >> 1 & 3
    bitrate, rate, padded = header[2] >> 4, header[2] >> 2 & 3, header[2] >> 1 & 1
    if version not in _RATES or layer == 0 or bitrate in (0, 15) or rate == 3:
        return None
    bits = 1000 * _KBITS[version == _V1, layer][bitrate - 1]
    hz = _RATES[version][rate]
    if layer == _L1:
        return (12 * bits // hz + padded) * 4, 384 / hz
    samples = 576 if layer == _L3 and version != _V1 else 1152
    return samples // 8 * bits // hz + padded, samples / hz


def begins_with_frames(head: bytes) -> bool:
    """Return whether a file begins with two frames of one kind."""
    frame = frame_of(head[:4])
    if frame is None:
        return False
    following = head[frame[0] : frame[0] + 4]
    same = frame_of(following) is not None and head[1] == following[1]
    return same and head[2] & 0x0C == following[2] & 0x0C


def frames_of(data: mmap.mmap) -> tuple[float, bool]:
    """Return how long a file's frames last, s, and whether the last one is whole.

    (0, True) where its frames don't follow each other.
    """
    at, seconds = _behind_tag(data), 0.0
    while at + 4 <= len(data):
        header = data[at : at + 4]
        frame = frame_of(header)
        if frame is None:
            # a tag behind the last frame; anything else isn't a plain row of frames
            return (seconds, True) if header[:3] in (b"TAG", b"APE", b"ID3") else (0.0, True)
        if at + frame[0] > len(data):
            return seconds, False
        at, seconds = at + frame[0], seconds + frame[1]
    return seconds, at == len(data)


def _behind_tag(data: mmap.mmap) -> int:
    """Where an ID3v2 tag at the beginning ends (ISO 646 bytes of seven bits)."""
    if data[:3] != b"ID3":
        return 0
    size = 0
    for byte in data[6:10]:
        size = size << 7 | byte & 0x7F
    return 10 + size


MAX_DECODED_MB = 16_384
"""Largest recording that is read, megabytes (2**20 bytes) of 16-bit samples: 27 hours of stereo at
44.1 kHz. It counts what comes out: a small FLAC file of silence may hold months."""

MAX_SAMPLES_PER_S = 4_000_000
"""Most samples a second, all channels together: 80 channels at 48 kHz."""

_OTHER = (
    # (bytes at offset, offset, name): sound or film that libsndfile doesn't open
    (b"ftyp", 4, "an MP4 file (m4a, mp4, mov)"),
    (b"\x1aE\xdf\xa3", 0, "a Matroska file (mkv, webm)"),
    (b"0&\xb2u\x8ef\xcf\x11", 0, "a Windows Media file (wma, wmv)"),
    (b"#!AMR", 0, "an AMR file"),
    (b"\xff\xf1", 0, "an AAC stream"),
    (b"\xff\xf9", 0, "an AAC stream"),
    (b"MAC ", 0, "a Monkey's Audio file"),
    (b"wvpk", 0, "a WavPack file"),
    (b"AVI ", 8, "an AVI film"),
)
_SOUND = (
    (b"WAVE", 8), (b"RF64", 0), (b"AIFF", 8), (b"AIFC", 8), (b"fLaC", 0), (b"OggS", 0),
    (b"caff", 0), (b".snd", 0), (b"dns.", 0), (b"ID3", 0), (b"riff.\x91\xcf\x11", 0),
    (b"Creative RenderJob File", 0), (b"NIST_1A", 0), (b"8SVX", 8), (b"MATLAB 5.0", 0),
)  # fmt: skip
_UNMARKED = frozenset(
    {"htk", "mpc2k", "sds", "sd2", "sf", "ircam", "xi", "wve", "paf", "pvf", "avr"}
)
_CUT = re.compile(r"^\s*(\S[^:\n]*?)\s*: (\d+) \(should be (\d+)\)", re.MULTILINE)
_MASK = re.compile(r"^\s*Channel Mask\s*: 0x([0-9A-F]+)", re.MULTILINE)
# the chunks that hold the samples; W64 and RF64 only report the whole
_SAMPLE_CHUNKS = {"data", "SSND", "Data Size"}
_WHOLE_CHUNKS = {"W64": "riff", "RF64": "Riff size"}
# a size a program writes that doesn't know it yet: 0xffffffff, 0x7ffffff0, 0xfffff000 and the like
_UNKNOWN_FROM = 0x7FFFF000
_OGG_LAST_PAGE = 0x04
_TAIL_BYTES = 65_536 + 512
"""The last page of an Ogg stream begins no further from the end: a page has up to 65307 bytes."""


@dataclass(frozen=True)
class Recording:
    """An open sound file.

    Parameters
    ----------
    where
        The path, printable.
    sample_rate
        Hz.
    frames
        How many its header promises.
    weights
        What each channel's power counts in the loudness.
    kind
        Format, coding, channels and rate, for a person.
    notes
        What was assumed about it.
    """

    where: str
    sample_rate: int
    frames: int
    weights: tuple[float, ...]
    kind: str
    notes: tuple[str, ...]
    _file: Any

    def blocks(self, frames: int) -> Iterator[NDArray[np.floating[Any]]]:
        """Yield the samples in order, float32 or float64 (frames, channels), the last one shorter.

        Each block is overwritten by the next.

        Raises
        ------
        InputError
            The data break off or can't be decoded; the line says at what time.
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
                raise self._broken(done, f"{self.frames / self.sample_rate:.1f} s were announced")
            done += len(block)
            yield block

    def _broken(self, done: int, reason: str) -> InputError:
        return InputError(
            f"{self.where}: the sound breaks off after {done / self.sample_rate:.1f} s "
            f"({reason}); {_repair(self.where)}"
        )


def sounds(source: DataFile) -> bool:
    """Return whether the file is a recording, one that can be read or one to convert first."""
    if _other_format(source) or any(_at(source, mark, offset) for mark, offset in _SOUND):
        return True
    if source.head_text is not None:
        return False
    if begins_with_frames(source.head):
        return True
    # formats without a mark; their names, as libsndfile searches anything else for MPEG frames and
    # prints that it found none
    if source.path.suffix[1:].lower() not in _UNMARKED:
        return False
    import soundfile

    try:
        with open(source.path, "rb") as stream:
            soundfile.SoundFile(stream.fileno(), closefd=False).close()
    except (OSError, soundfile.LibsndfileError):
        return False  # the question was whether it can be opened
    return True


@contextlib.contextmanager
def open_recording(source: DataFile, max_mb: float | None = None) -> Iterator[Recording]:
    """Open a sound file.

    Parameters
    ----------
    source
        A file that `sounds`.
    max_mb
        As `LoadOptions.max_mb`, in place of `MAX_DECODED_MB`.

    Raises
    ------
    InputError
        Not a format libsndfile opens, broken, cut off, without samples, or too long.
    """
    other = _other_format(source)
    if other:
        raise InputError(
            f"{source.where}: {other}, which can't be read; convert it: ffmpeg -i "
            f"{_quoted(source.path.name)} {_quoted(source.path.stem + '.wav')}"
        )
    import soundfile

    try:
        # a descriptor, so that the file's suffix is no hint to its format
        with open(source.path, "rb") as stream:
            try:
                file = soundfile.SoundFile(stream.fileno(), closefd=False)
            except soundfile.LibsndfileError as error:
                if source.head.startswith(b"MATLAB"):  # which libsndfile reads if it is a sound
                    raise InputError(
                        f"{source.where}: a MATLAB file that holds no sound; write its columns as "
                        "CSV (writematrix, or scipy.io.loadmat in Python)"
                    ) from error
                raise InputError(
                    f"{source.where}: a broken or unknown sound file ({_reason(error)}); "
                    f"{_repair(source.where)}"
                ) from error
            with file:
                yield _examined(source, file, max_mb)
    except OSError as error:
        raise InputError(f"{source.where}: can't be read ({error.strerror})") from error


def _examined(source: DataFile, file: Any, max_mb: float | None) -> Recording:
    where, rate, frames, channels = source.where, file.samplerate, file.frames, file.channels
    log: str = file.extra_info
    notes = list(_length_notes(source, file, log))
    if frames <= 0:
        raise InputError(f"{where}: a sound file without samples; {_repair(where)}")
    if rate < MIN_RATE or rate * channels > MAX_SAMPLES_PER_S:
        raise InputError(
            f"{where}: {_count(channels)} at {rate} Hz; loudness is measured from {MIN_RATE} Hz "
            f"up, and of {MAX_SAMPLES_PER_S} samples a second at most, all channels together: "
            "resample it or mix it down"
        )
    limit = max_mb if max_mb is not None else float(MAX_DECODED_MB)
    size = frames * channels * 2 / 2**20
    if size > limit:
        raise InputError(
            f"{where}: {size:.0f} MB of samples ({frames / rate / 3600.0:.1f} h), more than the "
            f"{limit:g} MB that are read; cut it into parts, or raise the limit with max_mb"
        )
    mask = _MASK.search(log)
    weights = weights_of_mask(int(mask[1], 16), channels) if mask else None
    if weights is None:
        layout = layout_of(channels, file.subtype in ("VORBIS", "OPUS"))
        weights = weights_of(layout) if layout else (1.0,) * channels
        if channels > 2:
            speakers = " ".join(layout) if layout else "all alike, as no layout is usual"
            notes.append(f"the {channels} channels are taken as {speakers}")
    if not any(weights):
        weights = (1.0,) * channels  # a lone LFE: something should be heard
    kind = f"{file.format} {file.subtype}, {_count(channels)}, {rate} Hz"
    return Recording(where, rate, frames, weights, kind, tuple(notes), file)


def _length_notes(source: DataFile, file: Any, log: str) -> Iterator[str]:
    """Yield what is odd about the length; InputError where the end of the sound is missing."""
    chunks = {*_SAMPLE_CHUNKS, _WHOLE_CHUNKS.get(file.format, "data")}
    for name, claimed, there in _CUT.findall(log):
        if name not in chunks or int(claimed) <= int(there):
            continue
        if int(claimed) >= _UNKNOWN_FROM and int(claimed) < 2**32:
            yield "its header leaves the length open; read up to the end of the file"
            continue
        part = int(there) / int(claimed)
        raise InputError(
            f"{source.where}: cut off: {100.0 * part:.0f} % of the sound its header announces is "
            f"there ({file.frames / file.samplerate:.1f} s); {_repair(source.where)}"
        )
    if file.format == "OGG" and not _ogg_ends(source):
        yield "the Ogg stream has no end mark: it may have been cut off"
    if file.format == "MP3":
        yield from _mpeg_notes(source, file)


def _mpeg_notes(source: DataFile, file: Any) -> Iterator[str]:
    """Yield what the row of frames says that the decoder doesn't."""
    with (
        open(source.path, "rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        seconds, whole = frames_of(data)
    if not whole:
        yield "its last frame isn't whole: it may have been cut off"
    read_s = file.frames / file.samplerate
    if seconds > 1.0 + 1.01 * read_s:
        yield (
            f"its frames last {seconds:.1f} s, of which {read_s:.1f} s are read, as no header says "
            f"so; {_repair(source.where)}"
        )


def _ogg_ends(source: DataFile) -> bool:
    with open(source.path, "rb") as stream:
        stream.seek(max(0, source.size - _TAIL_BYTES))
        tail = stream.read()
    last = tail.rfind(b"OggS")
    return 0 <= last < len(tail) - 6 and bool(tail[last + 5] & _OGG_LAST_PAGE)


def _other_format(source: DataFile) -> str | None:
    return next((name for mark, offset, name in _OTHER if _at(source, mark, offset)), None)


def _at(source: DataFile, mark: bytes, offset: int) -> bool:
    return source.head[offset : offset + len(mark)] == mark


def _reason(error: Any) -> str:
    """Return libsndfile's words for an error, without its dots and prefixes."""
    words = str(error.error_string).removeprefix("Error : ").strip(" .")
    return words or f"libsndfile error {error.code}"


def _repair(where: str) -> str:
    return f"get it again, or try to repair it: ffmpeg -i {_quoted(where)} repaired.wav"


def _quoted(name: str) -> str:
    return f"'{name}'" if " " in name else name


def _count(channels: int) -> str:
    return {1: "mono", 2: "stereo"}.get(channels, f"{channels} channels")
