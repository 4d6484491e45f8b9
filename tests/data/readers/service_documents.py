"""Documents of live football services in their published shapes, with invented teams."""

from __future__ import annotations

import copy

HOME, AWAY = "Nordhavn", "Sudbury"


def api_event(elapsed, type_, detail, team=1, player="Karl Berg", extra=None, comments=None):
    return {
        "time": {"elapsed": elapsed, "extra": extra},
        "team": {"id": team, "name": {1: HOME, 2: AWAY}[team], "logo": "https://media.test/1.png"},
        "player": {"id": sum(map(ord, player)) if player else None, "name": player},
        "assist": {"id": None, "name": None},
        "type": type_,
        "detail": detail,
        "comments": comments,
    }


def api_football(events, status="2H", elapsed=70, goals=(0, 0), extra=None, penalty=(None, None)):
    """Return the document of `fixtures?id=...`."""
    return {
        "get": "fixtures",
        "parameters": {"id": "710001"},
        "errors": [],
        "results": 1,
        "paging": {"current": 1, "total": 1},
        "response": [
            {
                "fixture": {
                    "id": 710001,
                    "referee": None,
                    "timezone": "UTC",
                    "date": "2026-05-09T14:00:00+00:00",
                    "timestamp": 1778335200,
                    "periods": {"first": 1778335200, "second": None},
                    "status": {"long": "", "short": status, "elapsed": elapsed, "extra": extra},
                },
                "league": {"id": 9, "name": "First League", "season": 2025, "round": "Round 30"},
                "teams": {
                    "home": {"id": 1, "name": HOME, "winner": None},
                    "away": {"id": 2, "name": AWAY, "winner": None},
                },
                "goals": {"home": goals[0], "away": goals[1]},
                "score": {
                    "halftime": {"home": 0, "away": 0},
                    "fulltime": {"home": None, "away": None},
                    "extratime": {"home": None, "away": None},
                    "penalty": {"home": penalty[0], "away": penalty[1]},
                },
                "events": copy.deepcopy(events),
            }
        ],
    }


def api_list(events):
    """Return the document of `fixtures/events?fixture=...`."""
    return {
        "get": "fixtures/events",
        "parameters": {"fixture": "710001"},
        "errors": [],
        "results": len(events),
        "paging": {"current": 1, "total": 1},
        "response": copy.deepcopy(events),
    }


def data_goal(minute, team=1, scorer="Karl Berg", type_="REGULAR", added=None):
    return {
        "minute": minute,
        "injuryTime": added,
        "type": type_,
        "team": {"id": team, "name": {1: HOME, 2: AWAY}[team]},
        "scorer": {"id": sum(map(ord, scorer)), "name": scorer},
        "assist": None,
        "score": {"home": 0, "away": 0},
    }


def data_card(minute, team=1, player="Ole Lund", card="YELLOW"):
    return {
        "minute": minute,
        "team": {"id": team, "name": {1: HOME, 2: AWAY}[team]},
        "player": {"id": sum(map(ord, player)), "name": player},
        "card": card,
    }


def football_data(goals=(), cards=(), status="IN_PLAY", minute=70, score=(0, 0), **more):
    """Return the document of `matches/...` of football-data.org."""
    return {
        "area": {"id": 1, "name": "Nowhere", "code": "NOW", "flag": None},
        "competition": {"id": 7, "name": "First League", "code": "L1", "type": "LEAGUE"},
        "season": {"id": 3, "currentMatchday": 30},
        "id": 440011,
        "utcDate": "2026-05-09T14:00:00Z",
        "status": status,
        "minute": minute,
        "injuryTime": None,
        "matchday": 30,
        "stage": "REGULAR_SEASON",
        "homeTeam": {"id": 1, "name": HOME, "shortName": HOME, "tla": "NOR"},
        "awayTeam": {"id": 2, "name": AWAY, "shortName": AWAY, "tla": "SUD"},
        "score": {
            "winner": None,
            "duration": "REGULAR",
            "fullTime": {"home": score[0], "away": score[1]},
            "halfTime": {"home": None, "away": None},
            **more,
        },
        "goals": copy.deepcopy(list(goals)),
        "penalties": [],
        "bookings": copy.deepcopy(list(cards)),
        "substitutions": [],
    }


def liga_goal(one, two, minute, scorer="Berg", goal_id=1, **flags):
    return {
        "goalID": goal_id,
        "scoreTeam1": one,
        "scoreTeam2": two,
        "matchMinute": minute,
        "goalGetterID": 5,
        "goalGetterName": scorer,
        "isPenalty": False,
        "isOwnGoal": False,
        "isOvertime": False,
        "comment": None,
        **flags,
    }


def open_liga(goals=(), results=(), finished=False):
    """Return the document of `getmatchdata/ID` of OpenLigaDB."""
    return {
        "matchID": 61234,
        "matchDateTime": "2026-05-09T15:30:00",
        "timeZoneID": "W. Europe Standard Time",
        "leagueId": 4500,
        "leagueName": "1. Liga",
        "leagueSeason": 2025,
        "leagueShortcut": "l1",
        "matchDateTimeUTC": "2026-05-09T13:30:00Z",
        "group": {"groupName": "30. Spieltag", "groupOrderID": 30, "groupID": 1},
        "team1": {"teamId": 1, "teamName": HOME, "shortName": HOME, "teamIconUrl": ""},
        "team2": {"teamId": 2, "teamName": AWAY, "shortName": AWAY, "teamIconUrl": ""},
        "lastUpdateDateTime": "2026-05-09T16:30:00",
        "matchIsFinished": finished,
        "matchResults": [
            {
                "resultID": n,
                "resultName": name,
                "pointsTeam1": one,
                "pointsTeam2": two,
                "resultOrderID": n,
                "resultTypeID": n,
            }
            for n, (name, one, two) in enumerate(results, 1)
        ],
        "goals": copy.deepcopy(list(goals)),
        "location": None,
        "numberOfViewers": None,
    }
