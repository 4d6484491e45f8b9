"""A match is followed through the documents of a live service, as they change."""

from __future__ import annotations

import contextlib
import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

import overview_dsp as ov
from overview_dsp.data.feeds import network_sources
from overview_dsp.data.feeds.follower import Follower
from overview_dsp.data.feeds.network_sources import Http
from tests.data.feeds.servers import wait_until
from tests.data.readers.service_documents import (
    api_event,
    api_football,
    data_goal,
    football_data,
    liga_goal,
    open_liga,
)

KEY = "s3cret-k3y"


class Service:
    """HTTP server that gives one document, with its headers and status, and notes requests."""

    def __init__(self):
        self.document, self.headers, self.status = {}, {}, 200
        self.requests, self.served = [], 0
        outer = self

        class Handler(BaseHTTPRequestHandler):
            def log_message(self, *arguments):
                pass

            def do_GET(self):
                outer.requests.append((self.path, dict(self.headers)))
                with contextlib.suppress(OSError):
                    if self.path == "/moved":
                        self.send_response(302)
                        self.send_header("Location", f"http://localhost:{outer.port}/match")
                        self.end_headers()
                        return
                    body = json.dumps(outer.document).encode()
                    self.send_response(outer.status)
                    for name, value in outer.headers.items():
                        self.send_header(name, value)
                    self.send_header("Content-Length", str(len(body)))
                    self.end_headers()
                    self.wfile.write(body)
                    outer.served += 1

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.port = self._server.server_port
        threading.Thread(target=self._server.serve_forever, args=(0.01,), daemon=True).start()

    def url(self, path="/match"):
        return f"http://127.0.0.1:{self.port}{path}"

    def give(self, document):
        """Give a document, and return after it has been served."""
        self.document = document
        before = self.served
        assert wait_until(lambda: self.served > before + 1)

    def close(self):
        self._server.shutdown()
        self._server.server_close()


@pytest.fixture
def service():
    with contextlib.closing(Service()) as one:
        yield one


@contextlib.contextmanager
def followed(service, path="/match", every_s=0.05):
    live = ov.LiveTimeline()
    with contextlib.closing(Follower(live, Http(service.url(path), every_s)).start()) as follower:
        yield live, follower


def changes(live, since=0):
    return [
        (one.action, one.event.kind, one.event.label)
        for one in live.changes_since(since)
        if one.event.kind != "period"
    ]


def goal(minute, player="Karl Berg", detail="Normal Goal"):
    return api_event(minute, "Goal", detail, player=player)


def test_corrections_are_not_announced_and_a_withdrawn_goal_is(service):
    with followed(service) as (live, follower):
        service.give(api_football([goal(23)], "1H", 24, (1, 0)))
        assert changes(live) == [("added", "goal", "1-0 Berg 23'")]
        assert live.snapshot().known_until_s == 24 * 60
        assert live.duration_s == 90 * 60
        for corrected in (
            [goal(24)],  # its minute
            [goal(24, "Kim Dahl")],  # its scorer
            [goal(24, "Kim Dahl"), goal(24, "Kim Dahl")],  # repeated for a moment
            [goal(24, "Tim Mann", "Own Goal")],  # an own goal
        ):
            service.give(api_football(corrected, "1H", 26, (1, 0)))
            assert len(changes(live)) == 1, corrected
        review = api_event(24, "Var", "Goal cancelled", player="Tim Mann")
        service.give(api_football([*corrected, review], "1H", 28, (0, 0)))
        assert changes(live)[1:] == [
            ("retracted", "own_goal", "1-0 own goal, Mann 24'"),
            ("added", "withdrawn_goal", "Mann (Nordhavn) 24'"),
        ]
        late = api_event(90, "Goal", "Normal Goal", extra=5)
        service.give(api_football([late], "2H", 90, (1, 0), extra=6))
        assert not live.ended
        service.document = api_football([late], "FT", 90, (1, 0))
        assert wait_until(lambda: follower.over)
        assert live.ended
        assert live.snapshot().duration_s == 95 * 60
        assert live.snapshot().known_until_s is None
        assert follower.rejected == 0


