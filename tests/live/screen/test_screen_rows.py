"""Each row of the screen, at each size, in colours, in 16, without any, in ASCII, and on light."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from datetime import datetime
from itertools import count

import numpy as np
import pytest
from rich.color import Color

import overview_dsp as ov
from overview_dsp.data.timeline.ticks import halves_of
from overview_dsp.live.screen.app import Trace, keys, readout
from overview_dsp.live.screen.position_report import PositionReport, event_text
from overview_dsp.live.screen.terminal import ASCII
from overview_dsp.live.screen.timeline_view import (
    TABLES,
    Skin,
    TimelineView,
    cells,
    shortened,
    spread,
)
from overview_dsp.live.session.session import SessionState
from tests.live.screen.test_app import drive, terminal, until  # noqa: F401

SERIES = ov.Timeline(
    "River",
    1000.0,
    (ov.Event(250.0, "highest", "8 °C"), ov.Event(900.0, "lowest", "3.25 °C")),
    ov.Intensity(np.array([0.0, 250.0, 900.0, 1000.0]), np.array([4, 8, 3.25, 5]), "°C"),
    gaps=((500.0, 700.0),),
)
MODES = {
    "dark": {},
    "light": {"COLORFGBG": "0;15"},
    "sixteen": {"TERM": "xterm-16color"},
    "none": {"NO_COLOR": "1"},
    "ascii": {"NO_COLOR": "1", "LC_ALL": "C"},
}


def parts(app):
    """The cells of each row of the screen, from the top."""
    view, named = app.query_one(TimelineView), {key: one.rows for key, one in app._rows.items()}
    middle = [*named["legend"], *named["signals"]] if app.size.height >= 20 else []
    rows = [*named["readout"], *view.rows, *middle]
    if app.size.width >= 112:  # the list of events is beside them
        rows = [[*row, *listed] for row, listed in zip(rows, named["events"], strict=True)]
    return [*rows, *named["state"], *named["keys"]]


def text(row):
    return "".join(char for char, _ in row)


def figures_of(row_of_three):
    """What three rows of large figures spell."""
    glyphs = {"\n".join(one): char for char, one in TABLES["figures"].items()}
    left, found = [list(row) for row in row_of_three], ""
    while any("".join(row).strip() for row in left):
        for width in (3, 2, 1):
            glyph = "\n".join("".join(row[:width]) for row in left)
            if glyph in glyphs:
                found += glyphs[glyph]
                left = [row[width + 1 :] for row in left]
                break
        else:
            return found
    return found


@pytest.mark.parametrize(
    ("size", "mode"),
    [
        *(((80, 24), mode) for mode in MODES),
        *(((40, 12), mode) for mode in MODES),
        ((112, 30), "dark"),
        ((112, 30), "ascii"),
    ],
)
def test_every_row_is_where_the_design_has_it(opened, match, monkeypatch, size, mode):
    for name, value in MODES[mode].items():
        monkeypatch.setenv(name, value)
    player, (width, height) = opened(match, "football"), size
    goal, halves = match.event("goal", 4), halves_of(match.events)

    async def script(app, pilot):
        player.touch(float(player.active_window.angle_map.position_of(goal.time_s)))
        assert await until(pilot, lambda: app._status.touching and app._status.cursor > 0.6)
        await pilot.pause(0.15)
        view = app.query_one(TimelineView)
        assert len(parts(app)) == height
        minute_60 = player.active_window.angle_map.position_of(halves[1].begin_s + 15 * 60.0)
        return parts(app), view._groove, view.skin, view.column(float(minute_60))

    rows, groove, skin, column_60 = drive(player, script, size=size)
    assert skin.name == {"ascii": "none"}.get(mode, mode)
    assert all(len(row) == width for row in rows)
    assert all(text(row).isprintable() for row in rows)
    listed, picture_width = [row[-38:] for row in rows[:-2]], width - 38
    if width >= 112:
        rows = [*(row[:picture_width] for row in rows[:-2]), *rows[-2:]]
        assert {row[0] for row in listed} == {("│", "bold"), ("│", "")}
        assert text(listed[0]).rstrip() == "│ Events 32"
        # the event under the finger is in reverse
        (here,) = [row for row in listed if ("l", "disk") in row]
        assert re.fullmatch(r"│ [●G] Goal, Mbapp\S+ France +65′ ", text(here))
        assert here[2][1] == "first!"
    shown = list(map(text, rows))
    if mode == "ascii":
        shown = [row.translate(ASCII) for row in shown]
    full, top = height >= 20, 4 if height >= 20 else 3
    # title, whose words are whole; value, moment and event
    names = "FRANCE 4-2 croatia" if mode == "ascii" else "● France 4-2 Croatia ○"
    assert shown[0].startswith(f" {names}")
    assert shown[0].split()[-1].rstrip(",") in [*match.title.replace(",", "").split(), "2018"]
    moment = PositionReport(player).moment(goal.time_s)
    if full and mode != "ascii":
        assert figures_of([row[1:] for row in shown[1:4]]) == "4-1"
    else:
        assert shown[1].startswith(" 4-1  ")
    assert moment in shown[1]
    sign = "G" if mode == "ascii" else "●"
    assert f"{sign} Goal, Mbapp" in shown[2]
    if full:
        assert "France 4, Croatia 1" in shown[3]
    # the sign under the finger is reversed, and the finger is a line from there to the curve
    lane = top + full
    marked = [
        (y, x) for y, row in enumerate(rows) for x, cell in enumerate(row) if cell[1] == "first!"
    ]
    assert [y for y, _ in marked] == [lane]
    x = marked[0][1]
    between = [rows[y][x] for y in range(lane + 1, top + groove)]
    assert {char for char, _ in between} <= set("┃╋▲△×○□■●")
    assert [char for char, _ in between].count("╋") == 1
    # the groove: the disk, the spring between, the finger
    tokens = [token for _, token in rows[top + groove]]
    assert tokens.count("disk") == 3
    assert abs(tokens.index("disk") + 1 - x) <= 2 or rows[top + groove][x] == (" ", "hand!")
    # the axis has the minutes of the match, which the finger's is one of
    axis = {int(one[1]): one.start() for one in re.finditer(r"(\d+)[′']", shown[top + groove + 1])}
    assert [*axis][:5] == [*range(0, 75, 15)] or [*axis] == [0, 30, 60, 90]
    assert abs(axis[60] - column_60) <= 2
    assert "minute 65, second half" in shown[1]
    if full:
        assert shown[-5].startswith((" ● goal 5  ", " G goal 5  ", " O goal 5  "))
        assert shown[-5].endswith(" ahead ")
        assert shown[-4].startswith(" torque ")
        assert shown[-3].startswith(" vibration ")
    assert shown[-2].startswith(" Running  ")
    assert "movement to output 13.3 ms" in shown[-2] or not full
    assert shown[-1].endswith("? help  q quit ")
    assert " Esc release " in shown[-1]
    if mode == "ascii":
        assert "".join(shown).encode("ascii", "replace").count(b"?") - 1 <= "".join(shown).count(
            "é"
        )
    # what colour tells, shape tells too: no sign of one team is one of the other
    if mode in ("none", "ascii"):
        styles = [skin.style(token) for row in rows for _, token in row]
        assert all(style.color is None and style.bgcolor is None for style in styles)
    if mode == "sixteen":
        styles = [skin.style(token) for row in rows for _, token in row]
        assert {one.color.number for one in styles if one.color is not None} <= {1, 2, 3, 5, 6}
    passed = {char for row in rows for char, token in row if token == "passed"}
    ahead = {char for row in rows for char, token in row if token == "ahead"}
    assert passed & set("▁▂▃▄▅▆▇█")
    assert (ahead - {" "} <= {"░"}) == (mode in ("none", "ascii", "sixteen"))


@pytest.mark.parametrize("name", ["dark", "light"])
def test_colours_can_be_told_from_the_background(name):
    def light(colour):
        red, green, blue = ((part / 255) ** 2.2 for part in Color.from_ansi(colour).get_truecolor())
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05

    ground = {"dark": 0.05 + 0.006, "light": 1.05}[name]
    for token, style in TABLES[name].items():
        numbers = [int(one) for one in re.findall(r"color\((\d+)\)", style)]
        pair = [light(one) for one in numbers] + [ground] * (len(numbers) == 1)
        if len(pair) == 2:
            assert max(pair) / min(pair) >= (3.0 if token == "ahead" else 4.4), token
    assert Skin({}).theme == "textual-dark"  # an unknown background is painted
    assert Skin({"COLORFGBG": "15;0"}).theme == "ansi-dark"
    assert Skin({"COLORFGBG": "0;default;15"}).theme == "ansi-light"
    assert Skin({"NO_COLOR": ""}).theme == "ansi-dark"


@pytest.mark.parametrize("which", ["match", "series"])
def test_value_and_event_are_those_of_the_finger_everywhere(opened, match, which):
    player = opened(match, "football") if which == "match" else opened(SERIES)
    dice = random.Random(7)

    async def script(app, pilot):
        report = PositionReport(player)
        for position in [0.0, 1.0, *(dice.random() for _ in range(8))]:
            player.touch(position)
            at = pytest.approx(position)
            assert await until(pilot, lambda at=at: app._finger and app._finger[0] == at)
            shown = list(map(text, parts(app)))
            (moment, end, value), _, event = report.here(position)
            assert f"{moment}{', ' if end else ''}{end}" in shown[1]
            if figures := re.match(r"(\d+) to (\d+)|(-?[\d.]+) ", value):
                expected = f"{figures[1]}-{figures[2]}" if figures[1] else figures[3]
                assert figures_of([row[1:] for row in shown[1:4]]) == expected
                assert figures[1] or "°C" in shown[3]
            else:
                assert value in shown[1]
            if event is not None:
                words = event_text(event, player.timeline.sides)
                assert words[1:] in shown[2]

    drive(player, script, size=(80, 24))


def test_a_series_has_its_signs_at_the_curve_and_its_gap_is_empty(opened):
    player = opened(SERIES)

    async def script(app, pilot):
        player.touch(0.52)
        assert await until(pilot, lambda: app._status.touching)
        await pilot.pause(0.3)
        view = app.query_one(TimelineView)
        return [text(row) for row in view.rows], view._groove, view.column, parts(app)

    rows, groove, column, screen = drive(player, script, size=(80, 24))
    high, low = column(0.25), column(0.9)
    assert [row[high] for row in rows].index("▲") + 1 == min(
        y for y, row in enumerate(rows) if row[high] in "▁▂▃▄▅▆▇█"
    )
    assert rows[groove - 1][low] == "▼"
    gap = range(column(0.5) + 2, column(0.7) - 1)
    assert {rows[y][x] for y in range(1, groove - 1) for x in gap} <= set(" ╱┃╋")
    assert set(rows[groove][gap[0] : gap[-1]]) & set("━─") <= {"─"}  # the notch
    assert "no data" in rows[0]
    # values stand beside the signs, and the finger never covers one
    sign = next(row for row in rows if "▲" in row)
    assert sign[high + 1 :].startswith(" Highest 8 °C ")
    assert rows[groove - 1][low - 16 : low] == " Lowest 3.25 °C "
    assert "no data from 8:20 to 11:40" in text(screen[1])


def test_a_warning_is_coloured_only_while_there_is_trouble(opened, match):
    player = opened(match, "football")

    async def script(app, pilot):
        assert await until(pilot, lambda: app._status is not None)
        status, state = app._status, SessionState("output lost", "Scarlett was unplugged")
        lost = app._state(replace(status, state=state), 60)
        assert {token for _, token in lost} == {"lost"}
        assert text(lost).startswith(" Output lost  Scarlett was unplugged. Plug it in, or press c")
        back = app._state(replace(status, state=state.then("no input", "nothing")), 60)
        assert {token for _, token in back} == {"", "bold"}
        assert "unplugged" not in text(back)  # past stops are in the figures
        app._faults = -1
        await pilot.pause(0.2)
        assert any("blocks were late, see i" in text(row) for row in parts(app))

    drive(player, script, size=(80, 24))


def test_blocks_that_are_always_late_do_not_cover_the_state_of_a_small_screen(
    opened, match, monkeypatch
):
    player = opened(match, "football")
    polled, late = player.poll, count(1)
    monkeypatch.setattr("overview_dsp.live.screen.app.MESSAGE_S", 1.0)

    def poll():
        status = polled()
        return replace(status, stream=replace(status.stream, late=next(late)))

    monkeypatch.setattr(player, "poll", poll)

    async def script(app, pilot):
        def state():
            return text(parts(app)[-2])

        assert await until(pilot, lambda: "blocks were late, see i" in state())
        assert await until(pilot, lambda: "nothing touches the disk" in state())
        # those that come later are told, too
        monkeypatch.setattr("overview_dsp.live.screen.app.FAULTS_EVERY_S", 0.0)
        assert await until(pilot, lambda: "blocks were late, see i" in state())

    drive(player, script, size=(40, 12))


def test_what_is_done_next_is_one_label(opened, match):
    player = opened(match, "football")

    async def script(app, pilot):
        def labels():
            runs = ["".join(c if t == "label" else "\n" for c, t in row) for row in parts(app)]
            return [one.strip() for run in runs for one in run.split("\n") if one.strip()]

        assert await until(pilot, lambda: labels() == ["Drag here with the mouse, or hold →"])
        await pilot.press("right")
        assert await until(pilot, lambda: labels() == ["Esc release"])
        await pilot.press("escape")
        assert await until(pilot, lambda: labels() == ["] next event"])
        assert any("where you released it" in text(row) for row in parts(app))
        view = app.query_one(TimelineView)
        assert any(("┊", "hand") in row for row in view.rows)
        assert ("○", "hand") in view.rows[view._groove] or view._drawn[0] <= 5

    drive(player, script, size=(80, 24))


def test_only_cells_that_differ_are_drawn(opened, match):
    player = opened(match, "football")

    async def script(app, pilot):
        await pilot.pause(0.5)
        drawn = []
        for one in [app.query_one(TimelineView), *app._rows.values()]:
            one.refresh = lambda *regions, **_: drawn.append(regions)
        app._shown = []
        await pilot.pause(0.3)
        drawn.clear()
        await pilot.pause(1.0)
        assert sum(map(len, drawn)) <= 4  # at most a message about a late block
        player.touch(0.02)
        await pilot.pause(0.5)
        assert drawn

    drive(player, script, size=(80, 24))


@pytest.mark.parametrize("width", range(0, 90, 7))
def test_texts_fit_any_width_and_no_word_is_cut(width):
    words = "Output lost Scarlett 2i2 was unplugged, plug it in"
    short = shortened(words, width)
    assert len(short) <= width
    assert len(short) < 8 or short.rstrip("…") in words
    assert len(short) < 8 or words[len(short.rstrip("…")) :][:1] in ("", " ", ",")
    assert len(spread(width, cells((words, "")), cells(("? help", "")))) <= max(width, 0)
    if width >= 35:
        row = text(keys(width, "Esc release"))
        assert len(row) == width
        assert row.endswith("? help  q quit ")
        assert "Esc release" in row
    if width >= 28:
        place = ("1:07:30", "end", "4 to 1")
        for full in (False, True):
            rows = readout(place, cells(("● ", "first")), words, True, full, width)
            assert [len(row) <= width for row in rows] == [True] * len(rows)


def test_wide_characters_take_two_cells_and_control_characters_none():
    row = cells(("a日\x1b[2J", "bold"))
    assert text(row) == "a日 [2J"
    assert len(row) == 7
    assert len(spread(4, row)) == 4


def test_levels_have_seven_heights_of_six_decibels(opened, match):
    player = opened(match, "football")

    async def script(app, pilot):
        assert await until(pilot, lambda: app._status is not None)
        trace, status = Trace(), app._status
        for number in range(9):
            part = 10 ** (-6 * number / 20)
            trace.add(
                replace(status, time_s=number + 1, torque=part * status.full_torque, envelope=0.0)
            )
        torque, vibration = map(text, trace.rows(status, 250.0, 80))
        assert "▇▆▅▄▃▂▁" in torque
        assert "none" in torque
        assert "silent" in vibration
        trace.add(replace(status, time_s=20.0, torque=0.5 * status.full_torque, envelope=0.5))
        torque, vibration = map(text, trace.rows(status, 250.0, 80))
        assert re.search(r"−6 dB \d+\.\d\d mN·m", torque)
        assert "−6 dB 250 Hz" in vibration

    drive(player, script, size=(80, 24))


@pytest.mark.parametrize("mode", ["dark", "none"])
def test_the_list_of_events_follows_the_finger_and_has_dates_or_clocks(opened, monkeypatch, mode):
    for name, value in MODES[mode].items():
        monkeypatch.setenv(name, value)
    day = 86_400.0
    events = tuple(ov.Event(day * (1 + number), "strong", f"no {number}") for number in range(60))
    player = opened(ov.Timeline("days", 62 * day, events, start=datetime(2024, 1, 1)))

    async def script(app, pilot):
        def listed():
            found = [text(row).strip("│ ") for row in app._rows["events"].rows]
            return [re.sub(" +", " ", row)[2:] for row in found[2:] if row]

        assert await until(pilot, lambda: listed()[-1:] == ["Strong, no 59 2024-03-01"])
        player.touch(0.0)
        assert await until(pilot, lambda: listed()[:1] == ["Strong, no 0 2024-01-02"])
        assert len(listed()) == app.size.height - 4
        player.touch(0.5)
        middle = "Strong, no 30 2024-02-01"
        assert await until(pilot, lambda: middle in listed()[8:-8])
        player.show(10.0 * day, 12.5 * day)
        assert await until(pilot, lambda: "Strong, no 10 00:00:00" in listed())
        assert next(row for row in listed() if row.startswith("Strong")) == "Strong, no 9 00:00:00"
        assert "Hour, 06:00 06:00:00" in listed()
        await pilot.resize_terminal(111, 30)
        assert await until(pilot, lambda: app._view.size.width == 111)
        assert not app._rows["events"].display or not app._rows["events"].size.width

    drive(player, script, size=(112, 30))
