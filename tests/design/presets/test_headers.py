"""What the bundled presets' headers say and can be measured: each sentence stands there, and is so.

What an observer tells apart and what each kind is like alone is looked up in the feel reports of
`presets/feel`, which are kept up to date (`test_bundled_feel`).
"""

from __future__ import annotations

import functools
import itertools
import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets import library
from overview_dsp.measure.perception import JND_DB
from tests.feel.curves import steps_of

FOLDER = library.LIBRARY.bundled_folder
OCTAVE = pytest.approx(2.0, rel=0.12)


@functools.cache
def header(name):
    """A header's words, lines joined."""
    lines = (FOLDER / f"{name}.toml").read_text(encoding="utf-8").splitlines()
    words = itertools.takewhile(lambda line: line.startswith("#"), lines)
    return " ".join(" ".join(line.lstrip("# ") for line in words).split())


@functools.cache
def feel(name):
    return json.loads((FOLDER / "feel" / f"{name}.json").read_text(encoding="utf-8"))


def each_stroke(name, value):
    """A figure of each kind in each stroke: a list of mappings."""
    return [
        {kind["kind"]: kind[value] for kind in stroke["kinds"]} for stroke in feel(name)["strokes"]
    ]


def taken(name, kind, for_what, by="touch", strokes=None):
    """Which part of a kind an observer takes for another, or for nothing, in each stroke."""
    shares = []
    for stroke in feel(name)["observer"]["strokes"]:
        if stroke["modality"] == by and (strokes is None or stroke["name"] in strokes):
            kinds = [*stroke["kinds"], "nothing"]
            row = stroke["confusion"][kinds.index(kind)]
            shares.append(row[kinds.index(for_what)] / sum(row))
    return np.array(shares)


def modes(name, kind):
    return ov.load_preset(name).kinds[kind].modes


def lowest(name, kind):
    return min(mode.frequency_hz for mode in modes(name, kind))


def longest(name, kind):
    return max(mode.decay_ms for mode in modes(name, kind))


def ridges(name):
    """How many ridges the bare surface has, and the part of it that is between them."""
    bare = ov.Timeline("bare", 100.0, (), ov.Intensity(np.zeros(1), np.zeros(1)))
    friction = ov.build_surface(bare, ov.load_preset(name)).friction
    low, high = np.percentile(friction, [1, 99])
    above = friction > 0.5 * (low + high)
    count = int(np.count_nonzero(np.diff(above.astype(int)) == 1)) + int(above[0])
    return count, friction, low + 0.1 * (high - low)


def falls_at_once(friction):
    slope = np.diff(friction)
    return slope.max() < 0.2 * -slope.min()


def crowd_db(name):
    """How much a curve from its lowest to its highest is felt, dB, wherever either lies."""
    preset = ov.load_preset(name)
    return np.mean([steps_of(preset, course).sum() for course in ("rising", "falling")])


def quieter(name, other, value, least=0.0):
    """Is it weaker than another in every stroke, in all kinds they have or between them?"""
    if value in ("event_free_db", "level_db"):
        pairs = zip(feel(name)["strokes"], feel(other)["strokes"], strict=True)
        return all(one[value] < more[value] - least for one, more in pairs)
    pairs = zip(each_stroke(name, value), each_stroke(other, value), strict=True)
    return all(one[kind] < more[kind] - least for one, more in pairs for kind in one)


CHARACTERS = ("football", "football-stadium", "football-discreet", "football-training")

