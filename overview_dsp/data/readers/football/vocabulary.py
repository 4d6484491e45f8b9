"""Words for football events in tables with a minute per row (`minute_list`), by event kind.

A kind is a term (`SavedShot`, `Gelbe Karte`) or a sentence (`GOAL! Jones scores (1-0)`). Terms in
other languages, by `words.toml`, are replaced by English ones first, which `patterns.toml` finds.
"""

from __future__ import annotations

import functools
import re

from overview_dsp.data.readers.football.match_timeline import normalize_text
from overview_dsp.data.timeline.time_parsing import plain_letters
from overview_dsp.files.toml import load_toml

TRANSLATIONS: dict[str, list[str]] = load_toml(__file__, "words.toml")
"""Terms in other languages by the English term, from `words.toml`."""

_PATTERNS: dict[str, re.Pattern[str]] = {
    name: re.compile("|".join(parts))
    for name, parts in load_toml(__file__, "patterns.toml").items()
}

_ENGLISH = {word: term for term, words in TRANSLATIONS.items() for word in words}
_WORDS = "|".join(word.replace(" ", r"[\W_]+") for word in sorted(_ENGLISH, key=len, reverse=True))
_FOREIGN = re.compile(rf"[\W_]*(?P<term>{_WORDS})(?!\w)")
_LONG = 7
"""Length of a term that needs no mark after it: none so long is a family name."""

_LONG_O = re.compile("o{4,}")
_ONLY_ALONE = ("goal", "gol contra")
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def has(name: str, text: str) -> bool:
    """Return whether a text has one of the patterns of this name."""
    return _PATTERNS[name].search(text) is not None


@functools.lru_cache(maxsize=4096)
def normalize_terms(text: str, is_detail: bool = False) -> str:
    """Return text for comparison, with `SavedShot` as `saved shot`, beginning in English terms.

    In a detail, a term in another language is translated only if it is the whole text.
    """
    plain = _PATTERNS["sees"].sub("", _LONG_O.sub("ooo", plain_letters(_CAMEL.sub(" ", text))))
    words = normalize_text(plain)
    if not is_detail and (
        _PATTERNS["but"].match(plain) or _is_call(_PATTERNS["goal_call"].match(plain))
    ):
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
    """Return whether a term begins a call ("Gol! ..."): a mark or a preposition follows it."""
    if found is None:
        return False
    called = _PATTERNS["called"].match(found.string, found.end())
    return called is not None and _PATTERNS["no_call"].match(found.string, called.end()) is None


def is_sentence(text: str) -> bool:
    """Return whether the text of a kind has further words, such as names, which label the event."""
    return not all(_PATTERNS["term"].fullmatch(word) for word in normalize_terms(text).split())


@functools.lru_cache(maxsize=4096)
def meaning(kind: str, details: str, *, own: bool, penalty: bool) -> tuple[str, str]:
    """Return the event kind and the label's detail, such as `pen`, for the columns of a row.

    The kind is `half_end` or `match_end` for the end of a period, "" for all other texts.

    `kind`: normalized text of the column with the kind.
    `details`: normalized text of further columns, such as outcome, card and description.
    `own`, `penalty`: whether the row has its own column for own goals or penalties, and it is set.
    """
    both = f"{kind} {details}".strip()
    if has("cancelled", both) and not has("card", kind):
        return "", "cancelled"
    if has("shoot_out", both):
        return "", "shoot-out"
    card = _card(kind, details)
    if card is not None:
        return card
    is_penalty = penalty or bool(_PATTERNS["penalty"].fullmatch(kind) or has("penalty_named", both))
    if is_penalty and has("missed", both) and "own goal" not in both:
        return "near_miss", "penalty missed" if "saved" not in both else "penalty saved"
    is_own = own or has("own", both)
    if is_own or _is_goal(kind, details, is_penalty):
        if has("no_goal", both):
            return "", "cancelled"
        return ("own_goal", "") if is_own else ("goal", "pen" if is_penalty else "")
    if has("post", both):
        return "near_miss", "on the post"
    if has("saved", kind) or (has("shot", kind) and re.search(r"\bsaved\b|on target", details)):
        return "near_miss", "saved"
    if has("chance", both):
        return "near_miss", ""
    if re.match(r"fouls?\b|hand ?ball|free kick conceded", kind) or has("fouled", kind):
        suffered = has("suffered", both) or details == "successful"
        return ("", "suffered") if suffered else ("foul", "")
    ends = (name for text in (kind, both) for name in ("half_end", "match_end") if has(name, text))
    return next(ends, "period" if has("period", kind) else ""), ""


def _card(kind: str, details: str) -> tuple[str, str] | None:
    both = f"{kind} {details}".strip()
    if not (
        any(has(name, kind) for name in ("card", "red", "yellow", "second_yellow"))
        or has("card", details)
    ):
        return None
    if has("second_yellow", both):
        return "red_card", "second yellow"
    if has("red", both):
        return "red_card", ""
    return ("yellow_card", "") if has("yellow", both) else None


def _is_goal(kind: str, details: str, is_penalty: bool) -> bool:
    if "goal kick" in kind:
        return False
    bare = " ".join(re.sub(r"\b(?:penalty|pen|pk|p|from the spot|kick)\b", " ", kind).split())
    if any(map(_PATTERNS["goal"].fullmatch, (bare, kind))) or kind.startswith("goal scored "):
        return True
    if _PATTERNS["scores"].match(kind) and not has("missed", kind):
        return True
    outcome = details if not kind.startswith("penalty kick ") else f"{kind} {details}"
    is_alone = _PATTERNS["penalty"].fullmatch(kind) or bare in ("scored", "converted", "in")
    if is_penalty and (has("converted", outcome) or is_alone):
        return True
    return has("shot", kind) and bool(re.search(r"\bgoal\b|\bscored\b", details))
