"""What is promised of other people's matches: orders of importance, and presets tuned on them."""

from __future__ import annotations

import itertools
import json

import pytest

import overview_dsp as ov
from overview_dsp.measure.report import feel_report
from overview_dsp.measure.tuning import JUDGED, REST
from tests.cli.running import overview
from tests.feel.whole_matches import RATE, real_files, real_matches
from tests.measure.test_tuning import gaps_of

ORDER = ("goal", "red_card", "yellow_card", "foul")
CHARACTERS = ("football", "football-stadium", "football-discreet", "football-training")
CHILD = """# kept as it is
schema = 4
extends = "football"

[variables]
hard = 414.0  # how hard

[kinds.goal]
height = "$hard"  # a knock
"""

pytestmark = pytest.mark.soak


@pytest.mark.parametrize("name", CHARACTERS)
def test_each_kind_is_a_step_above_the_next_at_every_speed_and_cards_in_recoils(name, data_folder):
    preset, matches = ov.load_preset(name), real_matches(data_folder)
    for stroke in feel_report(preset, matches, JUDGED, RATE, order=ORDER).strokes:
        gaps = {(one, other): steps for one, other, steps in stroke.gaps}
        if not stroke.name.endswith("recoil"):
            for pair in itertools.pairwise(ORDER):
                assert gaps[pair] >= 1.0, (stroke.name, pair)
    # a recoil fades towards the start: cards of one match are compared
    with_red = [match for match in matches if "red_card" in match.kinds()]
    assert with_red
    for match in with_red:
        for stroke in feel_report(preset, [match], JUDGED, RATE, order=ORDER).strokes:
            gaps = {(one, other): steps for one, other, steps in stroke.gaps}
            assert gaps["red_card", "yellow_card"] >= 1.0, (match.title, stroke.name)


@pytest.mark.parametrize("index", range(5))
def test_a_preset_tuned_on_a_match_reaches_its_target_or_says_by_how_much_not(
    data_folder, index, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    file = real_files(data_folder)[index]
    timeline = ov.load_timeline(file)
    target = [kind for kind in ORDER if kind in timeline.kinds()]
    (tmp_path / "child.toml").write_text(CHILD)
    done = overview(
        *("presets", "tune", "child.toml", str(file), "--order", ">".join(target)),
        *("-o", "made.toml", "--json"),
    )
    assert done.code == 0, done.err
    report = json.loads(done.out)
    text = (tmp_path / "made.toml").read_text()
    for line in CHILD.splitlines():
        assert line in text or line.startswith("height")
    made = ov.load_preset("made.toml")
    # measured again, of the file: its numbers have four digits
    short = [
        (gap.first, gap.second, gap.stroke)
        for gap in gaps_of(made, target, [timeline])
        if gap.jnds < (0.95 if gap.second == REST else 1.95)
    ]
    assert report["reached"] == (report["unreached"] == [])
    for one, other, way in short:
        assert any(
            line.startswith(f"{one} is ") and f" above {other} in {way} " in line
            for line in report["unreached"]
        )
