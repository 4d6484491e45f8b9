"""A server of a study in this process, and what a page asks it."""

from __future__ import annotations

import http.client
import json
import uuid
from contextlib import contextmanager

from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.server import WebServer, listen, make_app
from overview_studies.routes import SESSIONS, study_routes
from overview_studies.store import Store

TOKEN = "a-token-for-tests-only-0"


def serve(folder, store, socket):
    app = make_app(Access(token=TOKEN), set(), print, None, study_routes(folder, store), ("/",))
    return WebServer(app, [socket], None, print, crowd=True)


@contextmanager
def serving(folder, study, lists):
    """The port of a server that keeps answers in the folder's responses.sqlite."""
    store = Store(folder / "responses.sqlite", study, list(lists.values()))
    (folder / "study.json").write_text("{}")
    (folder / "files.js").write_text('self.FILES = {"page": ["study.json"], "more": []};\n')
    socket = listen("127.0.0.1", 0)
    server = serve(folder, store, socket)
    try:
        yield socket.getsockname()[1]
    finally:
        server.close()
        store.close()


class Page:
    """One participant's page: asks and answers as docs/explanation/study-format.md says."""

    def __init__(self, port, participant=None):
        self.port, self.participant = port, participant
        self.request = uuid.uuid4().hex
        self.connection = None
        self.told = {}

    def ask(self, method, path, body=None, token=TOKEN, **headers):
        """Status and answer; ConnectionError and its like when nobody is there."""
        if self.connection is None:
            self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        data = None if body is None else json.dumps(body).encode()
        own = {
            "authorization": f"Bearer {token}",
            "origin": f"http://127.0.0.1:{self.port}",
            "x-study-secret": self.told.get("secret", ""),
            **headers,
        }
        try:
            self.connection.request(method, path, data, own)
            answer = self.connection.getresponse()
            text = answer.read().decode()
        except Exception:
            self.connection.close()
            self.connection = None
            raise
        return answer.status, json.loads(text) if text.startswith("{") else text

    def begin(self):
        body = {"request": self.request}
        if self.participant is not None:
            body["participant"] = self.participant
        status, told = self.ask("POST", SESSIONS, body)
        if status < 300:
            self.told = told
        return status, told

    def close(self):
        if self.connection is not None:
            self.connection.close()
            self.connection = None

    @property
    def own(self):
        return f"{SESSIONS}/{self.told['session']}"

    def put(self, trial, row):
        return self.ask("PUT", f"{self.own}/trials/{trial}", row)

    def look(self):
        return self.ask("GET", self.own)

    def finish(self):
        return self.ask("POST", f"{self.own}/finish", {})
