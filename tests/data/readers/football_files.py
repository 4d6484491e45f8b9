"""Small made-up matches in the formats of Metrica, Wyscout and openfootball, for tests."""

from __future__ import annotations

import itertools
import json
from typing import Any

METRICA_HEADER = (
    "Team,Type,Subtype,Period,Start Frame,Start Time [s],End Frame,End Time [s],From,To,"
    "Start X,Start Y,End X,End Y"
)


def metrica(*rows: str) -> str:
    """A raw-events file; a row is `Team,Type,Subtype,Period,start,end,From`."""
    lines = [METRICA_HEADER]
    for row in rows:
        team, kind, subtype, period, start, end, player = row.split(",")
        lines.append(f"{team},{kind},{subtype},{period},1,{start},2,{end},{player},,NaN,NaN,0.5,1")
    return "\n".join(lines) + "\n"


METRICA_ROWS = (
    "Away,SET PIECE,KICK OFF,1,0.04,0.04,Player9",
    "Home,BALL LOST,GOAL KICK-INTERCEPTION,1,50.2,52,Player1",
    "Home,SHOT,HEAD-ON TARGET-GOAL,1,91.56,92.4,Player4",
    "Away,SET PIECE,KICK OFF,1,140,140,Player9",
    "Away,SHOT,ON TARGET-SAVED,1,200.5,201,Player8",
    "Away,SHOT,WOODWORK-OUT,1,210.5,211,Player8",
    "Away,SHOT,OFF TARGET-OUT,1,220.5,221,Player8",
    "Home,FAULT RECEIVED,,1,300,300,Player3",
    "Away,CARD,YELLOW,1,301,301,Player7",
    "Home,BALL LOST,END HALF,1,2823.12,2823.12,Player7",
    "Home,SET PIECE,KICK OFF,2,2885.4,2885.4,Player9",
    "Home,BALL OUT,WOODWORK-GOAL,2,3498.8,3499.4,Player5",
    "Home,SET PIECE,KICK OFF,2,3551.68,3551.68,Player5",
    "Away,SET PIECE,PENALTY,2,4000,4000,Player8",
    "Away,SHOT,ON TARGET-GOAL,2,4000,4000.8,Player8",
    "Home,SET PIECE,KICK OFF,2,4060,4060,Player5",
    "Away,CARD,RED,2,5000,5000,Player7",
    "Away,BALL OUT,,2,5744.88,5745.2,Player16",
)
METRICA = metrica(*METRICA_ROWS)

HOME_ID, AWAY_ID = 1631, 1612


_IDS = itertools.count(190078343)


def wyscout_event(
    period: str, sec: float, team: int, event: int, *tags: int, sub: int = 0, **more: Any
) -> dict[str, Any]:
    """An event in the shape of the interface: numbers under eventName."""
    return {
        "id": next(_IDS),
        "playerId": more.pop("player", 7),
        "teamId": team,
        "matchId": more.pop("match", 2499773),
        "matchPeriod": period,
        "eventSec": sec,
        "eventName": event,
        "subEventName": sub,
        "positions": [{"x": 50, "y": 50}],
        "tags": [{"id": tag} for tag in tags],
        **more,
    }


