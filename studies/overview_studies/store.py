"""Storage of answers: one SQLite file, which also contains the study.

A row is written to storage before it is acknowledged. Stored rows never change, and a second row
of the same trial is ignored. A list is assigned in one transaction, so two participants never share
one.

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
SIMULATED = "simulated observer"
"""Source of simulated answers; pages cannot send it."""
SIMULATED_REQUEST = "simulated-"
"""Start of the request of each simulated session; pages cannot send it."""
RESUME_KEYS = ("response", "correct", "stimulus", "level")
"""Keys of an answer that a reloaded page receives."""


class NoListLeftError(InputError):
    """All lists are in use, or the participant's code is."""


@dataclass(frozen=True)
class Session:
    """Session of one participant: list number and stored rows in order.

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


def utc_now() -> str:
    """Return the current time, ISO 8601 in UTC, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


@dataclass
class _PendingRow:
    """Row to be written; then whether it is new, or the error."""

    session: str
    trial: str
    row: str
    new: bool | None = None
    error: OutputError | None = None


class Store:
    """SQLite file of a study.

    Parameters
    ----------
    path
        A new file, or a file of the same study.
    study, lists
        Results of `read_study`; not needed for an existing file.
    simulated
        Whether the answers are simulated. A file never has both kinds of answers.

    Raises
    ------
    InputError
        The file does not exist, is not an SQLite file, belongs to another study, or has answers of
        the other kind.
    OutputError
        The file cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        study: dict[str, Any] | None = None,
        lists: Sequence[dict[str, Any]] = (),
        *,
        simulated: bool = False,
    ) -> None:
        self.path = Path(path)
        self._lock = threading.Lock()
        self._writing = threading.Lock()
        self._pending: deque[_PendingRow] = deque()
        self._known: dict[str, tuple[str, int]] = {}
        if study is None and not self.path.is_file():
            raise InputError(f"{path}: no such file; create it with `overview study serve`")
        try:
            self._db = sqlite3.connect(
                self.path, timeout=WAIT_S, isolation_level=None, check_same_thread=False
            )
            self._db.execute("PRAGMA journal_mode=WAL")
            self._db.execute("PRAGMA synchronous=FULL")
            self._db.execute("PRAGMA foreign_keys=ON")
            self._db.executescript(_TABLES)
        except sqlite3.Error as error:
            raise InputError(
                f"{path}: is not a file of answers, which `overview study serve` and `simulate` "
                f"write ({error}); choose another file"
            ) from None
        stored = self._value("study")
        if stored is None:
            if study is None:
                raise InputError(
                    f"{path}: contains no study; create it with `overview study serve`"
                )
            self._begin_study(study, lists, simulated)
            stored = json.dumps(study)
        self.study: dict[str, Any] = json.loads(stored)
        if study is not None and study["design_sha256"] != self.study["design_sha256"]:
            raise InputError(
                f"{path}: contains answers to another version of this study; choose another file"
            )
        self.simulated = self._is_simulated()
        if study is not None and simulated != self.simulated:
            kind = "simulated answers" if self.simulated else "the answers of people"
            raise InputError(
                f"{path}: stores {kind}; simulated answers need a file of their own; choose another"
            )

    def _is_simulated(self) -> bool:
        # files of version 0.2.0 and earlier have no field
        sent = f"{SIMULATED_REQUEST}%"
        query = "SELECT 1 FROM session WHERE request LIKE ?"
        return bool(self._value("simulated") or self._db.execute(query, (sent,)).fetchone())

    def _value(self, key: str) -> str | None:
        found = self._db.execute("SELECT value FROM study WHERE key = ?", (key,)).fetchone()
        return None if found is None else str(found[0])

    def _begin_study(
        self, study: dict[str, Any], lists: Sequence[dict[str, Any]], simulated: bool
    ) -> None:
        with self._transaction():
            self._db.executemany(
                "INSERT INTO list VALUES(?, ?)", [(o["list"], json.dumps(o)) for o in lists]
            )
            self._db.execute("INSERT INTO study VALUES('study', ?)", (json.dumps(study),))
            if simulated:
                self._db.execute("INSERT INTO study VALUES('simulated', 'yes')")

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """Run one transaction; it is in permanent storage when the context ends."""
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
        """Assign the next free list; a repeated request returns the same session.

        The second value is true for a new session.

        Raises
        ------
        NoListLeftError
            No list is left, or the participant already has a session.
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
                raise NoListLeftError("all lists are in use; please contact the experimenter")
            code = participant or f"p{free:03d}"
            taken = self._db.execute(
                "SELECT 1 FROM session WHERE participant = ? AND NOT abandoned", (code,)
            ).fetchone()
            if taken:
                raise NoListLeftError(f"{code} already has a session; enter another code")
            id = secrets.token_hex(8)
            self._db.execute(
                "INSERT INTO session(id, request, secret, list, participant, started_utc) "
                "VALUES(?, ?, ?, ?, ?, ?)",
                (id, request, secrets.token_urlsafe(16), free, code, utc_now()),
            )
            return self._session(id), True

    def list_number(self, id: str, secret: str) -> int | None:
        """Return the list of a session; None if the session is unknown or the secret is wrong."""
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
        """Return an existing session with its trials."""
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

    def load_list(self, number: int) -> dict[str, Any]:
        """Return a list."""
        with self._lock:
            text = self._db.execute(
                "SELECT content FROM list WHERE number = ?", (number,)
            ).fetchone()[0]
        return json.loads(text)  # type: ignore[no-any-return]

    def put(self, session: str, trial: str, row: str) -> bool:
        """Store a trial's row (JSON); return False if the trial already has a row.

        Rows that wait at the same time are written in one transaction.
        """
        pending = _PendingRow(session, trial, row)
        self._pending.append(pending)
        with self._writing:
            if pending.new is None and pending.error is None:
                self._write_pending()
        if pending.error is not None:
            raise OutputError(str(pending.error))
        return bool(pending.new)

    def _write_pending(self) -> None:
        batch = [self._pending.popleft() for _ in range(len(self._pending))]
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
            (session, trial, utc_now(), row),
        )
        return done.rowcount == 1

    def put_all(self, session: str, rows: Sequence[tuple[str, str]]) -> None:
        """Store several (trial, JSON) rows in one transaction."""
        with self._transaction():
            for trial, row in rows:
                self._insert(session, trial, row)

    def finish(self, session: str) -> None:
        """Mark a session as complete."""
        with self._transaction():
            self._db.execute(
                "UPDATE session SET finished_utc = ? WHERE id = ? AND finished_utc IS NULL",
                (utc_now(), session),
            )

    def abandon(self, number: int) -> str:
        """Release a list for another session; return the participant's code. Stored rows stay."""
        with self._transaction():
            found = self._db.execute(
                "SELECT id, participant FROM session WHERE list = ? AND NOT abandoned", (number,)
            ).fetchone()
            if found is None:
                raise InputError(f"{self.path}: list {number} is not in use")
            self._db.execute("UPDATE session SET abandoned = 1 WHERE id = ?", (found[0],))
            return str(found[1])

    def lists(self) -> dict[int, dict[str, Any]]:
        """Return every list by number."""
        with self._lock:
            rows = self._db.execute("SELECT number, content FROM list").fetchall()
        return {number: json.loads(text) for number, text in rows}

    def sessions(self) -> list[Session]:
        """Return all sessions, in order of their start."""
        with self._lock:
            ids = self._db.execute("SELECT id FROM session ORDER BY rowid").fetchall()
            return [self._session(id) for (id,) in ids]

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._db.close()
