"""Who may come in: whoever holds the token of this run.

The token stands in the fragment of the printed address, which browsers never send: it is in no
log, no referrer and, once the page has taken it out, in no history. The page hands it over once, in
a header, and gets a cookie that scripts can't read and other sites can't use. So a `<video>` and a
WebSocket, which can't carry headers, are let in as well. The cookie isn't the token: what it gives
is over when this run is, unless its token is kept in a file (`kept_token`).

Thread: the server's.
"""

from __future__ import annotations

import enum
import hashlib
import ipaddress
import os
import re
import secrets
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from pathlib import Path

from overview_dsp.errors import InputError

MAX_WRONG = 10
"""Wrong tokens of an address within `WRONG_WITHIN_S`; the next ones are told to wait. The right one
is let in all the same: others share the address, and 128 bits aren't guessed."""

WRONG_WITHIN_S = 60.0
MAX_ADDRESSES = 1024
"""Addresses whose wrong tokens are kept; the longest unheard of is forgotten first."""


class Verdict(enum.Enum):
    """What becomes of a request."""

    ALLOWED = enum.auto()
    MISSING = enum.auto()
    WRONG = enum.auto()
    LIMITED = enum.auto()


class Access:
    """The token of a run, its session, and the wrong tokens of each address."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, token: str | None = None
    ) -> None:
        """`token`: one that is kept over runs (`kept_token`); so is the session it gives."""
        if token is None:
            self.token = secrets.token_urlsafe(16)
            self.session = secrets.token_urlsafe(32)
        else:
            self.token = token
            self.session = hashlib.sha256(f"session {token}".encode()).hexdigest()
        self._clock = clock
        self._wrong: OrderedDict[str, deque[float]] = OrderedDict()

    def check(self, token: str | None, session: str | None, address: str) -> Verdict:
        """Whether a token or a session cookie lets a request of an address in.

        A cookie of an earlier run is as good as none and isn't counted: it can't be guessed, and
        who reloads an old page must not be locked out of the new one.
        """
        if session is not None and _same(session, self.session):
            return Verdict.ALLOWED
        if token is None:
            return Verdict.MISSING
        if _same(token, self.token):
            return Verdict.ALLOWED
        whose = _subnet(address)
        wrong = self._recent(whose)
        if len(wrong) >= MAX_WRONG:
            return Verdict.LIMITED
        wrong.append(self._clock())
        self._wrong[whose] = wrong
        self._wrong.move_to_end(whose)
        if len(self._wrong) > MAX_ADDRESSES:
            self._wrong.popitem(last=False)
        return Verdict.WRONG

    def _recent(self, whose: str) -> deque[float]:
        wrong = self._wrong.get(whose, deque())
        since = self._clock() - WRONG_WITHIN_S
        while wrong and wrong[0] < since:
            wrong.popleft()
        return wrong


def kept_token(path: str) -> str:
    """The token of a file; a new one is written where there is none, for this user alone.

    Raises
    ------
    InputError
        The file holds something else, or can't be read or written.
    """
    file = Path(path)
    try:
        if not file.exists():
            with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as new:
                new.write(secrets.token_urlsafe(16) + "\n")
        token = file.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a token"
        raise InputError(f"--token-file {path}: {reason}; name a new file") from None
    if not re.fullmatch(r"[A-Za-z0-9_-]{22,128}", token):
        raise InputError(
            f"--token-file {path}: not a token (22 to 128 letters, digits, - or _); remove it or "
            "name a new file"
        )
    return token


def _same(given: str, wanted: str) -> bool:
    # bytes: texts must be ASCII to be compared in constant time
    return secrets.compare_digest(given.encode("utf-8", "surrogatepass"), wanted.encode())


def _subnet(address: str) -> str:
    """An IPv4 address, or the /64 of an IPv6 one: a household has all of that."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if found.version == 6:
        return str(ipaddress.ip_network((found, 64), strict=False))
    return str(found)
