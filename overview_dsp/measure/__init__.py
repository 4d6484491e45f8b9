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
    from overview_dsp.measure.comparing import character_steps, steps_apart
    from overview_dsp.measure.crowd import crowd_report
    from overview_dsp.measure.feel import (
        CrowdKind,
        CrowdReport,
        CrowdStroke,
        FeelReport,
        KindFeel,
        StrokeReport,
    )
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
    from overview_dsp.measure.random_data.choosing import random_timelines
    from overview_dsp.measure.random_data.crowd import random_crowd
    from overview_dsp.measure.random_data.heart import random_heart
    from overview_dsp.measure.random_data.kinds import random_events
    from overview_dsp.measure.random_data.match import random_match
    from overview_dsp.measure.random_data.series import random_share, random_weather
    from overview_dsp.measure.random_hands import random_hand
    from overview_dsp.measure.report import feel_report
    from overview_dsp.measure.tuning.in_crowd import tuned_on
    from overview_dsp.measure.tuning.moves import Tuned
    from overview_dsp.measure.tuning.ordering import tuned
    from overview_dsp.measure.tuning.separating import separated

__all__ = [
    "ArmReport",
    "ArmStroke",
    "Character",
    "CrowdKind",
    "CrowdReport",
    "CrowdStroke",
    "FeelReport",
    "KindFeel",
    "ObserverReport",
    "ObserverScores",
    "Onsets",
    "SetScores",
    "Stroke",
    "StrokeReport",
    "StrokeScores",
    "Tuned",
    "arm_report",
    "character_steps",
    "characters",
    "crowd_report",
    "event_levels",
    "events_felt_apart",
    "feel_report",
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
    "separated",
    "steps_apart",
    "strokes",
    "tuned",
    "tuned_on",
    "window_db",
]

if not TYPE_CHECKING:  # a type checker knows the names above, and no others
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "ArmReport": "arm",
            "ArmStroke": "arm",
            "Character": "character",
            "CrowdKind": "feel",
            "CrowdReport": "feel",
            "CrowdStroke": "feel",
            "FeelReport": "feel",
            "KindFeel": "feel",
            "ObserverReport": "observer.report",
            "ObserverScores": "observer.scoring",
            "Onsets": "onset_detector",
            "SetScores": "observer.report",
            "Stroke": "felt",
            "StrokeReport": "feel",
            "StrokeScores": "observer.report",
            "Tuned": "tuning.moves",
            "arm_report": "arm",
            "character_steps": "comparing",
            "characters": "character",
            "crowd_report": "crowd",
            "event_levels": "felt",
            "events_felt_apart": "felt",
            "feel_report": "report",
            "level_matched_steps": "character",
            "observe": "observer.observing",
            "onsets": "onset_detector",
            "random_crowd": "random_data.crowd",
            "random_events": "random_data.kinds",
            "random_hand": "random_hands",
            "random_heart": "random_data.heart",
            "random_match": "random_data.match",
            "random_share": "random_data.series",
            "random_timelines": "random_data.choosing",
            "random_weather": "random_data.series",
            "separated": "tuning.separating",
            "steps_apart": "comparing",
            "strokes": "felt",
            "tuned": "tuning.ordering",
            "tuned_on": "tuning.in_crowd",
            "window_db": "felt",
        },
    )
