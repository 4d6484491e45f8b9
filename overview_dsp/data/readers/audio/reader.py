"""Reader of recordings (WAV, FLAC, Ogg, MP3, AIFF): loudness as the curve, cheers as the events.

The file is read as a stream, and only ten loudness values per second are stored. `map` selects the
curve:

| map | curve | unit |
|---|---|---|
| `loudness` (default) | short-term loudness, over 3 s | LUFS |
| `momentary` | momentary loudness, over 0.4 s | LUFS |
| `excitement` | loudness over 1 s above a slowly moving background (`cheers.py`) | LU |

Averaging windows are centred on their time and shortened at the ends. Silence is -70 LUFS, the
absolute gate of the standard. Missing samples (NaN or infinite, in a float file) for 0.1 s or
longer are a gap.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis import cheers, loudness
from overview_dsp.data.readers.audio.channels import layout_of, weights_of
from overview_dsp.data.readers.audio.decoding import Recording, is_recording, open_recording
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.data.timeline.model import Intensity, Timeline
from overview_dsp.errors import InputError, quoted

_CURVES = {
    "loudness": (loudness.SHORT_TERM_STEPS, "LUFS", "short-term loudness (3 s)"),
    "momentary": (loudness.MOMENTARY_STEPS, "LUFS", "momentary loudness (0.4 s)"),
    "excitement": (None, "LU", "loudness over 1 s above the background of two minutes"),
}
"""Window in steps (None: above the background), unit and meaning of each map."""

MAPS = tuple(_CURVES)
"""Values of the option `map`."""


def sniff(source: DataFile) -> bool:
    """Return whether the file is a recording, including formats that must be converted first."""
    return is_recording(source)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a recording (takes `map`, `max_mb`, `progress`).

    InputError: the format is not supported, the file is invalid, truncated or too long, or the map
    is unknown.
    """
    map_name = options.map if options.map is not None else MAPS[0]
    if map_name not in MAPS:
        raise InputError(
            f"map is {quoted(map_name)}; must be one of {', '.join(MAPS)} for a recording"
        )
    with open_recording(source, options.max_mb) as recording:
        steps = _measure(recording, options)
        kind, notes = recording.kind, recording.notes
    return timeline_of(steps, map_name, source.stem, kind, notes)


def _measure(recording: Recording, options: LoadOptions) -> loudness.Steps:
    meter = loudness.StepMeter(recording.sample_rate, recording.weights)
    done = 0
    for block in recording.blocks(min(meter.block_frames, recording.frames)):
        meter.feed(block)
        done += len(block)
        options.report_progress(done / recording.frames)
    return meter.finish()


def read_samples(samples: FloatArray, options: LoadOptions) -> Timeline:
    """Return the timeline of samples in memory, frames x channels (takes `rate`, `map`)."""
    frames, channels = samples.shape
    rate = options.rate
    assert rate is not None
    if not float(rate).is_integer():
        raise InputError(f"rate is {rate!r}; must be a whole number of Hz for a sound")
    layout = layout_of(channels)
    meter = loudness.StepMeter(int(rate), weights_of(layout) if layout else (1.0,) * channels)
    size = min(meter.block_frames, frames)
    for begin in range(0, frames, size):
        meter.feed(samples[begin : begin + size])
        options.report_progress(min(1.0, (begin + size) / frames))
    kind = f"a sound in memory, {channels} channel{'s' * (channels > 1)} at {rate:g} Hz"
    note = "samples of 8 kHz and more are a sound; map='level' (--map level) makes a series of them"
    return timeline_of(meter.finish(), options.map or MAPS[0], "", kind, (note,))


def timeline_of(
    steps: loudness.Steps, map_name: str, title: str, kind: str, notes: tuple[str, ...]
) -> Timeline:
    """Return the timeline of a measured recording; `map_name` is one of `MAPS`."""
    duration_s = steps.frames / steps.sample_rate
    time_s = np.append(np.arange(len(steps.energy)) / loudness.STEPS_PER_S, duration_s)
    rate = steps.sample_rate
    gaps = tuple((first / rate, end / rate) for first, end in steps.missing)
    integrated = steps.integrated()
    loudness_1s = steps.loudness(cheers.WINDOW_STEPS)
    loudness_1s[in_gap(gaps, time_s)] = np.nan
    if np.isnan(loudness_1s).all():
        raise InputError("no sample is a number; record the sound again")
    above = cheers.excitement(loudness_1s, cheers.background(loudness_1s, integrated))
    events = cheers.peaks(above, time_s)
    window, unit, meaning = _CURVES[map_name]
    value = above if window is None else steps.loudness(window)
    known = ~np.isnan(value) & ~in_gap(gaps, time_s)
    if steps.lost:
        notes = (*notes, f"{steps.lost} single samples are missing and were omitted")
    notes = (
        *notes,
        f"integrated loudness {integrated:.1f} LUFS; the curve is the {meaning}, from "
        f"{value[known].min():.1f} to {value[known].max():.1f} {unit}",
    )
    return Timeline(
        title=title,
        duration_s=duration_s,
        events=events,
        intensity=Intensity(time_s[known], value[known], unit),
        gaps=gaps,
        provenance=f"{kind}; loudness by ITU-R BS.1770-5 and EBU R 128; events: peaks of the "
        "loudness over 1 s above its background",
        notes=notes,
    )
