"""Who is let in, and what becomes of everyone else: real sockets, a live engine behind them."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
import time

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.web import server as web_server
from overview_dsp.web.assets import served_paths
from overview_dsp.web.media import open_media
from overview_dsp.web.security import middleware
from overview_dsp.web.security.auth_token import (
    MAX_WRONG_TOKENS,
    WRONG_TOKEN_WINDOW_S,
    Access,
    Verdict,
)
from overview_dsp.web.security.middleware import host_is_ours, origin_is_ours
from tests.web.serving import served

DATA = "/data/timeline.json"


@pytest.fixture(scope="module")
def server(match):
    with served(match, plays=False) as running:
        yield running


@pytest.fixture
def fresh(match):
    """A server whose wrong tokens and connections are a test's own."""
    with served(match, plays=False) as running:
        yield running


def raw(server, request: bytes, seconds: float = 5.0) -> bytes:
    """What comes back for exactly these bytes."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=seconds) as line:
        line.sendall(request)
        answer = b""
        while part := line.recv(65536):
            answer += part
        return answer


def status(answer: bytes) -> int:
    return int(answer.split(b" ", 2)[1])


def test_the_page_itself_is_anyones_and_holds_no_data(server):
    for path in served_paths():
        answer = httpx.get(server.origin + path)
        assert answer.status_code == 200, path
        assert server.access.token not in answer.text
        again = httpx.get(server.origin + path, headers={"If-None-Match": answer.headers["etag"]})
        assert again.status_code == 304


def test_every_answer_forbids_inline_scripts_frames_and_other_sites(server):
    with server.client() as owner, server.client(None) as stranger:
        answers = [owner.get("/"), owner.get(DATA), stranger.get(DATA), owner.get("/nothing")]
    assert [one.status_code for one in answers] == [200, 200, 401, 404]
    for answer in answers:
        policy = dict(
            part.strip().split(" ", 1)
            for part in answer.headers["content-security-policy"].split(";")
        )
        assert policy["default-src"] == "'none'"
        assert policy["script-src"] == "'self' 'wasm-unsafe-eval'"
        assert policy["connect-src"] == "'self'"
        assert policy["frame-ancestors"] == "'none'"
        assert "unsafe-inline" not in str(policy)
        assert answer.headers["cross-origin-opener-policy"] == "same-origin"
        assert answer.headers["cross-origin-embedder-policy"] == "require-corp"
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
    page = answers[0].text
    assert "<script>" not in page
    assert "style=" not in page
    assert not re.search(r"\son\w+=", page)


def test_the_page_names_no_other_server(server):
    for path in served_paths():
        answer = httpx.get(server.origin + path)
        if answer.headers["content-type"].startswith("text/"):
            text = answer.text
            assert "http://" not in text, path
            assert "https://" not in text, path


@pytest.mark.parametrize("token", [None, "wrong", "é", "a" * 5000])
def test_without_the_token_there_is_no_data(fresh, token):
    with fresh.client(token) as stranger:
        for path in (DATA, "/control", "/nothing"):
            assert stranger.get(path).status_code == 401
        assert stranger.post("/session", headers={"Origin": fresh.origin}).status_code == 401


def test_the_token_in_the_address_is_refused_as_it_would_be_logged(server):
    answer = httpx.get(f"{server.origin}{DATA}?token={server.access.token}")
    assert answer.status_code == 401


def test_the_token_becomes_a_cookie_that_scripts_and_other_sites_cant_use(server):
    with server.client(Origin=server.origin) as owner:
        answer = owner.post("/session")
        assert answer.status_code == 204
        cookie = answer.headers["set-cookie"].lower()
        assert {"httponly", "samesite=strict", "path=/"} <= set(cookie.replace(" ", "").split(";"))
        assert server.access.token not in answer.headers["set-cookie"]
        session = dict(owner.cookies)
    assert httpx.get(server.origin + DATA, cookies=session).status_code == 200
    other = dict.fromkeys(session, "x" * 43)
    assert httpx.get(server.origin + DATA, cookies=other).status_code == 401


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1", "https://127.0.0.1:{port}", ""]
)
def test_a_foreign_origin_is_refused_even_with_the_token(server, origin):
    origin = origin.format(port=server.port)
    with server.client(Origin=origin) as client:
        assert client.get(DATA).status_code == 403
        assert client.post("/session").status_code == 403


def test_what_changes_something_needs_an_origin_and_what_another_site_embeds_is_refused(server):
    with server.client() as client:
        assert client.post("/session").status_code == 403
        assert client.get(DATA, headers={"Sec-Fetch-Site": "cross-site"}).status_code == 403
        assert client.get(DATA, headers={"Sec-Fetch-Site": "same-site"}).status_code == 403
        assert client.get(DATA, headers={"Sec-Fetch-Site": "same-origin"}).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:{port}", "127.0.0.2:{port}", "127.0.0.1:1",
     "127.0.0.1:{port}:1", "[::1]:{port}", ""],
)  # fmt: skip
def test_another_host_name_is_refused_even_for_the_page(server, host):
    with server.client(Host=host.format(port=server.port)) as client:
        assert client.get("/").status_code == 421
        assert client.get(DATA).status_code == 421


def test_hosts_are_distinguished():
    here = ("192.168.1.5", 8765)
    names = {"laptop", "laptop.local"}
    ours = ("192.168.1.5:8765", "laptop:8765", "LAPTOP.local:8765")
    for host in ours:
        assert host_is_ours(host, "https", here, names), host
    for host in ("192.168.1.5", "192.168.1.6:8765", "localhost:8765", "laptop.evil:8765",
                 "laptop@evil:8765", "192.168.1.5:+8765", "192.168.1.5:8765 ", "::1", "[", "]:8765",
                 "0x7f.1:8765", "192.168.1.5:087650"):  # fmt: skip
        assert not host_is_ours(host, "https", here, names), host
    assert host_is_ours("localhost:80", "http", ("127.0.0.1", 80), ())
    assert host_is_ours("localhost", "http", ("127.0.0.1", 80), ())
    assert host_is_ours("[fe80::1]:443", "https", ("fe80::1%eth0", 443), ())
    assert host_is_ours("[fe80::1]", "https", ("fe80::1", 443), ())
    assert host_is_ours("10.0.0.1:90", "http", ("::ffff:10.0.0.1", 90), ())


@given(st.text(max_size=40), st.text(max_size=40), st.booleans())
def test_any_host_and_origin_are_distinguished_without_an_error(host, origin, must):
    here = ("192.168.1.5", 8765)
    if host_is_ours(host, "https", here, {"laptop"}):
        assert host.lower() in ("192.168.1.5:8765", "laptop:8765")
    headers = {"host": "laptop:8765", "origin": origin}
    assert not origin_is_ours(headers, "https", must)
    longer = {**headers, "origin": f"https://laptop:8765{origin or '/'}"}
    assert not origin_is_ours(longer, "wss", must)


@pytest.mark.parametrize(
    "path",
    ["/../pyproject.toml", "/site/../server.py", "/data/%2e%2e/server.py", "/..%2f..%2fetc/passwd",
     "/site/", "/site", "//etc/passwd", "/data/..\\server.py", "/site/index.html", "/server.py",
     "/%00", "/style.css/", "/style.css%00.js", "/data/../site/x", "/data/window-9999.json",
     "/data/window-0.json/", "/sound/..%2fserver.py", "/sound/0.binx", "/worker.js"],
)  # fmt: skip
def test_no_path_leads_to_another_file(server, path):
    request = (
        f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nConnection: close\r\n"
        f"Authorization: Bearer {server.access.token}\r\n\r\n"
    )
    answer = raw(server, request.encode())
    assert status(answer) == 404, answer
    assert b"import" not in answer


def test_wrong_tokens_are_limited_for_their_address_only(fresh):
    with fresh.client("wrong") as stranger:
        found = [stranger.get(DATA).status_code for _ in range(MAX_WRONG_TOKENS + 2)]
    assert found == [401] * MAX_WRONG_TOKENS + [429] * 2
    with fresh.client() as owner:  # of the same address
        assert owner.get(DATA).status_code == 200
    transport = httpx.HTTPTransport(local_address="127.0.0.2")
    elsewhere = {"Authorization": f"Bearer {fresh.access.token}"}
    with httpx.Client(transport=transport) as other:
        assert other.get(fresh.origin + DATA, headers=elsewhere).status_code == 200


def test_the_limit_is_over_after_a_while_and_never_shuts_out_a_session():
    now = [0.0]
    access = Access(lambda: now[0])
    for _ in range(MAX_WRONG_TOKENS):
        assert access.check("wrong", None, "fe80::1") is Verdict.WRONG
    assert access.check("wrong", None, "fe80::2") is Verdict.LIMITED  # the same household
    assert access.check(access.token, None, "fe80::2") is Verdict.ALLOWED
    assert access.check(access.token, None, "fe81::2") is Verdict.ALLOWED
    assert access.check(None, access.session, "fe80::1") is Verdict.ALLOWED
    now[0] = WRONG_TOKEN_WINDOW_S + 1.0
    assert access.check("wrong", None, "fe80::1") is Verdict.WRONG


def test_addresses_with_wrong_tokens_dont_fill_the_memory():
    access = Access()
    for number in range(3000):
        access.check("wrong", None, f"10.1.{number // 256}.{number % 256}")
    assert len(access._failures) <= 1024


@pytest.mark.parametrize(
    "length", [str(middleware.MAX_BODY + 1), "99999999999999999999", "-1", "+5"]
)
def test_a_body_said_to_be_too_large_is_refused_unread(server, length):
    request = (
        f"POST /session HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nOrigin: {server.origin}\r\n"
        f"Authorization: Bearer {server.access.token}\r\nContent-Length: {length}\r\n\r\n"
    )
    assert status(raw(server, request.encode())) in (400, 413)


def test_a_body_in_chunks_is_refused_once_it_is_too_large(server):
    def chunks():
        for _ in range(40):
            yield b"x" * 65536

    with server.client(Origin=server.origin) as client:
        try:
            answer = client.request("GET", DATA, content=chunks())
        except (httpx.WriteError, httpx.RemoteProtocolError):
            return  # closed while we still wrote
    assert answer.status_code == 413


@pytest.mark.parametrize(
    "request_bytes",
    [b"\x16\x03\x01\x02\x00", b"GET\r\n\r\n", b"\x00" * 2000, b"GET / HTTP/9.9\r\n\r\n",
     b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b"GET /" + b"a" * 40_000 + b" HTTP/1.1\r\n",
     b"GET / HTTP/1.1\r\nX: " + b"a" * 40_000 + b"\r\n\r\n", b"POST / HTTP/1.1\r\n\r\n"],
)  # fmt: skip
def test_invalid_http_is_refused(server, request_bytes):
    try:
        answer = raw(server, request_bytes)
    except ConnectionResetError:
        return
    assert status(answer) in (400, 421)


def test_slow_requests_and_bodies_are_closed(match, monkeypatch):
    monkeypatch.setattr(web_server, "REQUEST_TIMEOUT_S", 0.3)
    monkeypatch.setattr(web_server, "BODY_TIMEOUT_S", 0.3)
    monkeypatch.setattr(middleware, "BODY_TIMEOUT_S", 0.3)
    with served(match, plays=False) as server:
        head = (
            f"GET {DATA} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
            f"Authorization: Bearer {server.access.token}\r\n"
        ).encode()
        beginnings = {
            "nothing": b"",
            "half a header": head,
            "a request, then half of one": head + b"\r\n" + head,
            "half a body": head + b"Content-Length: 9\r\n\r\nabc",
            "half a body of what needs none": head.replace(DATA.encode(), b"/")
            + b"Content-Length: 9\r\n\r\nabc",
        }
        for name, beginning in beginnings.items():
            with socket.create_connection(("127.0.0.1", server.port), timeout=3) as line:
                line.sendall(beginning)
                started = time.monotonic()
                with contextlib.suppress(ConnectionResetError):
                    while line.recv(65536):
                        pass
                assert time.monotonic() - started < 2.0, name


def test_a_connection_that_sends_slowly_after_the_answer_is_closed(match, monkeypatch):
    monkeypatch.setattr(web_server, "BODY_TIMEOUT_S", 0.3)
    with served(match, plays=False) as server:
        head = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nContent-Length: 99\r\n\r\n"
        with socket.create_connection(("127.0.0.1", server.port), timeout=3) as line:
            line.sendall(head.encode())
            started = time.monotonic()
            with contextlib.suppress(ConnectionError):
                while time.monotonic() - started < 3.0:
                    line.sendall(b"x")
                    time.sleep(0.05)
            assert time.monotonic() - started < 2.0


def test_a_connection_that_never_reads_an_answer_is_closed(match, monkeypatch, tmp_path):
    monkeypatch.setattr(web_server, "READ_TIMEOUT_S", 0.3)
    closed = threading.Event()
    lost = web_server.HttpConnection.connection_lost

    def connection_lost(self, exc):
        lost(self, exc)
        closed.set()

    monkeypatch.setattr(web_server.HttpConnection, "connection_lost", connection_lost)
    film = tmp_path / "film.mp4"
    film.write_bytes(bytes(20_000_000))
    with served(match, plays=False, media=open_media(str(film), 0.0)) as server:
        with socket.create_connection(("127.0.0.1", server.port), timeout=3) as line:
            request = (
                f"GET /media HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
                f"Authorization: Bearer {server.access.token}\r\n\r\n"
            )
            line.sendall(request.encode())
            assert closed.wait(30.0)
            got = 0
            with contextlib.suppress(ConnectionResetError):
                while part := line.recv(1_000_000):
                    got += len(part)
            assert got < 20_000_000
        with server.client() as reader:
            assert len(reader.get("/media").content) == 20_000_000


def is_open(line):
    """Whether a connection to which nothing was sent hasn't been closed from over there."""
    line.setblocking(False)
    try:
        return line.recv(1) != b""
    except BlockingIOError:
        return True
    except ConnectionResetError:
        return False


