"""Where answers are kept: one SQLite file, with the study itself, so that it can be read alone.

Nothing that was acknowledged is lost: a row is on the disk before anybody hears of it. Nothing is
stored twice or changed: what came first stays. Lists are handed out in one transaction each, so two
people never have the same one.

Thread: any; one at a time.
"""

from __future__ import annotations

import hmac
import json
import secrets
import sqlite3
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, OutputError

_TABLES = """
CREATE TABLE IF NOT EXISTS study(key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS list(number INTEGER PRIMARY KEY, content TEXT NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS session(
  id TEXT PRIMARY KEY, request TEXT UNIQUE NOT NULL, secret TEXT NOT NULL,
  list INTEGER NOT NULL REFERENCES list(number), participant TEXT NOT NULL,
  started_utc TEXT NOT NULL, finished_utc TEXT, abandoned INTEGER NOT NULL DEFAULT 0) STRICT;
CREATE UNIQUE INDEX IF NOT EXISTS one_list ON session(list) WHERE NOT abandoned;
CREATE UNIQUE INDEX IF NOT EXISTS one_code ON session(participant) WHERE NOT abandoned;
CREATE TABLE IF NOT EXISTS trial(
  session TEXT NOT NULL REFERENCES session(id), trial TEXT NOT NULL, received_utc TEXT NOT NULL,
  row TEXT NOT NULL CHECK(json_valid(row)), PRIMARY KEY(session, trial)) STRICT;
"""
WAIT_S = 10.0
TOLD = ("response", "correct", "stimulus", "level")
"""What a page that is reloaded is told of its answers."""


class NoListLeftError(InputError):
    """All lists are handed out, or the participant's code is taken."""


@dataclass(frozen=True)
class Session:
    """One participant's session: its list's number, and what was stored of it, in order.

    `trials` are (id, received_utc, row).
    """

    id: str
    secret: str
    number: int
    participant: str
    started_utc: str
    finished_utc: str | None
    abandoned: bool = False
    trials: list[tuple[str, str, dict[str, Any]]] = field(default_factory=list)


def now() -> str:
    """The moment, ISO 8601 in UTC, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


@dataclass
class _Waiting:
    """A row that waits for the disk; then whether it is new, or why it isn't stored."""

    session: str
    trial: str
    row: str
    new: bool | None = None
    error: OutputError | None = None


