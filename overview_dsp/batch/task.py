"""A worker's part: some cases of a study to sounds, and what was measured to parts.

A part is written when its sounds are there, so whatever is in a part is finished.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp.batch.grid import Case, RenderGrid
from overview_dsp.batch.manifest import PARTS, SOUNDS, encode_part
from overview_dsp.batch.measurements import MEASURED_COLUMNS, measures
from overview_dsp.batch.storage import Storage
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Value
from overview_dsp.errors import OutputError, OverviewError
from overview_dsp.files.sound import sound_bytes
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, VoiceRenderer
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.cache import SurfaceCache

PART_S = 2.0
"""A part is written at least so often: what a crash takes with it is no more."""

Job = tuple[int, str]
"""A case's index and key."""


@dataclass(frozen=True)
class TaskResult:
    """What a worker reports of its cases: how many were finished, and which failed why."""

    finished: int
    failed: tuple[tuple[int, str], ...]


def sound_name(key: str, format: str) -> str:
    """The name of a case's sound in the study's place."""
    return f"{SOUNDS}/{key[:2]}/{key}.{format}"


class Worker:
    """What one worker keeps between its tasks. Thread: any; a memory block a thread."""

    def __init__(self, study: RenderGrid) -> None:
        """Open the study's place; nothing is rendered yet."""
        self.study = study
        self.place = Storage(study.out)
        self._surfaces = SurfaceCache()
        self._own = threading.local()
        self._last_preset: dict[tuple[int, tuple[Value, ...]], Preset] = {}

    def run(self, jobs: Sequence[Job]) -> TaskResult:
        """Render, measure and store some cases; those that can't be rendered are reported.

        Raises
        ------
        InputError, OutputError
            The study's place can't be written: no case can.
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
                    voice = self._voice(self.study.case(index))
                except Exception as error:
                    fail(number, error)
                else:
                    yield number, voice

        tail = self.study.settings.tail
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
                self.place.put(name, data)
                rows.append(row)
            if time.monotonic() - written > PART_S:
                self._keep(rows)
                written = time.monotonic()
        self._keep(rows)
        return TaskResult(len(jobs) - len(failed), tuple(failed))

    def _keep(self, rows: list[dict[str, Any]]) -> None:
        if rows:
            name = f"{PARTS}/{rows[0]['key']}-{len(rows)}.jsonl"
            self.place.put(name, encode_part(rows))
            rows.clear()

    def _voice(self, case: Case) -> RenderJob:
        timeline = list(self.study.timelines.values())[case.timeline]
        gesture = list(self.study.gestures.values())[case.gesture]
        return RenderJob(timeline, self._preset(case), gesture, case.seed)

    def _measured(
        self, result: RenderedJob[Trace | None], key: str
    ) -> tuple[str, bytes, dict[str, Any]]:
        settings = self.study.settings
        name = sound_name(key, settings.format)
        data = sound_bytes(name, result.samples, result.sample_rate, settings.subtype)
        return name, data, {"key": key, "file": name, **measures(result, data)}

    def _preset(self, case: Case) -> Preset:
        at = (case.preset, case.values)
        # seeds change fastest: the last one is the next
        preset = self._last_preset.get(at)
        if preset is None:
            preset = list(self.study.presets.values())[case.preset]
            for id, value in zip(self.study.parameters, case.values, strict=True):
                preset = preset.with_value(id, value)
            self._last_preset = {at: preset}
        return preset

    def _renderer(self) -> VoiceRenderer:
        if not hasattr(self._own, "renderer"):
            self._own.renderer = VoiceRenderer(self.study.settings.sample_rate, self._surfaces)
        renderer: VoiceRenderer = self._own.renderer
        return renderer
