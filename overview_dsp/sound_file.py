"""Sound files: any libsndfile format, whole or absent, with dither where the format needs it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, OutputError
from overview_dsp.files import output_error, whole_file

DEFAULT_SUBTYPE = "PCM_24"
_DITHERED_BITS = {"PCM_S8": 8, "PCM_U8": 8, "PCM_16": 16}
_DITHER_SEED = 1


def _format_of(path: Path, subtype: str | None) -> tuple[str, str]:
    import soundfile

    known = soundfile.available_formats()
    name = path.suffix[1:].upper()
    name = {"AIF": "AIFF", "OGA": "OGG", "OPUS": "OGG"}.get(name, name)
    if name not in known or name == "RAW":
        some = "wav, flac, aiff, ogg, caf, w64, rf64"
        raise InputError(f"{path}: no sound format is called {path.suffix!r}; use {some}")
    allowed = soundfile.available_subtypes(name)
    if subtype is None:
        chosen = DEFAULT_SUBTYPE if DEFAULT_SUBTYPE in allowed else soundfile.default_subtype(name)
        return name, "OPUS" if path.suffix.lower() == ".opus" else chosen
    chosen = subtype.upper()
    if chosen not in allowed:
        raise InputError(
            f"{path}: {name} has no subtype {subtype!r}; it has {', '.join(sorted(allowed))}"
        )
    return name, chosen


class SoundWriter:
    """A sound file that is written block by block and appears, whole, when it is done.

    `note` says how samples were stored. PCM of 16 or fewer bits gets triangular (TPDF) dither from
    a fixed seed; exact zeros stay exact zeros.
    """

    def __init__(self, path: Path, sample_rate: float, subtype: str | None = None) -> None:
        """Choose the format; InputError if there is none, or a rate a file can't hold."""
        if sample_rate != int(sample_rate):
            raise InputError(
                f"{path}: a file's sample rate is a whole number, not {sample_rate:g} Hz; "
                f"use {round(sample_rate)}"
            )
        self.path = path
        self.frames = 0
        self._rate = int(sample_rate)
        self._format, self._subtype = _format_of(path, subtype)
        self._bits = _DITHERED_BITS.get(self._subtype)
        self._random = np.random.default_rng(_DITHER_SEED)
        self._stack = contextlib.ExitStack()
        dither = f"TPDF dither at {self._bits} bits" if self._bits else "no dither"
        self.note = f"{self._format} {self._subtype}, {dither}"
        self._file: Any = None

    def __enter__(self) -> SoundWriter:
        import soundfile

        temporary = self._stack.enter_context(whole_file(self.path))
        try:
            self._file = self._stack.enter_context(
                soundfile.SoundFile(
                    str(temporary),
                    "w",
                    samplerate=self._rate,
                    channels=2,
                    subtype=self._subtype,
                    format=self._format,
                )
            )
        except soundfile.LibsndfileError as error:
            self._stack.close()
            temporary.unlink(missing_ok=True)
            raise InputError(f"{self.path}: {error.error_string}") from None
        return self

    def write(self, samples: NDArray[np.float32]) -> None:
        """Append float32 (frames, 2)."""
        import soundfile

        data: NDArray[Any] = samples
        if self._bits:
            step = 2.0 ** (1 - self._bits)
            noise = self._random.random((2, *samples.shape))
            data = samples + np.where(samples == 0.0, 0.0, (noise[0] - noise[1]) * step)
        try:
            self._file.write(data)
        except soundfile.LibsndfileError as error:
            raise OutputError(
                f"{self.path}: {error.error_string.strip(' .')}; nothing was left behind, "
                "free some space and retry"
            ) from None
        except OSError as error:
            raise output_error(self.path, error) from None
        self.frames += len(samples)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.__exit__(kind, error, traceback)


def save_sound(
    path: str | os.PathLike[str],
    samples: NDArray[np.float32],
    sample_rate: float,
    subtype: str | None = None,
) -> None:
    """Write float32 (frames, 2) to a sound file."""
    with SoundWriter(Path(path), sample_rate, subtype) as sound:
        sound.write(samples)
