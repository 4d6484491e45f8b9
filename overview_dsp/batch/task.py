"""Tasks of a worker: render some cases, store the sounds, and write the measurements to parts.

Measurements are length, levels, felt events and hashes. A part is written after its sounds, so each
case in a part is finished.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from overview_dsp.arrays import SampleArray
from overview_dsp.batch.grid import RenderGrid
from overview_dsp.batch.manifest import PARTS, SOUNDS, encode_part
from overview_dsp.batch.storage import Storage
from overview_dsp.data.analysis.loudness import MIN_RATE, StepMeter
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.errors import OutputError, OverviewError
from overview_dsp.files.sound import sound_bytes
from overview_dsp.measure.perceived_level import event_levels
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, VoiceRenderer
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.cache import SurfaceCache
from overview_dsp.units import gain_to_db

MEASURED_COLUMNS = ("engaged", "cursor")  # columns of the trace that the measurements need


def measure_render(result: RenderedJob[Trace | None], data: bytes) -> dict[str, Any]:
    """Measure a render (with its trace) that is stored as `data`."""
    samples = np.ascontiguousarray(result.samples, "<f4")
    return {
        "frames": len(result.samples),
        "duration_s": len(result.samples) / result.sample_rate,
        "peak_click_dbfs": _peak_db(result.samples[:, 0]),
        "peak_tactor_dbfs": _peak_db(result.samples[:, 1]),
        "loudness_lufs": _loudness(result.samples[:, :1], result.sample_rate),
        "strikes": len(result.strikes),
        "felt": _felt(result),
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "samples_sha256": hashlib.sha256(samples.data).hexdigest(),
    }


def _peak_db(signal: SampleArray) -> float | None:
    peak = float(np.abs(signal).max(initial=0.0))
    return gain_to_db(peak) if peak > 0.0 else None


def _loudness(click: SampleArray, sample_rate: float) -> float | None:
    """Return the integrated loudness of the clicks (BS.1770), LUFS; None below 4000 Hz."""
    if sample_rate < MIN_RATE or not len(click):
        return None
    meter = StepMeter(int(sample_rate), (1.0,))
    for first in range(0, len(click), meter.block_frames):
        meter.feed(click[first : first + meter.block_frames])
    return meter.finish().integrated()


def _felt(result: RenderedJob[Trace | None]) -> list[dict[str, Any]]:
    """Return the events that the disk passed, in the order of their positions."""
    assert result.trace is not None
    surface, events = result.surface, result.job.timeline.events
    levels = event_levels(surface, result.trace, result.samples[:, 1], result.sample_rate)
    felt = np.isfinite(levels)
    return [
        {"event": event, "kind": events[event].kind, "level_db": level}
        for event, level in zip(surface.event[felt].tolist(), levels[felt].tolist(), strict=True)
    ]


PART_S = 2.0  # longest time between parts, s: a crash loses no more work
Job = tuple[int, str]  # index and key of a case


@dataclass(frozen=True)
class TaskResult:
    """Results of one task: number of finished cases; index and error of each failed case."""

    finished: int
    failed: tuple[tuple[int, str], ...]


class Worker:
    """Renderer of cases that reuses surfaces and memory. Thread: any; one memory block each."""

    def __init__(self, grid: RenderGrid) -> None:
        """Open the output folder; nothing is rendered yet."""
        self.grid = grid
        self.storage = Storage(grid.out)
        self._renderer = VoiceRenderer(grid.settings.sample_rate, SurfaceCache())
        # seeds change fastest: the preset of the last case fits the next one
        self._preset = lru_cache(maxsize=1)(self._changed_preset)

    def run(self, jobs: Sequence[Job]) -> TaskResult:
        """Render, measure and store some cases; the result lists failed cases.

        InputError or OutputError if the output folder can't be written.
        """
        rows: list[dict[str, Any]] = []
        failed: list[tuple[int, str]] = []
        written = time.monotonic()

        def fail(number: int, error: Exception) -> None:
            index, key = jobs[number]
            what = str(error) if isinstance(error, OverviewError) else repr(error)
            failed.append((index, what))
            rows.append({"key": key, "error": what})

        def voices() -> Iterator[tuple[int, RenderJob]]:
            for number, (index, _) in enumerate(jobs):
                try:
                    case = self.grid.case(index)
                    timeline = list(self.grid.timelines.values())[case.timeline]
                    gesture = list(self.grid.gestures.values())[case.gesture]
                    preset = self._preset(case.preset, case.values)
                    voice = RenderJob(timeline, preset, gesture, case.seed)
                except Exception as error:
                    fail(number, error)
                else:
                    yield number, voice

        tail = self.grid.settings.tail
        for number, result in self._renderer.render(voices(), tail, MEASURED_COLUMNS):
            try:
                if isinstance(result, Exception):
                    raise result
                key, settings = jobs[number][1], self.grid.settings
                name = f"{SOUNDS}/{key[:2]}/{key}.{settings.format}"
                data = sound_bytes(name, result.samples, result.sample_rate, settings.subtype)
                row = {"key": key, "file": name, **measure_render(result, data)}
            except OutputError:
                raise
            except Exception as error:
                fail(number, error)
            else:
                self.storage.put(name, data)
                rows.append(row)
            if time.monotonic() - written > PART_S:
                self._write_part(rows)
                written = time.monotonic()
        self._write_part(rows)
        return TaskResult(len(jobs) - len(failed), tuple(failed))

    def _write_part(self, rows: list[dict[str, Any]]) -> None:
        if rows:
            name = f"{PARTS}/{rows[0]['key']}-{len(rows)}.jsonl"
            self.storage.put(name, encode_part(rows))
            rows.clear()

    def _changed_preset(self, number: int, values: tuple[Value, ...]) -> Preset:
        preset = list(self.grid.presets.values())[number]
        for id, value in zip(self.grid.parameters, values, strict=True):
            preset = preset.with_value(id, value)
        return preset
