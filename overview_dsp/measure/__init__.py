"""Perceptual measurements: feel reports, levels, onsets, an observer, and tuning of presets.

`ov.measure` is for designers of presets and for research. Each name is imported on first use.

Examples
--------
>>> import overview_dsp as ov
>>> match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
>>> sweeps = {"fast": ov.sweep(1.0)}
>>> report = ov.measure.feel_report(preset, match, sweeps, sample_rate=8000)
>>> [stroke.name for stroke in report.strokes]
['fast', 'fast recoil']
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from overview_dsp.public import lazy_names

if TYPE_CHECKING:
    from overview_dsp.measure.arm import ArmReport, ArmStroke, arm_report
    from overview_dsp.measure.event_table import FeltEvents, felt_events
    from overview_dsp.measure.level_matching import (
        PerceptualFeatures,
        level_matched_distance,
        perceptual_features,
    )
    from overview_dsp.measure.observer.observing import observe
    from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
    from overview_dsp.measure.observer.scoring import ObserverScores
    from overview_dsp.measure.onset_detector import Onsets, onsets
    from overview_dsp.measure.perceived_level import (
        Stroke,
        count_resolved_events,
        event_levels,
        strokes,
        window_db,
    )
    from overview_dsp.measure.random_movements import random_movement
    from overview_dsp.measure.report import (
        FeelReport,
        KindFeel,
        StrokeReport,
        character_distance,
        feel_report,
        jnd_distance,
    )
    from overview_dsp.measure.synthetic_data import (
        random_crowd,
        random_events,
        random_heart,
        random_match,
        random_share,
        random_timelines,
        random_weather,
    )
    from overview_dsp.measure.tuning import TuningResult, tune

__all__ = [
    "ArmReport",
    "ArmStroke",
    "FeelReport",
    "FeltEvents",
    "KindFeel",
    "ObserverReport",
    "ObserverScores",
    "Onsets",
    "PerceptualFeatures",
    "SetScores",
    "Stroke",
    "StrokeReport",
    "StrokeScores",
    "TuningResult",
    "arm_report",
    "character_distance",
    "count_resolved_events",
    "event_levels",
    "feel_report",
    "felt_events",
    "jnd_distance",
    "level_matched_distance",
    "observe",
    "onsets",
    "perceptual_features",
    "random_crowd",
    "random_events",
    "random_heart",
    "random_match",
    "random_movement",
    "random_share",
    "random_timelines",
    "random_weather",
    "strokes",
    "tune",
    "window_db",
]

_NAMES = {
    "arm": "ArmReport ArmStroke arm_report",
    "level_matching": "PerceptualFeatures perceptual_features level_matched_distance",
    "report": "FeelReport KindFeel StrokeReport character_distance feel_report jnd_distance",
    "perceived_level": "Stroke event_levels count_resolved_events strokes window_db",
    "event_table": "FeltEvents felt_events",
    "observer.observing": "observe",
    "observer.report": "ObserverReport SetScores StrokeScores",
    "observer.scoring": "ObserverScores",
    "onset_detector": "Onsets onsets",
    "synthetic_data": (
        "random_crowd random_events random_heart random_match random_share random_timelines "
        "random_weather"
    ),
    "random_movements": "random_movement",
    "tuning": "TuningResult tune",
}
"""Public names of each module."""

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__, {name: module for module, names in _NAMES.items() for name in names.split()}
    )
