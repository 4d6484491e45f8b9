"""Lanes and scores of two teams on the terminal's screen, at each size and without colour."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import pytest

import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.screen.app import title
from overview_dsp.live.screen.key_actions import help_text
from overview_dsp.live.screen.timeline_view import Skin, TimelineView
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from tests.live.screen.test_app import drive, terminal, until  # noqa: F401

MARKS = {
    "goal": "●○", "own_goal": "⊗⊗", "near_miss": "▲△", "yellow_card": "■□", "foul": "××",
}  # fmt: skip
LETTERS = {"goal": "Gg", "own_goal": "Oo", "near_miss": "Nn", "yellow_card": "Yy", "foul": "xx"}


def drawn(timeline, size, script=None):
    """The title, the rows of the timeline's view, and the columns of the events.

    `script(pilot, player)` comes first.
    """
    player = Player(
        timeline,
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 256, settings),
        OutputSettings(),
        callback="python",
    )

    async def read(app, pilot):
        view = app.query_one(TimelineView)
        assert await until(pilot, lambda: view._drawn is not None)
        if script is not None:
            await script(pilot, player)
            await pilot.pause(0.3)
        rows = [view.render_line(y).text for y in range(view.size.height)]
        # from 112 columns the list of events is beside them
        assert all(len(row) == size[0] - 38 * (size[0] >= 112) for row in rows)
        surface = player.engine.surface
        columns = map(view.column, surface.position.tolist())
        places = dict(zip(surface.event.tolist(), columns, strict=True))
        return app.screen._compositor.render_strips()[0].text[1:], rows, places

    try:
        return drive(player, read, size=size)
    finally:
        player.close()


def expected_lane(timeline, places, side, marks):
    """The marks that events of a side have in their lane; the last of a column is on top."""
    lane, count = {}, timeline.kinds()
    # rare kinds are over common ones
    for index, event in sorted(enumerate(timeline.events), key=lambda one: -count[one[1].kind]):
        if event.side == side:
            lane[places[index]] = marks[event.kind][side - 1]
    return lane


@pytest.mark.parametrize("mode", ["colour", "NO_COLOR", "ASCII"])
@pytest.mark.parametrize("size", [(120, 36), (80, 24), (80, 19), (40, 12)])
def test_each_team_has_its_lane_with_signs_that_need_no_colour(match, size, mode, monkeypatch):
    marks = LETTERS if mode == "ASCII" else MARKS
    if mode != "colour":
        monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("LC_ALL", "C" if mode == "ASCII" else "C.UTF-8")
    shown, rows, places = drawn(match, size)
    has_scores = size[1] >= 20
    lanes = rows[1:3] if has_scores else rows[:2]
    for side, lane in enumerate(lanes, 1):
        for x, mark in expected_lane(match, places, side, marks).items():
            assert lane[x] == mark, (side, x, lane)
    assert lanes[0][2] == lanes[1][2] == ("|" if mode == "ASCII" else "│")  # kick-off
    first, second = ("FRANCE", "croatia") if mode == "ASCII" else ("● France", "Croatia ○")
    assert shown.startswith(f"{first} 4-2 {second}")
    if has_scores:
        assert rows[0].split() == ["1-0", "2-1", "3-1", "4-1"]
        assert rows[3].split() == ["1-1", "4-2"]
        for row, text in ((0, "1-0"), (3, "4-2")):
            found = (i for i, one in enumerate(match.events) if one.label.startswith(text))
            at = places[next(found)]
            assert abs(rows[row].index(text) + 1 - at) <= 1
    assert " ─ " in rows[-2]  # the disk
    stage = rows[4 if has_scores else 2 : -2]
    assert len(stage) >= 3
    curve = "░" if mode != "colour" else "▁▂▃▄▅▆▇█"
    assert any(set(row) & set(curve) for row in stage)
    assert "".join(stage).strip(f"{curve}▁▂▃▄▅▆▇█ ") == ""


def test_on_a_very_low_screen_the_lanes_are_one(match):
    _, rows, places = drawn(match, (80, 11))
    for side in (1, 2):
        lane = expected_lane(match, places, side, MARKS)
        assert sum(rows[0][x] == mark for x, mark in lane.items()) >= len(lane) - 2
    assert not set(rows[1]) & set("".join(MARKS.values()))


def test_a_timeline_without_sides_has_one_lane_as_before(match):
    plain = replace(match, sides=(), events=tuple(replace(e, side=0) for e in match.events))
    shown, rows, places = drawn(plain, (80, 24))
    assert shown.startswith("France 4-2 Croatia, World")
    assert sum(char != " " for char in rows[0]) == len(set(places.values()))
    assert not set(rows[0]) & set("·△□")
    assert set(rows[1]) <= set(" ▁▂▃▄▅▆▇█")


def test_a_zoom_keeps_the_lanes_and_counts_the_score_from_kick_off(match):
    async def zoom(pilot, player):
        player.touch(0.69)
        for _ in range(5):
            await pilot.press("plus")
            await pilot.pause(0.1)
        assert await until(pilot, lambda: player.window[0] > 3_000.0)
        assert player.window[1] < 4_800.0

    _, rows, _ = drawn(match, (80, 24), zoom)
    assert "4-1" in rows[0]
    assert "1-0" not in rows[0]
    assert "·" in rows[1]
    assert "·" in rows[2]


def test_sides_that_a_feed_sends_later_bring_the_lanes_and_corrections_the_score(match):
    names, goal = ("North", "South"), ov.Event(3_000.0, "goal", "Berg", side=2)
    whole = ov.Timeline("North - South", 6_000.0, (ov.Event(10.0, "foul"), goal))

    async def change(pilot, player):
        player._plain = replace(whole, sides=names)
        await pilot.pause(0.3)
        later = (replace(goal, side=1), ov.Event(4_000.0, "own_goal", "Lund", side=1))
        player._plain = replace(whole, sides=names, events=(*whole.events[:1], *later))
        assert await until(pilot, lambda: len(player.engine.surface.event) == 3)

    shown, rows, _ = drawn(whole, (80, 24), change)
    assert shown.startswith("● North - South ○ ")
    assert rows[0].split() == ["1-0", "2-0"]
    assert rows[3].split() == []
    assert rows[1].count("●") == rows[1].count("⊗") == 1
    assert rows[1].count("×") == rows[2].count("×") == 1  # of no team: in both


def test_scores_of_close_goals_do_not_run_into_each_other():
    goals = tuple(ov.Event(3_000.0 + 60.0 * i, "goal", side=1) for i in range(20))
    _, rows, _ = drawn(ov.Timeline("many", 6_000.0, goals, sides=("A", "B")), (60, 24))
    shown = rows[0].split()
    assert shown[0] == "1-0"
    assert 1 < len(shown) < 20
    assert all(re.fullmatch(r"\d+-0", text) for text in shown)
    numbers = [int(text[:-2]) for text in shown]
    assert all(a < b for a, b in itertools.pairwise(numbers))


@pytest.mark.parametrize(
    ("text", "sides", "shown"),
    [
        ("A 1-0 B, 2 May", ("A", "B"), "● A 1-0 B ○, 2 May"),
        ("Inter 0-1 Inter Turku", ("Inter", "Inter Turku"), "● Inter 0-1 Inter Turku ○"),
        ("The derby", ("Red", "Blue"), "● Red Blue ○ The derby"),
        ("The derby", (), "The derby"),
    ],
)
def test_the_title_is_the_key_to_the_teams(text, sides, shown):
    timeline = ov.Timeline(text, 9.0, (ov.Event(1.0, "goal"),), sides=sides)
    parts = title(timeline, Skin({"LC_ALL": "C.UTF-8"}))
    assert "".join(part for part, _ in parts) == shown
    assert [colour for _, colour in parts if colour in ("first", "second")] == (
        ["first", "second"] if sides else []
    )


def test_the_help_names_the_lanes(match):
    player = Player(
        match,
        PresetWatch("football"),
        lambda engine, settings: NullStream(engine, 256, settings),
        OutputSettings(),
        callback="python",
    )
    try:
        shown = help_text(player, Skin({}))
        assert "upper lane: France, lower lane: Croatia" in shown
        assert "● goal 5" in shown
    finally:
        player.close()


@pytest.mark.parametrize("kind", ["goal", "withdrawn_goal", "shot", "mark", "default", "_9"])
@pytest.mark.parametrize("side", [0, 1, 2])
def test_without_utf8_the_mark_of_any_kind_is_ascii(kind, side):
    skin = Skin({"LC_ALL": "C"})
    for number in range(10):
        assert skin.sign(kind, number, side)[0].isascii()
