"""The sound goes on, to the bit, whatever is done to the server: native callback, JACK."""

from __future__ import annotations

import contextlib
import json
import math
import random
import signal
import socket
import subprocess
import sys
import threading
import time

import httpx
import numpy as np
import pytest
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

import overview_dsp as ov
from tests.cli.test_serve import MATCH, running
from tests.live import jack_server
from tests.live.test_portaudio import aligned

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL),
]

SECONDS = 6.0
RECORD = """
import sys, time
import jack
import numpy as np

path, seconds = sys.argv[1], float(sys.argv[2])
client = jack.Client("recorder")
ports = [client.inports.register(name) for name in ("click", "tactor")]
heard = np.zeros((round(seconds * 48_000), 2), dtype=np.float32)
at = xruns = 0

@client.set_process_callback
def record(frames):
    global at
    count = min(frames, len(heard) - at)
    for channel, port in enumerate(ports):
        heard[at : at + count, channel] = port.get_array()[:count]
    at += count

@client.set_xrun_callback
def count(delay):
    global xruns
    xruns += 1

with client:
    for channel, port in enumerate(ports):
        client.connect(f"overview:out_{channel}", port)
    print("records", flush=True)
    while at < len(heard):
        time.sleep(0.02)
np.save(path, heard)
print(xruns)
"""


def attack(origin: str, token: str, over: threading.Event) -> None:
    """Everything at once that the server is to refuse, and costly things that it is not."""
    address = origin.partition("//")[2]
    host, _, port = address.partition(":")
    headers = {"Authorization": f"Bearer {token}", "Origin": origin}
    chance = random.Random(1)
    lines: list[socket.socket] = []
    while not over.is_set():
        with contextlib.suppress(OSError, httpx.HTTPError, WebSocketException):
            lines += [socket.create_connection((host, int(port)), 1.0) for _ in range(200)]
            for line in lines:
                with contextlib.suppress(OSError):
                    line.sendall(chance.randbytes(2000))
            for line in lines:
                line.close()
            lines.clear()
            httpx.get(f"{origin}/data/timeline.json", headers={"Authorization": "Bearer wrong"})
            change = {"sample_rate": 48000, "after": "crowd", "window": [0, 900]}
            httpx.post(f"{origin}/sound/change", headers=headers, json=change)
            httpx.put(f"{origin}/preset/x", headers=headers, content=b"x" * 2_000_000)
            for message in ("x", "[" * 8000, '{"events": [[0, 9, 1]]}', "y" * 100_000):
                with connect(f"ws://{address}/control", additional_headers=headers) as page:
                    page.send(message)
                    page.recv(timeout=1.0)


def session(folder, path) -> tuple[int, dict]:
    """Play for a while under attack, recording what is heard; xruns and the summary."""
    with jack_server.Server(period=512) as jack, contextlib.ExitStack() as stack:
        arguments = ("serve", MATCH, "--port", 0, "--audio", "host", "--device", "system",
                     "--preset", "football", "--record", path.with_suffix(".csv"))  # fmt: skip
        stack.enter_context(pytest.MonkeyPatch.context()).setenv("JACK_DEFAULT_SERVER", jack.name)
        server = stack.enter_context(running(*arguments, folder=folder))
        recorder = subprocess.Popen(
            [sys.executable, "-c", RECORD, path, str(SECONDS)],
            env=jack.environment,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert recorder.stdout.readline() == "records\n"
        over = threading.Event()
        attacker = threading.Thread(target=attack, args=(server.origin, server.token, over))
        attacker.start()
        drag(server)
        over.set()
        attacker.join()
        xruns = int(recorder.communicate(timeout=30)[0])
        out, err = server.end(signal.SIGINT)
        assert "Traceback" not in err, err
        return xruns, json.loads(out.splitlines()[-1])["summary"]


def drag(server) -> None:
    """A hand to and fro for a while; it connects again if there was no room."""
    end = time.monotonic() + SECONDS - 2.0
    address = server.origin.replace("http", "ws") + "/control"
    while time.monotonic() < end:
        with contextlib.suppress(OSError, WebSocketException):
            page = connect(address, additional_headers=server.headers, proxy=None, max_queue=None)
            with page as line:
                while time.monotonic() < end:
                    position = 0.5 - 0.4 * math.cos(3.0 * (end - time.monotonic()))
                    event = [time.monotonic() * 1e3, position * math.pi, 1]
                    line.send(json.dumps({"events": [event]}))
                    time.sleep(0.01)


def test_a_server_under_attack_plays_every_sample(match, football, tmp_path):
    path = tmp_path / "heard.npy"
    # a run in which the machine lost a period, or the attack left the hand no room, is repeated
    for _ in range(jack_server.ATTEMPTS):
        xruns, summary = session(tmp_path, path)
        take = ov.load_gesture(path.with_suffix(".csv"))
        if take.touching.sum() <= 100:
            continue
        expected = ov.render(match, football, take, trace=False, tail=0.0).samples
        heard = aligned(np.load(path), expected)[: round((SECONDS - 1.0) * 48_000)]
        same = np.array_equal(heard, expected[: len(heard)])
        if xruns == 0 and summary["underflows"] == 0 and same:
            break
    assert take.touching.sum() > 100
    assert np.abs(heard).max(axis=0).min() > 0.01
    assert same
