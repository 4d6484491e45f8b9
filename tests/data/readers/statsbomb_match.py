"""A small made-up match in StatsBomb's format, for tests."""

from __future__ import annotations

from typing import Any

HOME, AWAY = "Northport", "Sudbury"


def record(period: int, clock: str, kind: str, team: str = HOME, **more: Any) -> dict[str, Any]:
    """One event; `player` a name, everything else as in the file."""
    player = more.pop("player", None)
    entry: dict[str, Any] = {
        "id": more.pop("id", f"{period}-{clock}-{kind}-{team}"),
        "period": period,
        "timestamp": clock,
        "minute": 0,
        "type": {"id": 1, "name": kind},
        "team": {"id": 1, "name": team},
    }
    if player is not None:
        entry["player"] = {"id": 7, "name": player}
    return entry | more


def shot(period: int, clock: str, outcome: str, team: str = HOME, **more: Any) -> dict[str, Any]:
    details = {
        "outcome": {"id": 1, "name": outcome},
        "type": {"id": 1, "name": more.pop("shot_type", "Open Play")},
        "statsbomb_xg": more.pop("xg", 0.05),
    }
    return record(period, clock, "Shot", team, shot=details, **more)


def foul(period: int, clock: str, card: str | None = None, **more: Any) -> dict[str, Any]:
    details = {"card": {"id": 7, "name": card}} if card else {}
    return record(period, clock, "Foul Committed", foul_committed=details, **more)


def halves(*lengths: tuple[int, str]) -> list[dict[str, Any]]:
    """Half Start and Half End records of each (period, length)."""
    return [
        record(period, clock, kind, team, id=f"{kind} {period} {team}")
        for period, length in lengths
        for clock, kind in (("00:00:00.000", "Half Start"), (length, "Half End"))
        for team in (HOME, AWAY)
    ]


def match(*events: dict[str, Any]) -> list[dict[str, Any]]:
    """Two halves of 46:00.500 and 47:00.250 with `events` in them, in the order of a real file."""
    elevens = [record(1, "00:00:00.000", "Starting XI", team) for team in (HOME, AWAY)]
    rest = [*halves((1, "00:46:00.500"), (2, "00:47:00.250")), *events]
    return [*elevens, *sorted(rest, key=lambda e: (e["period"], e["timestamp"]))]


def full_match() -> list[dict[str, Any]]:
    """A match with something of everything, extra time and a shoot-out."""
    return match(
        *halves((3, "00:15:30.000"), (4, "00:16:00.000")),
        shot(1, "00:10:00.123", "Goal", player="Ada Berg", shot_type="Penalty", xg=0.76),
        foul(1, "00:20:00.000", player="Carla Dahl"),
        foul(1, "00:30:00.000", "Yellow Card", player="Carla Dahl", team=AWAY),
        shot(1, "00:40:00.000", "Saved", AWAY, player="Eva Friis"),
        shot(1, "00:46:00.400", "Off T", player="Ada Berg", xg=0.3),
        record(2, "00:05:00.000", "Own Goal Against", HOME, id="oga", player="Gro van der Holm"),
        record(2, "00:05:00.000", "Own Goal For", AWAY, id="ogf", related_events=["oga"]),
        foul(2, "00:07:00.000", "Second Yellow", player="Carla Dahl", team=AWAY),
        shot(2, "00:20:00.000", "Blocked", id="shot", related_events=["block"]),
        record(2, "00:20:00.500", "Block", AWAY, id="block", block={"save_block": True}),
        record(
            2,
            "00:30:00.000",
            "Bad Behaviour",
            player="Ada Berg",
            bad_behaviour={"card": {"id": 7, "name": "Yellow Card"}},
        ),
        shot(3, "00:02:00.000", "Post", player="Ada Berg"),
        shot(4, "00:03:00.000", "Wayward", player="Ada Berg", xg=0.01),
        shot(5, "00:00:10.000", "Goal", player="Ada Berg", shot_type="Penalty", xg=0.76),
        shot(5, "00:00:50.000", "Saved", AWAY, player="Eva Friis", shot_type="Penalty"),
    )