SENTENCES = {
    # --- football
    ("football", "a red card a heavier and sharper one"): lambda name: all(
        found["red_card"] > 2.0 * found["yellow_card"] for found in each_stroke(name, "sharpness")
    ),
    ("football", "a sharper and louder one for a red"): lambda name: (
        all(
            found["red_card"] > found["yellow_card"] + 3.0
            for found in each_stroke(name, "click_db")
        )
        and lowest(name, "red_card") > lowest(name, "yellow_card")
    ),
    ("football", "an own goal like one that is an octave lower and longer"): lambda name: (
        lowest(name, "goal") / lowest(name, "own_goal") == OCTAVE
        and longest(name, "own_goal") > 1.5 * longest(name, "goal")
    ),
    ("football", "by touch, every third own goal from a goal"): lambda name: (
        np.mean(taken(name, "own_goal", "goal")) == pytest.approx(1 / 3, abs=0.06)
    ),
    ("football", "at 1 s every fourth, in the recoil two in five red cards from a"): lambda name: (
        taken(name, "red_card", "yellow_card", "touch", ["1 s", "recoil"])
        == pytest.approx([1 / 4, 2 / 5], abs=0.05)
        and np.mean(taken(name, "red_card", "yellow_card")) < 1 / 4
    ),
    ("football", "every fifth near miss from a foul"): lambda name: (
        np.mean(taken(name, "near_miss", "foul")) == pytest.approx(1 / 5, abs=0.05)
    ),
    ("football", "the click tells"): lambda name: (
        np.mean(taken(name, "red_card", "yellow_card", "both")) < 0.1
        and np.mean(taken(name, "own_goal", "goal", "both")) < 0.1
    ),
    ("football", "at 1 s three in four fouls, at 2 s one in four, go unnoticed"): lambda name: (
        taken(name, "foul", "nothing", "touch", ["1 s", "2 s"])
        == pytest.approx([3 / 4, 1 / 4], abs=0.05)
    ),
    # --- its character
    ("football-stadium", "the strongest of the three characters"): lambda name: all(
        quieter(other, name, "level_db") and quieter(other, name, "event_free_db")
        for other in ("football", "football-discreet")
    ),
    ("football-stadium", "the crowd shakes it all match long"): lambda name: (
        crowd_db(name) > crowd_db("football")
    ),
    ("football-stadium", "with long echoes"): lambda name: (
        longest(name, "goal") > 4.0 * longest("football", "goal")
    ),
    ("football-discreet", "hardly a hum, the crowd not at all"): lambda name: (
        abs(crowd_db(name)) < 0.3 and quieter(name, "football", "event_free_db", 2.0 * JND_DB)
    ),
    ("football-discreet", "light taps for what matters and a firm one for a goal"): lambda name: (
        all(
            found["goal"] > max(found["yellow_card"], found["foul"]) + JND_DB
            for found in each_stroke(name, "level_db")
        )
    ),
    ("football-discreet", "next to nothing: a fingernail on wood"): lambda name: quieter(
        name, "football", "click_db", 12.0
    ),
    ("football-training", "without its crowd"): lambda name: abs(crowd_db(name)) < 0.3,
    ("football-training", "on a heavier knob"): lambda name: (
        ov.load_preset(name).number("disk.inertia")
        > 1.5 * ov.load_preset("football").number("disk.inertia")
    ),
    ("football-training", "one clear note for each kind, from low (period) to high (cards)"): (
        lambda name: (
            all(len(kind.modes) == 1 for kind in ov.load_preset(name).kinds.values())
            and notes(name)[0] == "period"
            and set(notes(name)[-2:]) == {"yellow_card", "red_card"}
        )
    ),
    # --- surfaces
    ("ratchet", "a ratchet of 24 teeth: each rises slowly and falls suddenly"): lambda name: (
        ridges(name)[0] == 24 and falls_at_once(ridges(name)[1])
    ),
    ("safe-dial", "a hundred fine, even ticks, and between them nothing"): lambda name: (
        ridges(name)[0] == 100 and np.mean(ridges(name)[1] < ridges(name)[2]) > 0.1
    ),
    ("clock-key", "a strong spring behind the key"): lambda name: all(
        ov.load_preset(name).number("disk.k1") > 4.0 * ov.load_preset(other).number("disk.k1")
        for other in ("ratchet", "safe-dial", "silk", *CHARACTERS)
    ),
    ("silk", "next to nothing, until a fold is under it"): lambda name: (
        feel(name)["strokes"][0]["event_free_db"]
        < min(
            feel(other)["strokes"][0]["event_free_db"]
            for other in ov.bundled_presets()
            if other != name
        )
        - JND_DB
    ),
    # --- what an observer tells of the others
    (
        "crowd",
        "in a second 4 in 10 go unnoticed, in the recoil 3 in 10, in a tap every fourth",
    ): lambda name: (
        taken(name, "burst", "nothing", "touch", ["1 s", "recoil", "tap"])
        == pytest.approx([0.4, 0.3, 1 / 4], abs=0.03)
    ),
    (
        "plain",
        "in a second every second and 3 in 4 go unnoticed, in the recoil 4 in 10 and 2 in 3",
    ): lambda name: (
        taken(name, "firm", "nothing", "touch", ["1 s", "recoil"])
        == pytest.approx([1 / 2, 0.4], abs=0.05)
        and taken(name, "light", "nothing", "touch", ["1 s", "recoil"])
        == pytest.approx([3 / 4, 2 / 3], abs=0.05)
    ),
    ("heart", "early beats that follow one another within 30 ms, at 4 s every second one"): (
        lambda name: (
            taken(name, "premature", "nothing", "touch", ["4 s"]) == pytest.approx(0.5, abs=0.05)
        )
    ),
    ("heart", "in the recoil, a missed beat from an early one but by ear"): lambda name: (
        taken(name, "missed_beat", "premature_ventricular", "touch", ["recoil"])[0] > 0.4
        and taken(name, "missed_beat", "premature_ventricular", "both", ["recoil"])[0] < 0.2
    ),
    ("heart", "poor signal from the ground"): lambda name: (
        np.median(taken(name, "signal_quality", "nothing")) > 0.8
    ),
    ("series", "in the recoil, the lowest from the largest moves"): lambda name: (
        taken(name, "lowest", "largest_rise", "touch", ["recoil"])[0] > 0.4
    ),
    ("weather", "every third record from nothing"): lambda name: (
        np.mean(taken(name, "record_high", "nothing")) == pytest.approx(1 / 3, abs=0.05)
    ),
    ("weather", "crossings are lost"): lambda name: (
        taken(name, "crossing_up", "nothing").min() > 0.5
    ),
    ("plain", "in the recoil, a wall from what is firm"): lambda name: alike(
        name, ("strong", "firm"), "slow recoil", "fast recoil"
    ),
    ("gravel", "a kerb from another big stone in a second, a tap or the recoil"): lambda name: (
        alike(name, ("strong", "firm"), "fast", "tap", "slow recoil")
    ),
    ("ratchet", "what holds hardest from what is firm in a second, a tap or the recoil"): (
        lambda name: alike(name, ("strong", "firm"), "fast", "tap", "slow recoil")
    ),
    ("clock-key", "what binds hardest from what is firm in a second, a tap or the recoil"): (
        lambda name: alike(name, ("strong", "firm"), "fast", "tap", "slow recoil")
    ),
    ("safe-dial", "one tumbler from another in a tap or the recoil"): lambda name: alike(
        name, ("strong", "firm"), "tap", "slow recoil"
    ),
    ("creaking-door", "one jerk from another in a tap or the recoil"): lambda name: alike(
        name, ("strong", "firm"), "tap", "slow recoil"
    ),
    ("silk", "in the recoil, a firm fold from a light one"): lambda name: alike(
        name, ("firm", "light"), "slow recoil", "fast recoil"
    ),
    ("football-stadium", "in the recoil an own goal from a red card"): lambda name: alike(
        name, ("own_goal", "red_card"), "slow recoil", "fast recoil", "tap recoil"
    ),
    # --- sounds
    ("series", "lows are wood an octave lower"): lambda name: (
        lowest(name, "highest") / lowest(name, "lowest") == OCTAVE
    ),
    ("series", "the rarer it is the longer it rings"): lambda name: falling(
        longest(name, kind)
        for kind in ("highest", "largest_rise", "record_high", "peak", "crossing_up")
    ),
    ("stocks", "the lowest wood an octave below"): lambda name: (
        lowest(name, "highest") / lowest(name, "lowest") == OCTAVE
    ),
    ("stocks", "dry high taps"): lambda name: all(
        longest(name, kind) < 0.5 * longest("series", kind)
        for kind in ("highest", "lowest", "largest_rise", "record_high", "peak")
    ),
    ("crowd", "a deep drum for a cheer, a tin lid for a burst"): lambda name: (
        lowest(name, "cheer") < 200.0 and lowest(name, "burst") > 2000.0
    ),
}


