"""Ten inputs of each text format of other programs, with what is true of each of them.

The truths follow from the published documents of the formats. Each input is read right, or refused
in one line that names the remedy.
"""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

from tests.data.readers.service_documents import (
    api_event,
    api_football,
    api_list,
    data_card,
    data_goal,
    football_data,
    liga_goal,
    open_liga,
)
from tests.data.readers.test_other_programs import BINS, DAYS_OF_WEEK, HEALTH, TWO, chart, record
from tests.data.readers.truths import Events, Input, Refused, Series, check, parametrized


def minutes(*times: float) -> list[float]:
    return [60.0 * one for one in times]


def of(name: str, document: Any, truth: Series | Events | Refused, **options: Any) -> Input:
    return Input(name, json.dumps(document), truth, options, "document.json")


GOAL, LATE = api_event(23, "Goal", "Normal Goal"), api_event(90, "Goal", "Penalty", 2, extra=4)
WITHDRAWN = api_event(25, "Var", "Goal cancelled")
FIRST = ("period", "goal")
WHOLE = ("period", "goal", "period")
BOTH = api_football([GOAL], "1H", 30, (1, 0))
BOTH["response"] += api_football([], "HT", 45)["response"]
BOTH["response"][1]["teams"] = {
    "home": {"id": 3, "name": "Westby"},
    "away": {"id": 4, "name": "Eik"},
}
NO_EVENTS = api_football([], "1H", 30)
del NO_EVENTS["response"][0]["events"]


def api_error(**errors: str) -> dict[str, Any]:
    return api_football([]) | {"errors": errors, "results": 0, "response": []}


API = [
    of(
        "API-Football, a goal in added time", api_football([GOAL, LATE], "FT", 90, (1, 1)),
        Events(minutes(0, 22.5, 45, 93.5, 94), (*WHOLE, "goal", "period")),
    ),
    of("API-Football, first half", api_football([GOAL], "1H", 30, (1, 0)),
       Events(minutes(0, 22.5), FIRST)),
    of(
        "API-Football, a goal withdrawn by the video referee",
        api_football([GOAL, WITHDRAWN], "1H", 30),
        Events(minutes(0, 22.5), ("period", "withdrawn_goal"), noted="not counted"),
    ),
    of("API-Football, not begun", api_football([], "NS", None), Refused(("not begun", "--follow"))),
    of("API-Football, postponed", api_football([], "PST", None),
       Refused(("postponed", "new date"))),
    of("API-Football, cancelled", api_football([], "CANC", None), Refused(("cancelled",))),
    of(
        "API-Football, day's limit reached",
        api_error(requests="You have reached the request limit for the day"),
        Refused(("API-Football reports", "request limit for the day")),
    ),
    of("API-Football, unknown match", api_error() | {"errors": []},
       Refused(("API-Football", "no match", "id"))),
    of("API-Football, all matches in progress", BOTH, Refused(("2 matches", "--select"))),
    of("API-Football, one of two", BOTH, Events(minutes(0, 22.5), FIRST), match="710001"),
    of("API-Football, a day's fixtures", NO_EVENTS, Refused(("no events", "match alone"))),
    of("API-Football, an event without minute", api_football([api_event(None, "Goal", "Own Goal")]),
       Refused(("events[0]", "no minute"))),
    of("API-Football, only the events", api_list([GOAL]),
       Events(minutes(0, 22.5), FIRST, noted="no home team")),
]  # fmt: skip

PENALTIES = {
    "duration": "PENALTY_SHOOTOUT", "regularTime": {"home": 1, "away": 1},
    "extraTime": {"home": 0, "away": 0}, "penalties": {"home": 4, "away": 2},
}  # fmt: skip
ONLY_SCORE = football_data(status="IN_PLAY", score=(1, 0))
del ONLY_SCORE["goals"]
RESTRICTED = "The resource you are looking for is restricted. Please check your subscription."
DATA = [
    of("football-data, goal and card", football_data(
        [data_goal(23)], [data_card(70)], score=(1, 0)),
       Events(minutes(0, 22.5, 45, 69.5), (*WHOLE, "yellow_card"))),
    of(
        "football-data, a shoot-out",
        football_data([data_goal(23), data_goal(60, 2)], (), "FINISHED", 120, (5, 3), **PENALTIES),
        Events(minutes(0, 22.5, 45, 59.5, 90, 105, 120),
               (*WHOLE, "goal", *["period"] * 3), noted="4-2"),
    ),
    of("football-data, half-time", football_data([data_goal(45, added=3)], status="PAUSED",
       minute=45, score=(1, 0)), Events(minutes(0, 47.5), FIRST)),
    of("football-data, one goal twice", football_data([data_goal(23), data_goal(24)], score=(1, 0)),
       Events(minutes(0, 23.5, 45), WHOLE, noted="1 repeated event")),
    of("football-data, own goal", football_data([data_goal(23, type_="OWN")], score=(1, 0)),
       Events(minutes(0, 22.5, 45), ("period", "own_goal", "period"))),
    of("football-data, minute as text", football_data([data_goal("23")], minute="30", score=(1, 0)),
       Events(minutes(0, 22.5), FIRST)),
    of("football-data, scheduled", football_data(status="TIMED", minute=None),
       Refused(("not begun", "--follow"))),
    of("football-data, postponed", football_data(status="POSTPONED", minute=None),
       Refused(("postponed", "new date"))),
    of("football-data, not in the subscription", {"message": RESTRICTED, "errorCode": 403},
       Refused(("403", "check your subscription"))),
    of("football-data, scores only", {"matches": [ONLY_SCORE]},
       Refused(("football-data.org has no events", "match alone"))),
]  # fmt: skip

