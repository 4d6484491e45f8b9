"""Words for football events in tables with a minute per row (`minute_list`), by event kind.

A kind is a term (`SavedShot`, `Gelbe Karte`) or a sentence (`GOAL! Jones scores (1-0)`). Terms in
other languages, by `words.toml`, are replaced by English ones first.
"""

from __future__ import annotations

import functools
import re

from overview_dsp.data.readers.football.match_timeline import normalize_text
from overview_dsp.data.timeline.time_parsing import plain_letters
from overview_dsp.files.toml import load_toml

TRANSLATIONS: dict[str, list[str]] = load_toml(__file__, "words.toml")
"""Terms in other languages by the English term, from `words.toml`."""

_ENGLISH = {word: term for term, words in TRANSLATIONS.items() for word in words}
_WORDS = "|".join(word.replace(" ", r"[\W_]+") for word in sorted(_ENGLISH, key=len, reverse=True))
_FOREIGN = re.compile(rf"[\W_]*(?P<term>{_WORDS})(?!\w)")
_CALLED = re.compile(
    r"\s*(?:[!:.,;(\u2013\u2014]|-\s|(?:by|for|from|de|von|fur|durch|di|do|da|par|pour|van|voor)\b)"
)
"""What follows a term that begins a sentence: a mark, or who it was by. Names follow otherwise."""

_GOAL_CALL = re.compile(r"\W*goal(?!\w)")
_NO_CALL = re.compile(r"\W*(?:kick|keeper|line|post|mouth|area|attempt|chance|check|review)\b")
_BUT = re.compile(r"but(?:\s*!|\s+(?:de|du|par|pour)\b|\s*$)")  # a goal in French
_LONG = 7
"""Letters of a term that needs no such mark; none is a family name."""

_LONG_O = re.compile("o{4,}")
_SEES = re.compile(r".*\bsieht (?:die |noch )?(?=gelb|rot)")  # a card in German
_ONLY_ALONE = ("goal", "gol contra")
_SCORES = re.compile(
    r"(?!.*\b(?:nearly|almost|should|could|would|have|has|had|who|twice|not|never|to|if|when|after"
    r"|substitution|half|full|time|formation)\b)"
    r"(?:(?:[a-z]+ ){1,3}(?:scores|scored|converts)|penalty (?:scored|converted))\b(?! against)"
)
_NO_GOAL = re.compile(
    r"\brefuse\b|afgekeurd|zahlt nicht|zaehlt nicht|offside|abseits|hors jeu|fuera de juego"
    r"|fuorigioco|buitenspel|impedimento"
)
_CONVERTED = re.compile(r"\b(?:goal|scored|verwandelt|convertido|trasformato|transforme|benut)\b")
_TERM = re.compile(
    r"goals?|own|penalty|pen|cards?|yellow|red|second|2nd|1st|first|straight|fouls?|shots?|saved"
    r"|missed|blocked|on|off|hit|the|target|post|near|miss|big|chance|corner|kick|free|half|full"
    r"|time|start|end|whistle|final|period|substitution|offside|handball|header|normal|regular"
    r"|scored|won|suffered|committed|conceded|direct|open|play|keeper|assist|saves?|throw|in|tackle"
)
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
_MISSED = re.compile(
    r"miss|missed|saved|failed|off target|post|not scored|no goal|unconverted"
    r"|\b(?:verschossen|gehalten|vergeben|fallado|fallo|atajado|parado|sbagliato|parato|rate|manque"
    r"|arrete|falhado|gemist|gestopt)\b"
)
_OWN = re.compile(r"own goal|owngoal|\bog\b|autogoal")
_CANCELLED = re.compile(
    r"cancel|disallow|annul|anulad|aberkannt|overturn|ruled out|no goal|\bvar\b|overruled|rescinded"
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
    r"(?:shot|attempt|header|chance) saved|saved (?:shot|attempt|header|penalty)|^saved(?: by|$)"
    r"|shots? on target|on target$|shot on goal"
)
_POST = re.compile(
    r"trifft (?:nur )?(?:die |den )?(?:latte|pfosten)\b|\bpost\b|woodwork|crossbar"
    r"|\bhit (?:the )?bar\b|frame of the goal"
)
_CHANCE = re.compile(r"near miss|(?:big|clear|great|good) chance|^chance (?:for|by)\b")
_FOULED = re.compile(r"\bfouls\b|\bfoul (?:by|on)\b")
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
def normalize_terms(text: str, is_detail: bool = False) -> str:
    """Return text for comparison, with `SavedShot` as `saved shot`, beginning in English terms.

    Of a detail only the whole text is a term in another language.
    """
    plain = _SEES.sub("", _LONG_O.sub("ooo", plain_letters(_CAMEL.sub(" ", text))))
    words = normalize_text(plain)
    if not is_detail and (_BUT.match(plain) or _is_call(_GOAL_CALL.match(plain))):
        return f"goal scored {words}"
    found = _FOREIGN.match(plain)
    if found is None:
        return words
    term = normalize_text(found["term"])
    english, rest = _ENGLISH[term], normalize_text(plain[found.end() :])
    if not rest:
        return words if is_detail and english == "foul" else english  # Spanish `fallo` is a miss
    is_long = len(term) >= _LONG and not {english, term} & {*_ONLY_ALONE}
    if term == "gol contra" or is_detail or not (is_long or _is_call(found)):
        return words
    return f"goal scored {rest}" if english == "goal" else f"{english} {rest}"


def _is_call(found: re.Match[str] | None) -> bool:
    """Return whether a mark or a preposition follows a term."""
    if found is None:
        return False
    called = _CALLED.match(found.string, found.end())
    return called is not None and _NO_CALL.match(found.string, called.end()) is None


def is_sentence(text: str) -> bool:
    """Return whether the text of a kind has further words, such as names, which label the event."""
    return not all(_TERM.fullmatch(word) for word in normalize_terms(text).split())


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
    is_own = own or bool(_OWN.search(both))
    if is_own or _is_goal(kind, details, is_penalty):
        if _NO_GOAL.search(both):
            return "", "cancelled"
        return ("own_goal", "") if is_own else ("goal", "pen" if is_penalty else "")
    if _POST.search(both):
        return "near_miss", "on the post"
    if _SAVED.search(kind) or (_SHOT.search(kind) and re.search(r"\bsaved\b|on target", details)):
        return "near_miss", "saved"
    if _CHANCE.search(both):
        return "near_miss", ""
    if re.match(r"fouls?\b|hand ?ball|free kick conceded", kind) or _FOULED.search(kind):
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
    if kind.startswith("goal scored ") or (_SCORES.match(kind) and not _MISSED.search(kind)):
        return True
    said = details if not kind.startswith("penalty kick ") else f"{kind} {details}"
    if is_penalty and _CONVERTED.search(said):
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
