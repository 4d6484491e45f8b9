"""What a finger or an ear gets: feel reports, levels, onsets, an observer; presets tuned by them.

`ov.measure` is for who designs presets or studies what is felt. Each name is imported when it is
first used.

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
    from overview_dsp.measure.character import Character, characters, level_matched_steps
    from overview_dsp.measure.event_table import FeltEvents, felt_events
    from overview_dsp.measure.felt import (
        Stroke,
        event_levels,
        events_felt_apart,
        strokes,
        window_db,
    )
    from overview_dsp.measure.observer.observing import observe
    from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
    from overview_dsp.measure.observer.scoring import ObserverScores
    from overview_dsp.measure.onset_detector import Onsets, onsets
    from overview_dsp.measure.random_data import (
        random_crowd,
        random_events,
        random_heart,
        random_match,
        random_share,
        random_timelines,
        random_weather,
    )
    from overview_dsp.measure.random_hands import random_hand
    from overview_dsp.measure.report import (
        FeelReport,
        KindFeel,
        StrokeReport,
        character_steps,
        feel_report,
        steps_apart,
    )
    from overview_dsp.measure.tuning import TuningResult, tune

__all__ = [
    "ArmReport",
    "ArmStroke",
    "Character",
    "FeelReport",
    "FeltEvents",
    "KindFeel",
    "ObserverReport",
    "ObserverScores",
    "Onsets",
    "SetScores",
    "Stroke",
    "StrokeReport",
    "StrokeScores",
    "TuningResult",
    "arm_report",
    "character_steps",
    "characters",
    "event_levels",
    "events_felt_apart",
    "feel_report",
    "felt_events",
    "level_matched_steps",
    "observe",
    "onsets",
    "random_crowd",
    "random_events",
    "random_hand",
    "random_heart",
    "random_match",
    "random_share",
    "random_timelines",
    "random_weather",
    "steps_apart",
    "strokes",
    "tune",
    "window_db",
]

_NAMES = {
    "arm": "ArmReport ArmStroke arm_report",
    "character": "Character characters level_matched_steps",
    "report": "FeelReport KindFeel StrokeReport character_steps feel_report steps_apart",
    "felt": "Stroke event_levels events_felt_apart strokes window_db",
    "event_table": "FeltEvents felt_events",
    "observer.observing": "observe",
    "observer.report": "ObserverReport SetScores StrokeScores",
    "observer.scoring": "ObserverScores",
    "onset_detector": "Onsets onsets",
    "random_data": (
        "random_crowd random_events random_heart random_match random_share random_timelines "
        "random_weather"
    ),
    "random_hands": "random_hand",
    "tuning": "TuningResult tune",
}
"""Of each module."""

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__, {name: module for module, names in _NAMES.items() for name in names.split()}
    )