TIMED = [liga_goal(1, 0, 23), liga_goal(1, 1, 60, "Friis", 2)]
LATER = open_liga([liga_goal(0, 1, 12)], finished=True) | {"matchID": 61235}
NOT_FOUND = {
    "type": "https://tools.ietf.org/html/rfc7231#section-6.5.4",
    "title": "Not Found", "status": 404, "traceId": "00-1a2b-3c4d-00",
}  # fmt: skip
LIGA = [
    of("OpenLigaDB, two goals", open_liga(TIMED, finished=True),
       Events(minutes(0, 22.5, 45, 59.5, 90), (*WHOLE, "goal", "period"))),
    of("OpenLigaDB, goals out of order", open_liga(TIMED[::-1], finished=True),
       Events(minutes(0, 22.5, 45, 59.5, 90), (*WHOLE, "goal", "period"))),
    of("OpenLigaDB, a corrected goal", open_liga([liga_goal(1, 0, 21), TIMED[0]]),
       Events(minutes(0, 22.5), FIRST)),
    of("OpenLigaDB, own goal", open_liga([liga_goal(1, 0, 23, isOwnGoal=True)]),
       Events(minutes(0, 22.5), ("period", "own_goal"))),
    of("OpenLigaDB, a goal without minute", open_liga([liga_goal(1, 0, None), TIMED[1]]),
       Events(minutes(0, 45, 59.5), ("period", "period", "goal"),
              noted="1 goal without a minute left out")),
    of("OpenLigaDB, no goals", open_liga(results=[("Endergebnis", 0, 0)], finished=True),
       Events(minutes(0, 45, 90), ("period",) * 3, duration_s=5400.0)),
    of("OpenLigaDB, extra time", open_liga([*TIMED, liga_goal(2, 1, 110, isOvertime=True)],
       finished=True), Events(minutes(0, 22.5, 45, 59.5, 90, 105, 109.5, 120),
                              (*WHOLE, "goal", "period", "period", "goal", "period"))),
    of("OpenLigaDB, not begun", open_liga(), Refused(("not begun", "--follow"))),
    of("OpenLigaDB, unknown match", NOT_FOUND, Refused(("404", "Not Found"))),
    of("OpenLigaDB, a day", [open_liga(TIMED), LATER], Refused(("2 matches", "--select"))),
    of("OpenLigaDB, one of a day", [open_liga(TIMED), LATER],
       Events(minutes(0, 11.5, 45, 90), (*WHOLE, "period")), match="61235"),
]  # fmt: skip

