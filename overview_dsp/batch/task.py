"""Tasks of a worker: render some cases, store the sounds, and write the measurements to parts.

A part is written after its sounds, so each case in a part is finished.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp.batch.grid import Case, RenderGrid
from overview_dsp.batch.manifest import PARTS, SOUNDS, encode_part
from overview_dsp.batch.measurements import MEASURED_COLUMNS, measure_render
from overview_dsp.batch.storage import Storage
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.errors import OutputError, OverviewError
from overview_dsp.files.sound import sound_bytes
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, VoiceRenderer
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.cache import SurfaceCache

PART_S = 2.0
"""Longest time between parts, s: a crash loses no more work."""

Job = tuple[int, str]
"""Index and key of a case."""


@dataclass(frozen=True)
class TaskResult:
    """Results of one task: number of finished cases; index and error of each failed case."""

    finished: int
    failed: tuple[tuple[int, str], ...]


def sound_name(key: str, format: str) -> str:
    """Return the name of the sound file of a case."""
    return f"{SOUNDS}/{key[:2]}/{key}.{format}"


class Worker:
    """Renderer of cases that reuses surfaces and memory. Thread: any; one memory block each."""

    def __init__(self, grid: RenderGrid) -> None:
        """Open the output folder; nothing is rendered yet."""
        self.grid = grid
        self.storage = Storage(grid.out)
        self._surfaces = SurfaceCache()
        self._own = threading.local()
        self._last_preset: dict[tuple[int, tuple[Value, ...]], Preset] = {}

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
                    voice = self._voice(self.grid.case(index))
                except Exception as error:
                    fail(number, error)
                else:
                    yield number, voice

        tail = self.grid.settings.tail
        for number, result in self._renderer().render(voices(), tail, MEASURED_COLUMNS):
            try:
                if isinstance(result, Exception):
                    raise result
                name, data, row = self._measured(result, jobs[number][1])
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

    def _voice(self, case: Case) -> RenderJob:
        timeline = list(self.grid.timelines.values())[case.timeline]
        gesture = list(self.grid.gestures.values())[case.gesture]
        return RenderJob(timeline, self._preset(case), gesture, case.seed)

    def _measured(
        self, result: RenderedJob[Trace | None], key: str
    ) -> tuple[str, bytes, dict[str, Any]]:
        settings = self.grid.settings
        name = sound_name(key, settings.format)
        data = sound_bytes(name, result.samples, result.sample_rate, settings.subtype)
        return name, data, {"key": key, "file": name, **measure_render(result, data)}

    def _preset(self, case: Case) -> Preset:
        at = (case.preset, case.values)
        # seeds change fastest: the preset of the last case fits the next one
        preset = self._last_preset.get(at)
        if preset is None:
            preset = list(self.grid.presets.values())[case.preset]
            for id, value in zip(self.grid.parameters, case.values, strict=True):
                preset = preset.with_value(id, value)
            self._last_preset = {at: preset}
        return preset

    def _renderer(self) -> VoiceRenderer:
        if not hasattr(self._own, "renderer"):
            self._own.renderer = VoiceRenderer(self.grid.settings.sample_rate, self._surfaces)
        renderer: VoiceRenderer = self._own.renderer
        return renderer