def wyscout_match() -> list[dict[str, Any]]:
    """A match with something of everything, extra time and a shoot-out."""
    return [
        wyscout_event("1H", 2.6, AWAY_ID, 8, 1801, sub=85),
        wyscout_event("1H", 148.1, HOME_ID, 2, sub=20),
        wyscout_event("1H", 899.058, AWAY_ID, 10, 101, 1801, 1206, sub=100),
        wyscout_event("1H", 901.5, HOME_ID, 9, 101, 1206, 1802, sub=90),  # the keeper's
        wyscout_event("1H", 982.8, HOME_ID, 2, 1702, sub=20),
        wyscout_event("1H", 1350.4, AWAY_ID, 3, 101, 1801, sub=33),
        wyscout_event("1H", 2000.0, HOME_ID, 10, 1801, 1203, sub=100),
        wyscout_event("1H", 2010.0, HOME_ID, 10, 1802, 1219, sub=100),
        wyscout_event("1H", 2020.0, HOME_ID, 10, 1802, 2101, sub=100),
        wyscout_event("1H", 2030.0, HOME_ID, 10, 1802, 1210, 201, sub=100),
        wyscout_event("1H", 2864.0, HOME_ID, 8, 1801, sub=85),
        wyscout_event("2H", 100.0, HOME_ID, 7, 102, 1401, sub=72),
        wyscout_event("2H", 103.0, HOME_ID, 9, 101, 1802, sub=91),
        wyscout_event("2H", 500.0, HOME_ID, 3, 101, 1801, sub=35),
        wyscout_event("2H", 600.0, AWAY_ID, 2, 1703, 1701, sub=20),
        wyscout_event("2H", 700.0, AWAY_ID, 2, 1701, sub=27),
        wyscout_event("2H", 800.0, AWAY_ID, 3, 1802, sub=35),
        wyscout_event("2H", 3000.0, AWAY_ID, 8, 1802, sub=85),
        wyscout_event("E1", 910.0, AWAY_ID, 8, 1802, sub=85),
        wyscout_event("E2", 920.0, AWAY_ID, 8, 1802, sub=85),
        wyscout_event("P", 10.0, AWAY_ID, 3, 101, 1801, sub=35),
        wyscout_event("P", 60.0, HOME_ID, 3, 1802, sub=35),
    ]


def wyscout_public(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The same events in the shape of the public data set: numbers under eventId, words too."""
    words = {2: "Foul", 3: "Free Kick", 7: "Others on the ball", 8: "Pass", 9: "Save attempt"}
    return [
        entry
        | {
            "eventId": entry["eventName"],
            "eventName": words.get(entry["eventName"], "Shot"),
            "subEventId": entry["subEventName"],
            "subEventName": "Free kick shot" if entry["subEventName"] == 33 else "",
        }
        for entry in events
    ]


def companion(**more: Any) -> dict[str, Any]:
    """A match of matches_*.json."""
    return {
        "wyId": 2499773,
        "label": "Northport City - Sudbury, 1 - 3",
        "dateutc": "2017-09-23 16:30:00",
        "teamsData": {
            str(AWAY_ID): {"side": "away", "score": 3, "scoreET": 0, "scoreP": 0},
            str(HOME_ID): {"side": "home", "score": 1, "scoreET": 0, "scoreP": 0},
        },
        **more,
    }


def openfootball(*matches: dict[str, Any]) -> dict[str, Any]:
    """A competition."""
    return {"name": "Village Cup 2020", "matches": list(matches)}


def fixture(team1: str = "Northport", team2: str = "Sudbury", **more: Any) -> dict[str, Any]:
    """A match of a competition."""
    return {
        "round": "Final",
        "date": "2020-07-15",
        "team1": team1,
        "team2": team2,
        "score": {"ft": [2, 1], "ht": [1, 0]},
        "goals1": [
            {"name": "Ada Berg", "minute": 45, "offset": 2},
            {"name": "Gro van der Holm", "minute": 80, "owngoal": True},
        ],
        "goals2": [{"name": "Eva Friis", "minute": 46, "penalty": True}],
        **more,
    }


WYSCOUT_TEXT = json.dumps(wyscout_match())
OPENFOOTBALL_TEXT = json.dumps(openfootball(fixture()))
MINUTES = (
    "minute,type,player,team\n"
    "18,own goal,Ada Berg,Northport\n"
    "45+2,yellow card,Eva Friis,Sudbury\n"
    "46,goal,Eva Friis,Sudbury\n"
    "60,substitution,Ada Berg,Northport\n"
    "70,penalty,Ada Berg,Northport\n"
    "90+3',second yellow,Eva Friis,Sudbury\n"
)
GOALSCORERS = (
    "date,home_team,away_team,team,scorer,minute,own_goal,penalty\n"
    "2014-07-08,Northport,Sudbury,Sudbury,Eva Friis,11,FALSE,FALSE\n"
    "2014-07-08,Northport,Sudbury,Northport,Mia Sudbury,29,TRUE,FALSE\n"
    "2014-07-08,Northport,Sudbury,Sudbury,Eva Friis,90,FALSE,TRUE\n"
    "2014-07-09,Sudbury,Eastham,Eastham,Ida Jensen,113,FALSE,FALSE\n"
)