DATES = [{"x": f"2026-01-0{i}", "y": i} for i in (1, 2, 4)]
HOLE = [{"x": 2000 + i, "y": None if i == 2 else i} for i in range(6)]
HEAT = {"x": ["Mon", "Tue"], "y": ["a", "b"], "points": [[1, 2], [3, 4]]}
BOX = [{"fill": "setosa", "min": 1, "q1": 2, "q2": 3, "q3": 4, "max": 5}]
CANDLES = [
    {"value": f"2026-01-0{i}", "open": i, "high": i + 2, "low": i - 1, "close": i + 1, "volume": 9}
    for i in (5, 6, 7)
]
STACK = [[{"x": d, "y": i * n, "fill": f"part {n}"} for i, d in enumerate("abc")] for n in (1, 2)]
DAY_S = 86_400.0
CHARTS = [
    of("MAIDR, a line of dates", chart("line", [DATES], x="Date"),
       Series([1, 2, 4], [0.0, DAY_S, 3 * DAY_S], "2026-01-01T00:00:00")),
    of("MAIDR, one of two lines", chart("line", TWO, x="Date"),
       Series([2, 4, 6], [0.0, DAY_S, 2 * DAY_S]), match="Made, line 2"),
    of("MAIDR, two lines", chart("line", TWO, x="Date"), Refused(("line 1", "line 2", "--select"))),
    of("MAIDR, names", chart("bar", DAYS_OF_WEEK), Events([0.0, 1.0, 2.0], ("bar",) * 3)),
    of("MAIDR, bars that are stacked", chart("stacked_bar", STACK),
       Refused(("part 1", "part 2", "--select"))),
    of("MAIDR, a histogram", chart("hist", BINS),
       Series([i * (9 - i) for i in range(10)], [2.0 * i for i in range(10)])),
    of("MAIDR, points out of order", chart("point", [{"x": x, "y": x * x} for x in (3, 1, 2)]),
       Series([1, 4, 9], [0.0, 1.0, 2.0])),
    of("MAIDR, a heat map", chart("heat", HEAT), Refused(("type 'heat'", "line, bar"))),
    of("MAIDR, box plots", chart("box", BOX), Refused(("type 'box'", "line, bar"))),
    of("MAIDR, candles", chart("candlestick", CANDLES),
       Refused(("type 'candlestick'", "line, bar"))),
    of("MAIDR, a point without value", chart("line", [HOLE], x="Year"),
       Series([0, 1, 3, 4, 5], [0.0, *(DAY_S * n for n in (366, 1096, 1461, 1827))])),
]  # fmt: skip

RATE, STEPS = "HKQuantityTypeIdentifierHeartRate", "HKQuantityTypeIdentifierStepCount"
START = "2026-01-05T00:00:00+01:00"


def health(*records: str, head: str = '<?xml version="1.0" encoding="UTF-8"?>\n') -> str:
    return "\n".join((f"{head}<HealthData locale='de_DE'>", *records, "</HealthData>"))


def rates(*values: object, unit: str = "count/min") -> list[str]:
    return [record(RATE, unit, hour, value) for hour, value in enumerate(values)]


def hours(count: int) -> list[float]:
    return [3600.0 * one for one in range(count)]


SUMMER = [one.replace("+0100", "+0200") for one in rates(*range(5))[4:]]
SLEEP = record("HKCategoryTypeIdentifierSleepAnalysis", "", 3, "HKCategoryValueSleepAnalysisAwake")
TWICE = [
    record(STEPS, "count", hour, steps).replace("<Record", f'<Record sourceName="{device}"')
    for device, values in (("Watch", (40, 50, 60)), ("Phone", (30, 35, 55)))
    for hour, steps in enumerate(values)
]
NOTED = [one.replace("/>", '><MetadataEntry key="a" value="7"/></Record>') for one in rates(60, 62)]
WORKOUT = '<Workout workoutActivityType="HKWorkoutActivityTypeRunning" duration="30"/>'


def of_health(name: str, text: str | bytes, truth: Series | Refused, **options: Any) -> Input:
    return Input(f"Apple Health, {name}", text, truth, options, "export.xml")


APPLE = [
    of_health("one metric", health(*rates(60, 62.5, 61)), Series([60, 62.5, 61], hours(3), START)),
    of_health("two metrics", HEALTH, Refused(("HeartRate (count/min)", "--select"))),
    of_health("one of two metrics", HEALTH, Series([0, 1, 4, 9, 16, 25], hours(6), START),
              match="metric=StepCount (count)"),
    of_health("sleep beside it", health(*rates(60, 62), SLEEP), Series([60, 62], hours(2))),
    of_health("a winter and a summer", health(*rates(60, 62), *SUMMER),
              Series([60, 62, 4], [0.0, 3600.0, 10_800.0], START)),
    of_health("metadata in records", health(*NOTED), Series([60, 62], hours(2))),
    of_health("a byte order mark", "\ufeff" + health(*rates(60, 62)), Series([60, 62], hours(2))),
    of_health("packed", gzip.compress(health(*rates(60, 62)).encode()), Series([60, 62], hours(2))),
    of_health("watch and phone", health(*TWICE),
              Refused(("Watch", "Phone", "--select"))),
    of_health("the watch alone", health(*TWICE), Series([40, 50, 60], hours(3), START),
              match="source=Watch"),
    of_health("no numbers", health(SLEEP, WORKOUT), Refused(("no records with numbers",))),
    of_health("cut off", health(*rates(60, 62))[:-30], Refused(("broken XML", "export the data"))),
]  # fmt: skip


@parametrized(API, DATA, LIGA, CHARTS, APPLE)
def test_an_input_is_right_or_refused_with_what_to_do(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)