@pytest.mark.parametrize(
    ("documents", "added"),
    [
        (
            [
                football_data([], minute=10),
                football_data([data_goal(23)], minute=23, score=(1, 0)),
                football_data([data_goal(23)], status="FINISHED", score=(1, 0)),
            ],
            ["1-0 Berg 23'"],
        ),
        (
            [
                open_liga([liga_goal(1, 0, 20)]),
                open_liga([liga_goal(1, 0, 20), liga_goal(1, 1, 50)], [("Halbzeit", 1, 0)]),
                open_liga([liga_goal(1, 0, 21), liga_goal(1, 1, 50)], [("Ende", 1, 1)], True),
            ],
            ["1-0 Berg 20'", "1-1 Berg 50'"],
        ),
    ],
)
def test_a_match_is_followed_to_its_end(service, documents, added):
    with followed(service) as (live, follower):
        for document in documents[:-1]:
            service.give(document)
        service.document = documents[-1]
        assert wait_until(lambda: follower.over)
    assert live.ended
    assert changes(live) == [("added", "goal", label) for label in added]


def test_a_match_that_has_not_begun_is_waited_for(service):
    service.document = api_football([], "NS", None)
    with followed(service) as (live, follower):
        assert wait_until(lambda: service.served > 2)
        assert "has not begun" in " ".join(follower.take_messages())
        service.give(api_football([], "1H", 1))
        assert live.snapshot().known_until_s == 60.0


def test_the_key_comes_from_the_environment_and_goes_to_its_host_only(service, monkeypatch):
    monkeypatch.setitem(network_sources.KEYS, "127.0.0.1", ("X-Auth-Token", "MADE_UP_TOKEN"))
    monkeypatch.setenv("MADE_UP_TOKEN", KEY)
    service.document = football_data([data_goal(23)], score=(1, 0))
    with followed(service, "/moved") as (live, follower):
        assert wait_until(lambda: live.revision > 0)
        messages, name = follower.take_messages(), follower.status_text
    sent = {path: headers.get("X-Auth-Token") for path, headers in service.requests}
    assert sent == {"/moved": KEY, "/match": None}
    assert KEY not in " ".join([*messages, name])


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("", "environment variable MADE_UP_TOKEN: set it to your key"),
        (KEY, "environment variable MADE_UP_TOKEN: its key was rejected"),
    ],
)
def test_a_refused_key_ends_with_one_line(service, monkeypatch, key, message):
    monkeypatch.setitem(network_sources.KEYS, "127.0.0.1", ("X-Auth-Token", "MADE_UP_TOKEN"))
    monkeypatch.setenv("MADE_UP_TOKEN", key)
    service.status = 403
    with followed(service) as (_, follower):
        assert wait_until(lambda: follower.over)
        said = " ".join(follower.take_messages())
    assert message in said
    assert KEY not in said
    assert len(service.requests) == 1


@pytest.mark.parametrize(
    ("status", "headers"),
    [
        (200, {"X-Requests-Available-Minute": "0", "X-RequestCounter-Reset": "30"}),
        (200, {"x-ratelimit-requests-remaining": "0"}),
        (429, {"Retry-After": "30"}),
        (429, {"X-RequestCounter-Reset": "30", "X-Requests-Available-Minute": "0"}),
    ],
)
def test_the_rate_limit_of_a_service_is_respected(service, status, headers):
    service.document, service.status, service.headers = football_data(), status, headers
    with followed(service) as (_, follower):
        assert wait_until(lambda: service.served == 1)
        assert not wait_until(lambda: service.served > 1, 1.0)
        assert not follower.over


def test_a_service_is_requested_every_30_s_unless_the_user_sets_another_interval(
    service, monkeypatch
):
    monkeypatch.setitem(network_sources.KEYS, "127.0.0.1", ("", ""))
    service.document = football_data()
    with followed(service, every_s=None):
        assert wait_until(lambda: service.served == 1)
        assert not wait_until(lambda: service.served > 1, 2.0)
    with followed(service, every_s=0.05):
        assert wait_until(lambda: service.served > 3)
