"""One match from several formats: the same goals at the same times."""

from __future__ import annotations

from pathlib import Path

import pytest

from overview_dsp.data.readers import load_timeline, save_timeline
from overview_dsp.data.readers.events.event_table import encode
from overview_dsp.data.timeline import Timeline

MATCHES = ("22936", "69321", "15986")


@pytest.fixture(params=MATCHES)
def match(request: pytest.FixtureRequest, statsbomb_folder: Path) -> Timeline:
    return load_timeline(statsbomb_folder / f"{request.param}.json")


def goals(timeline: Timeline) -> list[tuple[float, str]]:
    """Time and scorer's label of each goal, without the minute that lists add."""
    return [(e.time_s, e.label) for e in timeline.events if e.kind in ("goal", "own_goal")]


def test_native_and_event_csv_have_its_goals_within_a_millisecond(
    match: Timeline, tmp_path: Path
) -> None:
    save_timeline(match, tmp_path / "m.json")
    (tmp_path / "m.csv").write_bytes(encode(match))
    for name in ("m.json", "m.csv"):
        again = load_timeline(tmp_path / name)
        assert len(goals(again)) == len(goals(match)) > 0
        for (time_s, label), (true_s, true_label) in zip(goals(again), goals(match), strict=True):
            assert abs(time_s - true_s) <= 0.001
            assert label == true_label
    assert load_timeline(tmp_path / "m.json") == match
    assert load_timeline(tmp_path / "m.csv").events == match.events


def listed(match: Timeline, first_minute: int, *, running: bool) -> str:
    """The goals as a list of minutes, of the match's clock or of the timeline's.

    The clock of the match names the minutes of the second half from 45 on, and the list tells
    when the first half ended.
    """
    half_s = next(e.time_s for e in match.events if e.label == "half-time")
    lines = ["minute,type,player"]
    if not running:
        lines.append(f"{int(half_s) // 60}:{half_s % 60:06.3f},half-time,")
    for time_s, label in goals(match):
        # stoppage time in the first half is 45+n; there is none in these goals of the second
        into = time_s - half_s if time_s > half_s and not running else time_s
        minute = int(into // 60) + first_minute + (45 if into != time_s else 0)
        added = minute - 45 if into == time_s and minute > 45 and not running else 0
        lines.append(f"{45 if added else minute}{f'+{added}' if added else ''},goal,{label[-6:]}")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("first_minute", [0, 1])
@pytest.mark.parametrize("running", [False, True])
def test_a_list_of_minutes_has_its_goals_within_a_minute(
    match: Timeline, first_minute: int, running: bool, tmp_path: Path
) -> None:
    (tmp_path / "m.csv").write_text(listed(match, first_minute, running=running))
    again = load_timeline(tmp_path / "m.csv")
    assert len(goals(again)) == len(goals(match)) > 0
    for (time_s, _), (true_s, _) in zip(goals(again), goals(match), strict=True):
        assert abs(time_s - true_s) <= 60.0