def gaps(name, order):
    """Steps from each kind to the next, by stroke."""
    found = {}
    for stroke in feel(name)["strokes"]:
        level = {kind["kind"]: kind["level_db"] for kind in stroke["kinds"]}
        pairs = itertools.pairwise(order)
        found[stroke["name"]] = [(level[one] - level[other]) / JND_DB for one, other in pairs]
    return found


def alike(name, order, *strokes):
    """Are two kinds less than a step apart in these strokes?"""
    found = gaps(name, order)
    return all(found[stroke][0] < 1.0 for stroke in strokes)


def falling(values):
    found = list(values)
    return found == sorted(set(found), reverse=True)


def notes(name):
    """The kinds by their note, from low to high."""
    kinds = [kind for kind in ov.load_preset(name).kinds if kind != "default"]
    return sorted(kinds, key=lambda kind: lowest(name, kind))


@pytest.mark.parametrize(("name", "words"), SENTENCES)
def test_what_a_header_says_stands_there_and_is_so(name, words):
    assert words in header(name)
    assert SENTENCES[name, words](name)


SWEEPS = ("slow", "medium", "fast")
SLOWER = ("slow", "medium")
CARDS = ("goal", "red_card", "yellow_card", "foul")
HARDNESS = ("strong", "firm", "light")