def test_two_hundred_connections_leave_capacity_for_another_address(fresh):
    lines = [socket.create_connection(("127.0.0.1", fresh.port)) for _ in range(200)]
    try:
        end = time.monotonic() + 30.0
        while sum(map(is_open, lines)) > web_server.MAX_PER_ADDRESS:
            assert time.monotonic() < end
            time.sleep(0.05)
        transport = httpx.HTTPTransport(local_address="127.0.0.2")
        with httpx.Client(transport=transport) as other:
            assert other.get(fresh.origin + "/").status_code == 200
    finally:
        for line in lines:
            line.close()


def test_a_new_connection_replaces_the_one_idle_for_longest(fresh):
    with contextlib.ExitStack() as stack:
        lines = []
        for _ in range(web_server.MAX_PER_ADDRESS):
            lines.append(stack.enter_context(socket.create_connection(("127.0.0.1", fresh.port))))
            time.sleep(0.01)
        with fresh.client() as client:
            assert client.get(DATA).status_code == 200
        lines[0].settimeout(2.0)
        with contextlib.suppress(ConnectionResetError):
            assert lines[0].recv(1) == b""
        lines[-1].setblocking(False)
        with pytest.raises(BlockingIOError):  # still open
            lines[-1].recv(1)


def test_connections_with_a_started_request_are_not_replaced(fresh):
    head = f"POST / HTTP/1.1\r\nHost: 127.0.0.1:{fresh.port}\r\nContent-Length: 99\r\n"
    head += f"Authorization: Bearer {fresh.access.token}\r\nOrigin: {fresh.origin}\r\n\r\n"
    with contextlib.ExitStack() as stack:
        for _ in range(web_server.MAX_PER_ADDRESS):
            line = stack.enter_context(socket.create_connection(("127.0.0.1", fresh.port)))
            line.sendall(head.encode())
        time.sleep(0.3)
        with fresh.client() as client, pytest.raises(httpx.TransportError):
            client.get(DATA)


def test_an_internal_error_is_reported_to_the_server_only(fresh, monkeypatch):
    monkeypatch.setattr("overview_dsp.web.site_data.timeline_json", lambda *given: 1 / 0)
    with fresh.client() as client:
        answer = client.get(DATA)
    assert answer.status_code == 500
    assert "ZeroDivision" not in answer.text
    assert any("ZeroDivisionError" in note for note in fresh.notes)


def test_closing_ends_idle_connections(match):
    with served(match, plays=False) as server:
        line = socket.create_connection(("127.0.0.1", server.port))
    line.settimeout(2.0)
    assert line.recv(1) == b""
    line.close()
