"""The same number for the same event from the report, its picture, `tune` and the observer."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import sweep
from overview_dsp.measure.event_table import felt_events
from overview_dsp.measure.observer.strokes import passed_events
from overview_dsp.measure.pictures import plot_feel
from overview_dsp.measure.report import feel_report
from overview_dsp.measure.tuning import RATE, _Search
from overview_dsp.offline.rendering.many import RenderJob, render_many
from overview_dsp.signal.actuators.model import pacinian_db
from tests.feel.whole_matches import real_matches

SWEEPS = {"1 s": sweep(1.0), "4 s": sweep(4.0)}


@pytest.fixture(scope="module")
def matches(data_folder):
    return real_matches(data_folder)


@pytest.mark.parametrize("name", ["football", "football-discreet"])
def test_report_picture_and_tuning_have_the_medians_of_the_table_of_events(matches, name):
    preset = ov.load_preset(name)
    weight = pacinian_db(preset.number("tactor.frequency_hz"))
    for match in matches:
        tables = {one.name: one for one in felt_events(preset, [match], SWEEPS, RATE)}
        report = feel_report(preset, [match], SWEEPS, RATE)
        target = tuple(dict.fromkeys(kind.kind for kind in report.strokes[0].kinds))
        search = _Search(preset, target, (match,), SWEEPS)
        tuned = search.measured(preset, target)
        cells = [text.get_text() for text in plot_feel(report).axes[0].texts]
        drawn = np.array(cells).reshape(-1, len(report.strokes))
        kinds = list(dict.fromkeys(kind.kind for one in report.strokes for kind in one.kinds))
        for column, stroke in enumerate(report.strokes):
            table = tables[stroke.name]
            for kind in stroke.kinds:
                assert repr(tuned[stroke.name, 0][kind.kind]) == repr(kind)
                rows = table.kind == kind.kind
                felt = rows & np.isfinite(table.level_db)
                assert kind.missed == (rows & ~felt).sum()
                if felt.any():
                    assert kind.level_db == pytest.approx(np.median(table.level_db[felt]) + weight)
                contrast = table.contrast_db[felt]
                text = f"{np.median(contrast):.0f}" if np.isfinite(contrast).any() else "-"
                assert drawn[kinds.index(kind.kind), column] == text
        for gap in search.gaps(tuned):
            both = {kind.kind: kind for kind in report.stroke(gap.stroke).kinds}
            if gap.second in both and both[gap.first].passed and both[gap.second].passed:
                levels = both[gap.first].level_db - both[gap.second].level_db
                assert gap.jnds * 2.3 == pytest.approx(levels)


def test_the_observer_passes_and_misses_the_events_that_the_table_does(matches, football):
    jobs = [RenderJob(match, football, sweep(2.0)) for match in matches]
    for done in render_many(jobs, RATE, tail=3.0, trace=True):
        (table,) = felt_events(football, [done.job.timeline], {"2 s": sweep(2.0)}, RATE, 3.0)[:1]
        frames = slice(table.stroke.start, table.stroke.stop)
        passed = passed_events(done.surface, done.trace.cursor[frames], RATE, 1.0)
        enters_s = np.sort(passed.enters_ms[np.isfinite(passed.enters_ms)]) / 1e3
        first_s = np.sort(table.first_s[np.isfinite(table.first_s)]) - table.stroke.start / RATE
        np.testing.assert_allclose(enters_s, first_s, atol=1e-9)
        assert (
            np.isinf(passed.enters_ms).sum()
            == np.isnan(table.first_s[np.isfinite(table.start)]).sum()
        )
