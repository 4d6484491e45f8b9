"""Access control by the token of a run.

The token is in the fragment of the printed URL. Browsers never send the fragment, so the token
appears in no log and no referrer. The page removes it from the history. It sends the token once, in
a header, and receives a cookie that scripts can't read and other sites can't use. The cookie also
authorises `<video>` elements and WebSockets, which can't send headers. It is valid for one run,
unless the token is stored in a file (`load_token`).

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

MAX_WRONG_TOKENS = 10
"""Wrong tokens per address within `WRONG_TOKEN_WINDOW_S`; further ones are rejected.

The right token is always accepted: users may share an address, and 128 bits can't be guessed."""

WRONG_TOKEN_WINDOW_S = 60.0
MAX_ADDRESSES = 1024
"""Number of addresses with stored failures; the oldest is dropped first."""


class Verdict(enum.Enum):
    """Result of an access check."""

    ALLOWED = enum.auto()
    MISSING = enum.auto()
    WRONG = enum.auto()
    LIMITED = enum.auto()


class Access:
    """Token and session of a run, and the failed attempts of each address."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, token: str | None = None
    ) -> None:
        """Use `token` over several runs, or create one for this run."""
        if token is None:
            self.token = secrets.token_urlsafe(16)
            self.session = secrets.token_urlsafe(32)
        else:
            self.token = token
            self.session = hashlib.sha256(f"session {token}".encode()).hexdigest()
        self._clock = clock
        self._failures: OrderedDict[str, deque[float]] = OrderedDict()

    def check(self, token: str | None, session: str | None, address: str) -> Verdict:
        """Check the token or session cookie of a request from an address.

        The cookie of an earlier run is ignored and not counted as a failure, so that reloading an
        old page doesn't lock the user out.
        """
        if session is not None and _same(session, self.session):
            return Verdict.ALLOWED
        if token is None:
            return Verdict.MISSING
        if _same(token, self.token):
            return Verdict.ALLOWED
        subnet = _subnet(address)
        failures = self._failures.get(subnet, deque())
        while failures and failures[0] < self._clock() - WRONG_TOKEN_WINDOW_S:
            failures.popleft()
        if len(failures) >= MAX_WRONG_TOKENS:
            return Verdict.LIMITED
        failures.append(self._clock())
        self._failures[subnet] = failures
        self._failures.move_to_end(subnet)
        if len(self._failures) > MAX_ADDRESSES:
            self._failures.popitem(last=False)
        return Verdict.WRONG


def load_token(path: str) -> str:
    """Return the token of a file; a missing file is created, readable by this user alone.

    InputError if the file contains no token, or can't be read or written.
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


def _same(value: str, expected: str) -> bool:
    # bytes: only ASCII text can be compared in constant time
    return secrets.compare_digest(value.encode("utf-8", "surrogatepass"), expected.encode())


def parse_ip(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an IP address, without its zone; None for any other text."""
    try:
        return ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None


def _subnet(address: str) -> str:
    """Return an IPv4 address, or the /64 network of an IPv6 address (one household)."""
    parsed = parse_ip(address)
    if parsed is not None and parsed.version == 6:
        return str(ipaddress.ip_network((parsed, 64), strict=False))
    return address if parsed is None else str(parsed)
