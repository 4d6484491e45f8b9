"""Control of the host's disk by a page, over a real WebSocket and with a live engine."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import time

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

import overview_dsp as ov
from overview_dsp.kernels import layout
from tests.web.serving import events, served, told


@pytest.fixture(scope="module")
def server(match):
    with served(match) as running:
        yield running


@pytest.fixture
def disk(server):
    """Return the server once its disk is free."""
    server.until(lambda meters: not meters.touching)
    yield server
    server.until(lambda meters: not meters.touching)


def touch(connection, position, seconds=0.0):
    """Touch at a position and repeat the event, as a page does."""
    end = time.monotonic() + seconds
    while True:
        connection.send(events((time.monotonic() * 1e3, position * math.pi, 1)))
        if time.monotonic() >= end:
            return
        time.sleep(0.05)


def move_to(server, position, *pages):
    """Let each page touch at its position until the disk is at `position`."""
    end = time.monotonic() + 10.0
    while abs(server.player.engine.meters.cursor - position) > 0.01:
        assert time.monotonic() < end, server.player.engine.meters
        for page, its_position in pages:
            touch(page, its_position)
        time.sleep(0.05)


def test_a_page_controls_the_disk_and_releases_it(disk):
    with disk.connect() as page:
        move_to(disk, 0.4, (page, 0.4))
        assert disk.player.engine.meters.touching
        page.send(events((time.monotonic() * 1e3, 0.4 * math.pi, 0)))
        disk.until(lambda meters: not meters.touching)
    assert not disk.notes


@pytest.mark.parametrize("token", [None, "wrong"])
def test_control_needs_the_token(match, token):
    with served(match) as server, pytest.raises(InvalidStatus) as refused:
        server.connect(token)
    assert refused.value.response.status_code == 401
    assert "script-src" in refused.value.response.headers["content-security-policy"]


@pytest.mark.parametrize("origin", [None, "http://evil.example", "null"])
def test_control_from_another_site_is_rejected_even_with_the_token(server, origin):
    with pytest.raises(InvalidStatus) as refused:
        server.connect(headers={"Origin": origin})
    assert refused.value.response.status_code == 403


def test_the_cookie_of_the_page_allows_control(disk):
    with disk.client(Origin=disk.origin) as client:
        client.post("/session")
        cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    with disk.connect(None, headers={"Cookie": cookie}) as page:
        assert "cursor" in told(page, "status")


def test_a_page_without_a_host_that_plays_finds_no_control(match):
    with served(match, plays=False) as server, pytest.raises(InvalidStatus) as refused:
        server.connect()
    assert refused.value.response.status_code in (403, 404)


def test_a_lost_connection_releases_the_disk(disk):
    with contextlib.suppress(ConnectionClosed), disk.connect() as page:
        touch(page, 0.6)
        disk.until(lambda meters: meters.touching)
        page.socket.shutdown(socket.SHUT_RDWR)  # no closing handshake
        started = time.monotonic()
        disk.until(lambda meters: not meters.touching)
        assert time.monotonic() - started < 0.4


def test_silence_while_touching_releases_the_disk_with_a_message(disk):
    with disk.connect() as page:
        touch(page, 0.6)
        started = time.monotonic()
        disk.until(lambda meters: meters.touching)
        assert "500 ms" in told(page, "released")
        assert 0.4 < time.monotonic() - started < 1.5
        disk.until(lambda meters: not meters.touching)
        touch(page, 0.5)  # the page may touch again
        disk.until(lambda meters: meters.touching)


def test_a_host_that_stops_releases_the_disk(match):
    stack = contextlib.ExitStack()
    with served(match) as server:
        stack.enter_context(contextlib.suppress(ConnectionClosed))
        page = stack.enter_context(server.connect())
        touch(page, 0.6)
        server.until(lambda meters: meters.touching)
        player = server.player
    with stack:
        # without sound output nothing is processed until this block
        engine = player.engine
        engine.process(np.zeros((512, 2), np.float32))
        assert not engine.meters.touching


MALFORMED = [
    "", "x", "[]", "{}", '"events"', "null", "{" * 4000, "[" * 4000, '{"events": []}',
    '{"events": [[0, 1, 1]], "x": 1}', '{"events": [[0, NaN, 1]]}',
    '{"events": [[0, -Infinity, 1]]}',
    '{"events": [[0, 1e999, 1]]}', '{"events": [[0, 4, 1]]}', '{"events": [[0, -0.1, 1]]}',
    '{"events": [[0, 1, 2]]}', '{"events": [[0, "1", 1]]}', '{"events": [[0, true, 1]]}',
    '{"events": [[-1, 1, 1]]}', '{"events": [[5, 1, 1], [4, 1, 1]]}', '{"events": [[0, 1]]}',
    '{"events": [[0, %s, 1]]}' % ("9" * 4000), '{"pong": 1}', '{"show": [5, 1]}',
    '{"show": [0, 1e9]}', json.dumps({"events": [[0, 1, 1]] * 65}), b"\x00\x01", b"{}",
]  # fmt: skip


@pytest.mark.parametrize("message", MALFORMED, ids=range(len(MALFORMED)))
def test_a_malformed_message_ends_the_connection_and_releases_the_disk(disk, message):
    with disk.connect() as page:
        touch(page, 0.5)
        disk.until(lambda meters: meters.touching)
        page.send(message)
        with pytest.raises(ConnectionClosed) as closed:
            told(page, "nothing")
        assert closed.value.rcvd.code == 1007
        assert closed.value.rcvd.reason
        disk.until(lambda meters: not meters.touching)
    assert not disk.notes


def test_an_oversized_message_ends_the_connection_and_releases_the_disk(disk):
    with disk.connect() as page:
        touch(page, 0.5)
        disk.until(lambda meters: meters.touching)
        page.send('{"events": [' + "[0, 1, 1]," * 4000 + "]}")
        with pytest.raises(ConnectionClosed) as closed:
            told(page, "nothing")
        assert closed.value.rcvd.code == 1009
        disk.until(lambda meters: not meters.touching)


def test_too_many_events_end_the_connection_and_release_the_disk(disk):
    with disk.connect() as page:
        rows = [(time.monotonic() * 1e3, 1.0, 1)] * 64
        with contextlib.suppress(ConnectionClosed):
            for _ in range(200):
                page.send(events(*rows))
        with pytest.raises(ConnectionClosed) as closed:
            told(page, "nothing")
        assert closed.value.rcvd.code == 1008
        disk.until(lambda meters: not meters.touching)
    assert disk.player.engine.meters.dropped_events == 0


def test_the_last_page_to_touch_controls_the_disk_until_its_release(disk):
    with disk.connect() as one, disk.connect() as two:
        move_to(disk, 0.3, (one, 0.3))
        move_to(disk, 0.7, (one, 0.3), (two, 0.7))
        two.close()
        move_to(disk, 0.3, (one, 0.3))


def test_latency_is_measured_by_the_pages_clock(disk):
    ahead = 12345.0  # the page's clock has another origin
    with disk.connect() as page:
        for _ in range(4):
            sent = told(page, "ping")
            page.send(json.dumps({"pong": sent, "time_ms": (time.monotonic() + ahead) * 1e3}))
        for _ in range(10):
            page.send(events(((time.monotonic() + ahead) * 1e3, 1.0, 1)))
            time.sleep(0.03)
        status = [told(page, "status") for _ in range(3)][-1]
        page.send(events(((time.monotonic() + ahead) * 1e3, 1.0, 0)))
    assert 0.0 <= status["round_trip_ms"] < 200.0
    assert 0.0 <= status["event_to_sample_ms"] < 250.0
    assert status["active"] is True
    assert status["output_ms"] >= 0.0


def test_a_page_changes_the_window_of_the_host(disk):
    with disk.connect() as page:
        page.send(json.dumps({"show": [1000.0, 2000.0]}))
        end = time.monotonic() + 5.0
        while told(page, "status")["window"] != [1000.0, 2000.0]:
            assert time.monotonic() < end
        page.send(json.dumps({"show": [0.0, disk.player.timeline.duration_s]}))


def test_a_page_tries_a_preset_on_the_host(disk):
    with disk.client(Origin=disk.origin) as client:
        tried = client.get("/data/preset").json()["preset"]
        for gain in (-9.0, -8.0, -7.0, -6.0, -5.0):  # as fast as a slider
            tried["values"]["tactor.gain_db"] = gain
            tried["kinds"]["goal"]["height"] = 20.0 - gain
            assert client.post("/host/preset", json={"preset": tried}).status_code == 204
        end = time.monotonic() + 5.0
        while disk.player.engine.preset.values["tactor.gain_db"] != -5.0:
            assert time.monotonic() < end
            time.sleep(0.02)
        assert disk.player.engine.preset.kinds["goal"].height == 25.0
        tried["values"]["tactor.gain_db"] = 999.0
        for body in ({"preset": tried}, {"preset": "../x"}, {}, {"preset": "crowd", "x": 1}):
            answer = client.post("/host/preset", json=body)
            assert (answer.status_code, answer.text.count("\n")) == (400, 1)
        assert client.post("/host/preset", json={"preset": "football"}).status_code == 204
        with disk.connect() as page:
            assert told(page, "status")["preset"] == "football"


def test_the_events_of_a_page_are_recorded_and_replay_bit_identically(match, football, tmp_path):
    path = tmp_path / "take.csv"
    with served(match, record=path) as server, server.connect() as page:
        sent = told(page, "ping")
        page.send(json.dumps({"pong": sent, "time_ms": time.monotonic() * 1e3}))
        for step in range(20):
            touch(page, 0.2 + 0.02 * step)
            time.sleep(0.02)
        page.send(events((time.monotonic() * 1e3, 1.0, 0)))
        server.until(lambda meters: not meters.touching)
        server.player.poll()
        applied, _ = server.player.engine.pop_applied(0)
    assert {ov.gestures.SOURCES[one] for one in applied["source"]} == {"remote"}
    take = ov.load_gesture(path)
    stamps = take.stamps(48_000)
    assert np.array_equal(stamps[: len(applied)], applied["sample"])
    assert np.array_equal(take.theta2[: len(applied)], applied["theta2"])
    assert len(ov.render(match, football, take).samples) > 0


def test_many_and_slow_connections_dont_interrupt_the_sound(match):
    """The engine keeps running, surplus connections are closed, and a normal page is served."""
    with served(match) as server:
        lines = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(200)]
        for line in lines[::2]:
            with contextlib.suppress(OSError):
                line.sendall(b"GET /control HTTP/1.1\r\nHost: x\r\n")
        before = server.player.poll().time_s
        # a stopped engine would never get there
        server.until(lambda meters: server.player.poll().time_s - before > 0.7)
        assert server.player.engine.memory.view(np.int64)[layout.M_RESETS] == 0
        for line in lines:
            line.close()
        time.sleep(0.2)
        with server.connect() as page:
            touch(page, 0.5)
            server.until(lambda meters: meters.touching)


def test_a_page_that_answers_no_ping_is_closed_and_releases_the_disk(match, monkeypatch):
    monkeypatch.setattr("overview_dsp.web.server.PING_INTERVAL_S", 0.2)
    with served(match) as server, socket.create_connection(("127.0.0.1", server.port)) as line:
        head = (
            f"GET /control HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nOrigin: {server.origin}\r\n"
            f"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            f"Authorization: Bearer {server.access.token}\r\n\r\n"
        )
        line.sendall(head.encode())
        line.settimeout(5.0)
        assert line.recv(65536).startswith(b"HTTP/1.1 101 ")
        message = events((0, 1.0, 1)).encode()
        line.sendall(bytes([0x81, 0x80 | len(message), 0, 0, 0, 0]) + message)
        server.until(lambda meters: meters.touching)
        end = time.monotonic() + 5.0
        while line.recv(65536):
            assert time.monotonic() < end
        server.until(lambda meters: not meters.touching)


def test_a_page_that_stops_reading_is_closed(match, monkeypatch):
    monkeypatch.setattr("overview_dsp.web.server.PING_INTERVAL_S", 0.2)
    with served(match) as server, server.connect(max_queue=1) as page:
        # its pings wait unread behind the statuses
        with pytest.raises(ConnectionClosed):
            touch(page, 0.5, 10.0)
        server.until(lambda meters: not meters.touching)


def test_a_page_sets_a_mark_at_the_disk(disk):
    with disk.connect() as page:
        move_to(disk, 0.4, (page, 0.4))
        page.send(json.dumps({"mark": "a pass"}))
        end = time.monotonic() + 20.0
        while not disk.player.marks.events and time.monotonic() < end:
            touch(page, 0.4)
            time.sleep(0.05)
    (mark,) = disk.player.marks.events
    assert mark.label == "a pass"
    position = float(disk.player.active_window.angle_map.position_of(mark.time_s))
    assert position == pytest.approx(0.4, abs=0.05)
