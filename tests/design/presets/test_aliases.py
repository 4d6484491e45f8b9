"""Kinds that stand for others."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.morphing import morph
from overview_dsp.design.presets.validation import parse_preset
from tests.examples import plain_preset

STRONG = ov.EventKind(height=20.0, width_percent=1.0, aliases=("goal", "highest"))
LIGHT = ov.EventKind(height=2.0, width_percent=1.0)


def preset_of(**kinds):
    return replace(plain_preset(), kinds={"default": LIGHT, **kinds})


def surface_of(kind, preset):
    timeline = ov.Timeline("", 10.0, (ov.Event(5.0, kind),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return ov.build_surface(timeline, preset)


def test_an_event_takes_the_kind_that_stands_for_it_without_a_warning():
    preset = preset_of(strong=STRONG)
    assert np.array_equal(
        surface_of("goal", preset).friction, surface_of("strong", preset).friction
    )
    assert surface_of("goal", preset).friction.max() > surface_of("default", preset).friction.max()


def test_a_kind_of_that_name_comes_first():
    preset = preset_of(strong=STRONG, goal=LIGHT)
    assert np.array_equal(
        surface_of("goal", preset).friction, surface_of("default", preset).friction
    )


def test_what_nobody_stands_for_is_the_default_with_a_warning():
    timeline = ov.Timeline("", 10.0, (ov.Event(5.0, "foul"),))
    with pytest.warns(ov.OverviewWarning, match="foul"):
        ov.build_surface(timeline, preset_of(strong=STRONG))


def test_a_name_in_two_kinds_is_refused():
    with pytest.raises(ov.InputError, match=r"'goal' is in kinds\.\w+\.aliases and in kinds"):
        preset_of(strong=STRONG, other=replace(LIGHT, aliases=("goal",)))


def test_a_file_says_where_names_are_wrong():
    text = """
schema = 4
title = "t"
description = "d"
[kinds.default]
height = 1
width_percent = 1
aliases = ["goal", 3]
"""
    with pytest.raises(ov.InputError, match=r"x\.toml:8: kinds\.default\.aliases"):
        parse_preset(text, "x", "x.toml")


def test_on_the_way_to_another_preset_events_keep_the_nearer_ones_names():
    first, second = preset_of(strong=STRONG), preset_of(heavy=replace(STRONG, height=40.0))
    near, *_, far = morph(first, second, 5)
    assert near.kind_for("goal") == "strong"
    assert far.kind_for("goal") == "heavy"
    assert near.kinds["strong"].height == 20.0