ORDERS = {
    ("football", CARDS): (*SWEEPS, "tap"),
    ("football", ("red_card", "yellow_card")): "all",
    ("football-stadium", CARDS): (*SWEEPS, "tap"),
    ("football-stadium", ("red_card", "yellow_card")): "all",
    ("football-discreet", CARDS): (*SWEEPS, "tap"),
    ("football-discreet", ("red_card", "yellow_card")): "all",
    ("football-training", CARDS): (*SWEEPS, "tap"),
    ("football-training", ("red_card", "yellow_card")): "all",
    ("football", ("foul", "touch")): (*SWEEPS, "tap"),
    ("heart", ("premature_ventricular", "premature", "beat")): "all",
    ("series", ("highest", "record_high", "peak")): (*SWEEPS, "tap"),
    ("stocks", ("largest_rise", "record_high", "peak")): SLOWER,
    ("weather", ("highest", "record_high", "peak")): "all",
    ("plain", HARDNESS): (*SWEEPS, "tap"),
    ("silk", HARDNESS): (*SWEEPS, "tap"),
    ("safe-dial", HARDNESS): SWEEPS,
    ("creaking-door", HARDNESS): SWEEPS,
    ("gravel", HARDNESS): SLOWER,
    ("ratchet", HARDNESS): SLOWER,
    ("clock-key", HARDNESS): SLOWER,
}
"""Which kinds a header states to be stronger than which, and in which strokes it doesn't take it
back."""


@pytest.mark.parametrize(("name", "order"), ORDERS)
def test_the_order_that_a_header_states_is_kept_a_step_apart(name, order):
    found = gaps(name, order)
    strokes = ORDERS[name, order]
    for stroke in found if strokes == "all" else strokes:
        assert min(found[stroke]) >= 1.0, stroke
