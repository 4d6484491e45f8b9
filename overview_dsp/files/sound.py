"""Sound files: any libsndfile format, written atomically, with dither for few bits; cue points.

The bytes of short WAV files are packed here, several times faster than by libsndfile, which
converts one sample at a time. The header comes from libsndfile, so the bytes are identical.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import shutil
import struct
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import SampleArray
from overview_dsp.errors import InputError, OutputError
from overview_dsp.files.atomic import atomic_file, output_error, output_errors

PACKED = {"PCM_16": 2, "PCM_24": 3, "PCM_32": 4}
"""Bytes per sample of the subtypes that are packed here."""

_NO_DATA = b"data" + struct.pack("<I", 0)


def with_samples(empty: bytes, subtype: str, samples: NDArray[Any]) -> bytes | None:
    """Return the WAV file `empty` with samples; None if its header has an unexpected form.

    The last chunk of `empty` is `data`. `subtype` is one of `PACKED`. `samples` (frames, channels)
    are int16 or int32, quantized in the upper bits.
    """
    data = _packed(samples, PACKED[subtype])
    size = len(empty) + len(data) + len(data) % 2
    if not (empty[:4] == b"RIFF" and empty.endswith(_NO_DATA) and size < 2**32):
        return None
    head = b"RIFF" + struct.pack("<I", size - 8) + empty[8:-4] + struct.pack("<I", len(data))
    return head + data + bytes(len(data) % 2)


def _packed(samples: NDArray[Any], width: int) -> bytes:
    little = np.ascontiguousarray(samples, samples.dtype.newbyteorder("<"))
    if little.itemsize == width:
        return little.tobytes()
    wide = little.view(np.uint8).reshape(-1, little.itemsize)
    packed = np.empty((len(wide), width), np.uint8)
    for byte in range(width):
        packed[:, byte] = wide[:, byte - width]
    return packed.tobytes()


DEFAULT_SUBTYPE = "PCM_24"
_BITS = {"PCM_S8": 8, "PCM_U8": 8, "PCM_16": 16, "ALAC_16": 16, "PCM_24": 24, "PCM_32": 32}
_DITHERED_BITS = 16
_SYSTEM_ERROR = 2  # libsndfile's SF_ERR_SYSTEM
_DITHER_SEED = 1
_HEADER = 128  # bytes, within which libsndfile's PEAK chunk begins
_PIECE = 4096  # frames written at a time: libsndfile's Ogg encoder overflows its stack on long ones


@cache
def _subtypes() -> dict[str, tuple[str, ...]]:
    """Return the subtypes of each format of this libsndfile, cached: a query takes 0.5 ms."""
    import soundfile

    return {
        name: tuple(soundfile.available_subtypes(name)) for name in soundfile.available_formats()
    }


def _format_of(path: Path, subtype: str | None) -> tuple[str, str]:
    import soundfile

    known = _subtypes()
    name = path.suffix[1:].upper()
    name = {"AIF": "AIFF", "OGA": "OGG", "OPUS": "OGG"}.get(name, name)
    # RAW has no header; SD2 needs a second file
    if name not in known or name in ("RAW", "SD2"):
        some = "wav, flac, aiff, ogg, caf, w64, rf64"
        raise InputError(f"{path}: no sound format has the suffix {path.suffix!r}; use {some}")
    allowed = known[name]
    if subtype is None:
        chosen = DEFAULT_SUBTYPE if DEFAULT_SUBTYPE in allowed else soundfile.default_subtype(name)
        return name, "OPUS" if path.suffix.lower() == ".opus" else chosen
    chosen = str(subtype).upper()
    if chosen not in allowed:
        raise InputError(
            f"{path}: {name} has no subtype {subtype!r}; allowed: {', '.join(sorted(allowed))}"
        )
    return name, chosen


def _require_whole_rate(path: Path, sample_rate: float) -> int:
    """Return a whole sample rate; InputError for any other."""
    if not math.isfinite(sample_rate) or sample_rate != int(sample_rate):
        near = round(sample_rate) if math.isfinite(sample_rate) else 48_000
        raise InputError(
            f"{path}: sample rate is {sample_rate:.15g} Hz; must be a whole number, such as {near}"
        )
    return int(sample_rate)


class _Quantizer:
    """Quantization of consecutive blocks to a subtype, with dither for 16 or fewer bits."""

    def __init__(self, subtype: str) -> None:
        self._bits = _BITS.get(subtype, 0)
        self._dithered = 0 < self._bits <= _DITHERED_BITS
        self._random = np.random.default_rng(_DITHER_SEED) if self._dithered else None
        self.note = f"TPDF dither at {self._bits} bits" if self._dithered else "no dither"

    def __call__(self, samples: SampleArray) -> NDArray[Any]:
        """Return samples as steps in the upper bits of int16 or int32; floats don't change.

        libsndfile would round down, a constant offset of half a step.
        """
        if not self._bits:
            return samples
        top = 2.0 ** (self._bits - 1)
        # float32 holds every step of 24 bits
        exact = np.float32 if self._random is None and self._bits <= 24 else np.float64
        steps: NDArray[Any] = np.multiply(samples, top, dtype=exact)
        if self._random is not None:
            # per frame, so that the block size changes nothing
            noise = self._random.random((*samples.shape, 2))
            steps += np.where(samples == 0.0, 0.0, noise[..., 0] - noise[..., 1])
        np.clip(np.rint(steps, out=steps), -top, top - 1.0, out=steps)
        width = 16 if self._dithered else 32
        return steps.astype(f"i{width // 8}") << (width - self._bits)


class SoundWriter(contextlib.ExitStack):
    """Writer of a sound file in blocks; the file appears when it is complete.

    `note` describes the format. PCM of 16 or fewer bits gets triangular (TPDF) dither from a fixed
    seed; exact zeros stay exact zeros.
    """

    def __init__(
        self, path: Path, sample_rate: float, subtype: str | None = None, channels: int = 2
    ) -> None:
        """Choose the format; InputError for an unknown format or an unsupported rate."""
        super().__init__()
        self.path = path
        self.frames = 0
        self._rate = _require_whole_rate(path, sample_rate)
        self._channels = channels
        self._format, self._subtype = _format_of(path, subtype)
        self._quantize = _Quantizer(self._subtype)
        self.note = f"{self._format} {self._subtype}, {self._quantize.note}"
        self._file: Any = None

    def __enter__(self) -> SoundWriter:
        import soundfile

        # after an error, the inner stack deletes the temporary file
        with contextlib.ExitStack() as stack:
            temporary = stack.enter_context(atomic_file(self.path))
            try:
                self._file = soundfile.SoundFile(
                    str(temporary),
                    "w",
                    samplerate=self._rate,
                    channels=self._channels,
                    subtype=self._subtype,
                    format=self._format,
                )
            except soundfile.LibsndfileError as error:
                if error.code == _SYSTEM_ERROR:
                    raise self._disk_error(error) from None
                raise _cannot_hold(
                    self.path, self._format, self._subtype, self._channels, self._rate, error
                ) from None
            stack.push(self._close)
            self.push(stack.pop_all())
        return self

    def write(self, samples: SampleArray) -> None:
        """Append float32 (frames, channels)."""
        data = self._quantize(samples)
        with self._disk_errors():
            self._file.write(data)
        self.frames += len(samples)

    def finish(self) -> None:
        """Flush and close the file; an error means that the disk is full."""
        if self._file is not None:
            file, self._file = self._file, None
            with self._disk_errors():
                file.close()

    def _close(self, kind: type[BaseException] | None, *_: object) -> None:
        # after an error the file is deleted, so further errors don't matter
        ignored = () if kind is None else (OutputError, InputError)
        with contextlib.suppress(*ignored):
            self.finish()

    @contextlib.contextmanager
    def _disk_errors(self) -> Iterator[None]:
        import soundfile

        try:
            yield
        # soundfile asserts that all frames were written
        except (soundfile.LibsndfileError, AssertionError) as error:
            raise self._disk_error(error) from None
        except OSError as error:
            raise output_error(self.path, error) from None

    def _disk_error(self, error: Exception) -> OutputError:
        reason = str(getattr(error, "error_string", "")).strip(" .") or "fewer bytes written"
        return OutputError(
            f"{self.path}: the disk is full or broken ({reason}); nothing was left behind, "
            "free some space and retry"
        )


def save_sound(
    path: str | os.PathLike[str],
    samples: SampleArray,
    sample_rate: float,
    subtype: str | None = None,
) -> None:
    """Write float32 (frames, channels) to a sound file."""
    with SoundWriter(Path(path), sample_rate, subtype, samples.shape[1]) as sound:
        for first in range(0, len(samples), _PIECE):
            sound.write(samples[first : first + _PIECE])


def check_sound(name: str, sample_rate: float, subtype: str | None = None) -> None:
    """Check that a format can hold two channels at a rate; InputError otherwise."""
    sound_bytes(name, np.zeros((1, 2), np.float32), sample_rate, subtype)


def sound_bytes(
    name: str, samples: SampleArray, sample_rate: float, subtype: str | None = None
) -> bytes:
    """Return a sound file as bytes; `name` has its suffix, samples are (frames, channels)."""
    import soundfile

    path = Path(name)
    rate = _require_whole_rate(path, sample_rate)
    form, chosen = _format_of(path, subtype)
    data = _Quantizer(chosen)(samples)
    try:
        if form == "WAV" and chosen in PACKED:
            packed = with_samples(_empty(rate, data.shape[1], chosen), chosen, data)
            if packed is not None:
                return packed
        return _encoded(data, rate, form, chosen)
    except soundfile.LibsndfileError as error:
        raise _cannot_hold(path, form, chosen, samples.shape[1], rate, error) from None


@lru_cache
def _empty(rate: int, channels: int, subtype: str) -> bytes:
    """Return a WAV file without samples."""
    return _encoded(np.zeros((0, channels), np.int32), rate, "WAV", subtype)


def _encoded(data: NDArray[Any], rate: int, form: str, subtype: str) -> bytes:
    """Return the bytes of a sound file as libsndfile writes them, without a time stamp."""
    import soundfile

    file = io.BytesIO()
    with soundfile.SoundFile(
        file, "w", samplerate=rate, channels=data.shape[1], subtype=subtype, format=form
    ) as sound:
        piece = _PIECE if form == "OGG" else max(1, len(data))
        for first in range(0, len(data), piece):
            sound.write(data[first : first + piece])
    peak = file.getvalue()[:_HEADER].find(b"PEAK")
    if form in ("WAV", "AIFF") and peak >= 0:
        # the time stamp: the same samples must give the same bytes
        file.seek(peak + 12)
        file.write(bytes(4))
    return file.getvalue()


FLAC_CHANNELS = 8  # most channels of a FLAC file


def _cannot_hold(
    path: Path, form: str, subtype: str, channels: int, rate: int, error: Any
) -> InputError:
    reason = error.error_string.removeprefix("Error : ").strip(" .")
    return InputError(
        f"{path}: {form} {subtype} can't hold {channels} channels at {rate} Hz ({reason}); "
        f"use wav{' or flac' if channels <= FLAC_CHANNELS else ''}, or another rate"
    )


class SavableSound:
    """Mixin with `save`, for `samples`, float32 (frames, channels), at a `sample_rate` (Hz)."""

    samples: SampleArray
    sample_rate: float

    def save(self, path: str | os.PathLike[str], subtype: str | None = None) -> None:
        """Write the samples to a sound file, complete or not at all.

        Parameters
        ----------
        path : str or path
            File whose suffix selects the format (WAV, FLAC, any other of libsndfile).
        subtype : str or None
            Sample format of libsndfile (`"PCM_16"`, `"FLOAT"`); None: default of the format.

        Raises
        ------
        InputError
            An unknown format, a sample rate that isn't a whole number, or a file that can't be
            written.
        OutputError
            The disk is full.

        Examples
        --------
        >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
        >>> result.save("sweep.wav", subtype="PCM_16")
        >>> jobs = ov.render_jobs([match], [football], [ov.tap(0.5, 0.1), ov.tap(0.9, 0.1)])
        >>> for number, rendered in enumerate(ov.render_many(jobs, sample_rate=8000)):
        ...     rendered.save(f"tap-{number}.wav")
        """
        save_sound(path, self.samples, self.sample_rate, subtype)


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
    with output_errors(path):
        with open(path, "rb") as file:
            head = file.read(12)
        size = path.stat().st_size
    if head[:4] != b"RIFF" or head[8:] != b"WAVE":
        raise InputError(f"{path}: cue points need a .wav file; use a transcript for other formats")
    padding = bytes(size % 2)
    if size + len(padding) + len(chunks) - 8 > MAX_BYTES:
        raise InputError(f"{path}: cue points make the WAV file larger than 4 GB; use a transcript")
    with atomic_file(path) as temporary:
        shutil.copyfile(path, temporary)
        with open(temporary, "r+b") as file:
            file.seek(0, 2)
            file.write(padding + chunks)
            file.seek(4)
            file.write(struct.pack("<I", size + len(padding) + len(chunks) - 8))
