"""A server on a real socket, with a live engine behind it."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections.abc import Iterator

import httpx
from websockets.sync.client import ClientConnection, connect

from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.session import commands
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.web.data import data_routes
from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.server import WebServer, listen, make_app
from overview_dsp.web.session import HostSession


class Served:
    """A running server: where it is, its token, the player behind it, what it complained of."""

    def __init__(self, player: Player | None, port: int, access: Access, notes: list[str]) -> None:
        self.player = player
        self.port = port
        self.access = access
        self.notes = notes
        self.origin = f"http://127.0.0.1:{port}"
        self.session: HostSession | None = None
        self.web: WebServer | None = None

    def client(self, token: str | None = "right", **headers: str) -> httpx.Client:
        """A client with the token, another one, or none."""
        if token is not None:
            token = self.access.token if token == "right" else token
            headers["Authorization"] = f"Bearer {token}"
        coded = {name: value.encode("latin-1") for name, value in headers.items()}
        return httpx.Client(base_url=self.origin, headers=coded, timeout=20)

    def connect(self, token: str | None = "right", **given) -> ClientConnection:
        """A WebSocket to `/control`, to be used in a `with`."""
        headers = {"Origin": self.origin, **given.pop("headers", {})}
        if token is not None:
            token = self.access.token if token == "right" else token
            headers["Authorization"] = f"Bearer {token}"
        headers = {name: value for name, value in headers.items() if value is not None}
        address = f"ws://127.0.0.1:{self.port}/control"
        # without a limit it reads, and answers pings, whether a test does or not
        given = {"max_queue": None, "proxy": None, **given}
        return connect(address, additional_headers=headers, **given)

    def cut(self) -> None:
        """Every connection is lost, as in a network that fails."""
        for one in list(self.web._server.server_state.connections):
            one.loop.call_soon_threadsafe(one.transport.abort)

    def until(self, condition, seconds: float = 30.0) -> None:
        """Wait for a condition on the engine's meters."""
        end = time.monotonic() + seconds
        while not condition(self.player.engine.meters):
            assert time.monotonic() < end, f"waited in vain: {self.player.engine.meters}"
            time.sleep(0.01)


@contextlib.contextmanager
def served(
    timeline, *, plays: bool = True, record=None, preset="football", **given
) -> Iterator[Served]:
    """A server of a timeline; `plays` with a live engine on no device."""
    notes: list[str] = []
    access = Access()
    with contextlib.ExitStack() as stack:
        player = session = None
        if plays:
            player = Player(
                timeline,
                PresetWatch(preset),
                lambda engine, settings: NullStream(engine, 256, settings),
                OutputSettings(),
                callback="python",
                record=record,
            )
            stack.callback(player.close)
            session = HostSession(player)
            stack.enter_context(_polled(player, session))
        socket = listen("127.0.0.1", 0)
        given = {"audio": "host" if plays else "here", **given}
        routes = data_routes(timeline, preset, **given)
        app = make_app(access, (), notes.append, session, routes)
        server = WebServer(app, [socket], None, notes.append, "live" in given)
        found = Served(player, socket.getsockname()[1], access, notes)
        found.session, found.web = session, server
        try:
            yield found
        finally:
            server.close()


@contextlib.contextmanager
def _polled(player, session) -> Iterator[None]:
    """The control thread of a command."""
    over = threading.Event()

    def poll():
        while not over.wait(0.02):
            commands.poll(player, session)

    thread = threading.Thread(target=poll)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def events(*rows) -> str:
    """A message of events (time_ms, theta2, touching)."""
    return json.dumps({"events": [list(row) for row in rows]})


def told(connection, key: str, seconds: float = 5.0):
    """The next of the host's messages with this key."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        message = json.loads(connection.recv(timeout=seconds))
        if key in message:
            return message[key]
    raise AssertionError(f"no {key} in {seconds} s")
