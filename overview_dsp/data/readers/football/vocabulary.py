"""Words for football events in tables with a minute per row (`minute_list`), by event kind."""

from __future__ import annotations

import functools
import re

from overview_dsp.data.readers.football.match_timeline import normalize_text

_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")
_GOAL = re.compile(
    r"(?:goals?|scored|scores|g|normal goal|(?:free kick|freekick|header|headed|open play"
    r"|long range|left foot|right foot|winning|equalising|opening|regular|field) goal"
    r"|goal (?:scored|header|headed|free kick|open play|normal|regular|from (?:free kick|open play)"
    r"|left foot|right foot))"
)
_PENALTY = re.compile(r"(?:penalty|pen|penalties|pk|p)")
_PENALTY_NAMED = re.compile(
    r"\b(?:penalty|pen|pk)\b(?! (?:area|box|won|conceded|committed))|\bgoal p\b"
)
_MISSED = re.compile(r"miss|missed|saved|failed|off target|post|not scored|no goal|unconverted")
_OWN = re.compile(r"own goal|owngoal|\bog\b|autogoal")
_CANCELLED = re.compile(
    r"cancel|disallow|annul|overturn|ruled out|no goal|\bvar\b|overruled|rescinded"
)
_SECOND_YELLOW = re.compile(
    r"second yellow|2nd yellow|yellow red|yellowred|second booking|\b2y\b|\by2c\b|\byrc\b"
)
_RED = re.compile(r"\bred\b|\bredcard\b|\brc\b|sent off|sending off|dismiss|straight red|expelled")
_YELLOW = re.compile(
    r"\byellow\b|\byellowcard\b|\byc\b|\bbooked\b|\bbooking\b|\bcaution(?:ed)?\b|first yellow"
)
_CARD = re.compile(r"\bcards?\b")
_SHOT = re.compile(r"\bshots?\b|\battempts?\b|\bheader\b|\bchance\b")
_SAVED = re.compile(
    r"(?:shot|attempt|header|chance) saved|saved (?:shot|attempt|header|penalty)|^saved$"
    r"|shots? on target|on target$|shot on goal"
)
_POST = re.compile(r"\bpost\b|woodwork|crossbar|\bhit (?:the )?bar\b|frame of the goal")
_CHANCE = re.compile(r"near miss|big chance|clear chance|great chance|good chance")
_SUFFERED = re.compile(r"\bwon\b|suffered|drawn|received|fouled|against")
_SHOOT_OUT = re.compile(r"shoot ?out|penalty series|kicks from the (?:penalty )?mark")
_HALF_END = re.compile(
    r"half ?time|^ht$|^(?:half |period )?end$|end (?:of )?(?:the )?(?:first|1st) half"
    r"|(?:first|1st) half end"
)
_MATCH_END = re.compile(
    r"full ?time|^ft$|end (?:of )?(?:the )?(?:second|2nd) half|(?:second|2nd) half end|match end"
    r"|end (?:of )?(?:the )?match|final whistle|game end|^aet$"
)
_PERIOD = re.compile(
    r"kick ?off|^periods?|period (?:start|end)|half (?:start|end|begins)|start|^end$|extra time"
    r"|second half|first half|2nd half|1st half|whistle"
)


@functools.lru_cache(maxsize=4096)
def normalize_terms(text: str) -> str:
    """Return text for comparison, with `SavedShot` as `saved shot`."""
    return normalize_text(_CAMEL.sub(" ", text))


@functools.lru_cache(maxsize=4096)
def meaning(kind: str, details: str, *, own: bool, penalty: bool) -> tuple[str, str]:
    """Return the event kind and the label's detail for the columns of a row.

    Parameters
    ----------
    kind
        Normalized text of the column with the kind.
    details
        Normalized text of further columns, such as outcome, card and description.
    own, penalty
        Whether the row has its own column for own goals or penalties, and it is set.

    Returns
    -------
    tuple
        Event kind, and detail such as `pen` or `saved`. The kind is `half_end` or `match_end` for
        the end of a period, "" for all other texts.
    """
    both = f"{kind} {details}".strip()
    if _CANCELLED.search(both) and not _CARD.search(kind):
        return "", "cancelled"
    if _SHOOT_OUT.search(both):
        return "", "shoot-out"
    card = _card(kind, details)
    if card is not None:
        return card
    is_penalty = penalty or bool(_PENALTY.fullmatch(kind) or _PENALTY_NAMED.search(both))
    if is_penalty and _MISSED.search(both) and "own goal" not in both:
        return "near_miss", "penalty missed" if "saved" not in both else "penalty saved"
    if own or _OWN.search(both):
        return "own_goal", ""
    if _is_goal(kind, details, is_penalty):
        return "goal", "pen" if is_penalty else ""
    if _POST.search(both):
        return "near_miss", "on the post"
    if _SAVED.search(kind) or (_SHOT.search(kind) and re.search(r"\bsaved\b|on target", details)):
        return "near_miss", "saved"
    if _CHANCE.search(both):
        return "near_miss", ""
    if re.match(r"fouls?\b|hand ?ball|free kick conceded", kind):
        suffered = _SUFFERED.search(both) or details == "successful"
        return ("", "suffered") if suffered else ("foul", "")
    return _period_kind(kind, both), ""


def _card(kind: str, details: str) -> tuple[str, str] | None:
    both = f"{kind} {details}".strip()
    if not (
        any(pattern.search(kind) for pattern in (_CARD, _RED, _YELLOW, _SECOND_YELLOW))
        or _CARD.search(details)
    ):
        return None
    if _SECOND_YELLOW.search(both):
        return "red_card", "second yellow"
    if _RED.search(both):
        return "red_card", ""
    return ("yellow_card", "") if _YELLOW.search(both) else None


def _is_goal(kind: str, details: str, is_penalty: bool) -> bool:
    if "goal kick" in kind:
        return False
    bare = " ".join(re.sub(r"\b(?:penalty|pen|pk|p|from the spot|kick)\b", " ", kind).split())
    if _GOAL.fullmatch(bare) or _GOAL.fullmatch(kind):
        return True
    if is_penalty and (_PENALTY.fullmatch(kind) or bare in ("scored", "converted", "in")):
        return True
    return bool(_SHOT.search(kind)) and bool(re.search(r"\bgoal\b|\bscored\b", details))


def _period_kind(kind: str, both: str) -> str:
    for text in (kind, both):
        if _HALF_END.search(text):
            return "half_end"
        if _MATCH_END.search(text):
            return "match_end"
    return "period" if _PERIOD.search(kind) else ""