class Store:
    """A study's SQLite file.

    Parameters
    ----------
    path
        A new file, or one of the same study.
    study, lists
        What `read_study` gives; left out for a file that is there.

    Raises
    ------
    InputError
        The file is of another study, no SQLite file, or isn't there.
    OutputError
        It can't be written.
    """

    def __init__(
        self,
        path: str | Path,
        study: dict[str, Any] | None = None,
        lists: Sequence[dict[str, Any]] = (),
    ) -> None:
        self.path = Path(path)
        self._lock = threading.Lock()
        self._writing = threading.Lock()
        self._waiting: deque[_Waiting] = deque()
        self._known: dict[str, tuple[str, int]] = {}
        if study is None and not self.path.is_file():
            raise InputError(f"{path}: no such file; `overview study serve` makes one")
        try:
            self._db = sqlite3.connect(
                self.path, timeout=WAIT_S, isolation_level=None, check_same_thread=False
            )
            self._db.execute("PRAGMA journal_mode=WAL")
            self._db.execute("PRAGMA synchronous=FULL")
            self._db.execute("PRAGMA foreign_keys=ON")
            self._db.executescript(_TABLES)
        except sqlite3.Error as error:
            raise InputError(f"{path}: can't be used ({error}); name another file") from None
        kept = self._value("study")
        if kept is None:
            if study is None:
                raise InputError(f"{path}: holds no study; `overview study serve` makes one")
            self._begin_study(study, lists)
            kept = json.dumps(study)
        self.study: dict[str, Any] = json.loads(kept)
        if study is not None and study["design_sha256"] != self.study["design_sha256"]:
            raise InputError(
                f"{path}: holds answers to another version of this study; name another file"
            )

    def _value(self, key: str) -> str | None:
        found = self._db.execute("SELECT value FROM study WHERE key = ?", (key,)).fetchone()
        return None if found is None else str(found[0])

    def _begin_study(self, study: dict[str, Any], lists: Sequence[dict[str, Any]]) -> None:
        with self._transaction():
            self._db.executemany(
                "INSERT INTO list VALUES(?, ?)", [(o["list"], json.dumps(o)) for o in lists]
            )
            self._db.execute("INSERT INTO study VALUES('study', ?)", (json.dumps(study),))

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All of it or nothing; on the disk when it is over."""
        with self._lock:
            try:
                self._db.execute("BEGIN IMMEDIATE")
                try:
                    yield
                except BaseException:
                    self._db.execute("ROLLBACK")
                    raise
                self._db.execute("COMMIT")
            except sqlite3.Error as error:
                if self._db.in_transaction:
                    self._db.execute("ROLLBACK")
                raise OutputError(f"{self.path}: nothing was stored ({error})") from None

    def begin(self, request: str, participant: str | None) -> tuple[Session, bool]:
        """Hand out the next free list; the same request gets the same session again.

        Returns the session, and whether it is a new one.

        Raises
        ------
        NoListLeftError
            No list is left, or the participant has one.
        """
        with self._transaction():
            known = self._db.execute("SELECT id FROM session WHERE request = ?", (request,))
            found = known.fetchone()
            if found is not None:
                return self._session(str(found[0])), False
            free = self._db.execute(
                "SELECT MIN(number) FROM list WHERE number NOT IN "
                "(SELECT list FROM session WHERE NOT abandoned)"
            ).fetchone()[0]
            if free is None:
                raise NoListLeftError("all lists are handed out; ask whoever runs the study")
            code = participant or f"p{free:03d}"
            taken = self._db.execute(
                "SELECT 1 FROM session WHERE participant = ? AND NOT abandoned", (code,)
            ).fetchone()
            if taken:
                raise NoListLeftError(f"{code} has a session already; give another code")
            id = secrets.token_hex(8)
            self._db.execute(
                "INSERT INTO session(id, request, secret, list, participant, started_utc) "
                "VALUES(?, ?, ?, ?, ?, ?)",
                (id, request, secrets.token_urlsafe(16), free, code, now()),
            )
            return self._session(id), True

    def list_number(self, id: str, secret: str) -> int | None:
        """The list of a session; None if there is none, or for a wrong secret."""
        if id not in self._known:
            with self._lock:
                row = self._db.execute("SELECT secret, list FROM session WHERE id = ?", (id,))
                found = row.fetchone()
            if found is None:
                return None
            self._known[id] = (str(found[0]), int(found[1]))
        wanted, number = self._known[id]
        return number if hmac.compare_digest(wanted.encode(), secret.encode()) else None

    def session(self, id: str) -> Session:
        """A session that is there, with its trials."""
        with self._lock:
            return self._session(id)

    def _session(self, id: str) -> Session:
        row = self._db.execute(
            "SELECT id, secret, list, participant, started_utc, finished_utc, abandoned "
            "FROM session WHERE id = ?", (id,),
        ).fetchone()  # fmt: skip
        trials = self._db.execute(
            "SELECT trial, received_utc, row FROM trial WHERE session = ? ORDER BY rowid", (id,)
        ).fetchall()
        id, secret, number, participant, started, finished, abandoned = row
        read = [(trial, utc, json.loads(text)) for trial, utc, text in trials]
        return Session(id, secret, number, participant, started, finished, bool(abandoned), read)

    def list_of(self, number: int) -> dict[str, Any]:
        """A list."""
        with self._lock:
            text = self._db.execute(
                "SELECT content FROM list WHERE number = ?", (number,)
            ).fetchone()[0]
        return json.loads(text)  # type: ignore[no-any-return]

    def put(self, session: str, trial: str, row: str) -> bool:
        """Store a trial's row (JSON); False if it was there before, which stays as it is.

        Those that wait for the disk together are written together.
        """
        mine = _Waiting(session, trial, row)
        self._waiting.append(mine)
        with self._writing:
            if mine.new is None and mine.error is None:
                self._write_waiting()
        if mine.error is not None:
            raise OutputError(str(mine.error))
        return bool(mine.new)

    def _write_waiting(self) -> None:
        batch = [self._waiting.popleft() for _ in range(len(self._waiting))]
        try:
            with self._transaction():
                written = [self._insert(one.session, one.trial, one.row) for one in batch]
        except OutputError as error:
            for one in batch:
                one.error = error
            return
        for one, new in zip(batch, written, strict=True):
            one.new = new

    def _insert(self, session: str, trial: str, row: str) -> bool:
        done = self._db.execute(
            "INSERT INTO trial VALUES(?, ?, ?, ?) ON CONFLICT DO NOTHING",
            (session, trial, now(), row),
        )
        return done.rowcount == 1

    def put_all(self, session: str, rows: Sequence[tuple[str, str]]) -> None:
        """Store many (trial, JSON) at once."""
        with self._transaction():
            for trial, row in rows:
                self._insert(session, trial, row)

    def finish(self, session: str) -> None:
        """Note that a session is complete."""
        with self._transaction():
            self._db.execute(
                "UPDATE session SET finished_utc = ? WHERE id = ? AND finished_utc IS NULL",
                (now(), session),
            )

    def abandon(self, number: int) -> str:
        """Let a list be handed out again; the participant's code. What was stored stays."""
        with self._transaction():
            found = self._db.execute(
                "SELECT id, participant FROM session WHERE list = ? AND NOT abandoned", (number,)
            ).fetchone()
            if found is None:
                raise InputError(f"{self.path}: list {number} isn't handed out")
            self._db.execute("UPDATE session SET abandoned = 1 WHERE id = ?", (found[0],))
            return str(found[1])

    def lists(self) -> dict[int, dict[str, Any]]:
        """Every list by its number."""
        with self._lock:
            rows = self._db.execute("SELECT number, content FROM list").fetchall()
        return {number: json.loads(text) for number, text in rows}

    def sessions(self) -> list[Session]:
        """All sessions, in the order they began."""
        with self._lock:
            ids = self._db.execute("SELECT id FROM session ORDER BY rowid").fetchall()
            return [self._session(id) for (id,) in ids]

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._db.close()
