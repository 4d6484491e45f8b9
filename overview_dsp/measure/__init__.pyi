"""Public names of `ov.measure`, each imported when it is first used."""

from overview_dsp.measure.arm import (
    ArmReport as ArmReport,
    ArmStroke as ArmStroke,
    arm_report as arm_report,
)
from overview_dsp.measure.event_table import FeltEvents as FeltEvents, felt_events as felt_events
from overview_dsp.measure.level_matching import (
    PerceptualFeatures as PerceptualFeatures,
    level_matched_distance as level_matched_distance,
    match_levels as match_levels,
    perceptual_features as perceptual_features,
)
from overview_dsp.measure.observer.observing import observe as observe
from overview_dsp.measure.observer.report import (
    ObserverReport as ObserverReport,
    SetScores as SetScores,
    StrokeScores as StrokeScores,
)
from overview_dsp.measure.observer.scoring import ObserverScores as ObserverScores
from overview_dsp.measure.onset_detector import Onsets as Onsets, onsets as onsets
from overview_dsp.measure.perceived_level import (
    Stroke as Stroke,
    count_resolved_events as count_resolved_events,
    event_levels as event_levels,
    strokes as strokes,
    window_db as window_db,
)
from overview_dsp.measure.observer.strokes import random_movement as random_movement
from overview_dsp.measure.report import (
    FeelReport as FeelReport,
    KindFeel as KindFeel,
    StrokeReport as StrokeReport,
    character_distance as character_distance,
    feel_report as feel_report,
    jnd_distance as jnd_distance,
)
from overview_dsp.measure.synthetic_data import (
    random_crowd as random_crowd,
    random_events as random_events,
    random_heart as random_heart,
    random_match as random_match,
    random_share as random_share,
    random_timelines as random_timelines,
    random_weather as random_weather,
)
from overview_dsp.measure.tuning import TuningResult as TuningResult, tune as tune
