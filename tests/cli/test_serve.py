"""`overview serve` and `overview play --remote`, as processes."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import select
import signal
import ssl
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import httpx
import pytest
from websockets.sync.client import connect

import overview_dsp as ov
from overview_dsp.installation import install_command
from tests.cli.running import environment, overview, refused

MATCH = "world-cup-final-2018"


class Running:
    """A command that serves: its address, its token, its process."""

    def __init__(self, process: subprocess.Popen[str], lines: list[str], folder: Path) -> None:
        self.process = process
        self.lines = lines
        found = re.fullmatch(r"open (https?://\S+)/#token=(\S+)", lines[-1])
        assert found, lines
        self.origin, self.token = found.groups()
        self.headers = {"Authorization": f"Bearer {self.token}", "Origin": self.origin}
        self.folder = folder

    def end(self, number: int = signal.SIGTERM) -> tuple[str, str]:
        self.process.send_signal(number)
        # what `readline` took ahead is in the files, where `communicate` doesn't look
        err, out = self.process.stderr.read(), self.process.stdout.read()
        self.process.wait(20)
        return out, err


@contextlib.contextmanager
def running(*arguments: object, folder: Path) -> Iterator[Running]:
    process = subprocess.Popen(
        [sys.executable, "-m", "overview_dsp", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**environment(), "XDG_CONFIG_HOME": str(folder)},
    )
    try:
        lines = []
        while not lines or not lines[-1].startswith("open "):
            line = process.stderr.readline()
            assert line, lines
            lines.append(line.rstrip("\n"))
        yield Running(process, lines, folder)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()


pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals as on POSIX")


def test_serve_prints_its_address_serves_and_ends_with_a_signal(tmp_path):
    with running("serve", MATCH, "--port", 0, "--json", folder=tmp_path) as server:
        told = httpx.get(server.origin + "/data/timeline.json", headers=server.headers).json()
        assert told["preset"] == "football"
        assert told["server"]["audio"] == "here"
        assert httpx.get(server.origin + "/data/timeline.json").status_code == 401
        out, err = server.end()
        assert server.process.returncode == 128 + signal.SIGTERM
        assert "Traceback" not in err
        assert server.token in json.loads(out.splitlines()[0])["address"]


def test_with_audio_at_the_host_a_page_moves_the_disk(tmp_path):
    take = tmp_path / "take.csv"
    arguments = ("serve", MATCH, "--port", 0, "--audio", "host", "--device", "none",
                 "--record", take, "--window", "1000", "2000")  # fmt: skip
    with running(*arguments, folder=tmp_path) as server:
        told = httpx.get(server.origin + "/data/timeline.json", headers=server.headers).json()
        assert (told["preset"], told["duration_s"]) == ("football", 1000.0)
        pages = [one.name for one in entry_points(group="overview_dsp.pages")]
        shown = {"audio": "host", "window": [0.0, 1000.0], "media": None, "pages": pages}
        assert told["server"] == shown
        address = server.origin.replace("http", "ws") + "/control"
        with connect(address, additional_headers=server.headers, proxy=None) as page:
            for place in (0.2, 0.3, 0.4):
                event = [time.monotonic() * 1e3, place * math.pi, 1]
                page.send(json.dumps({"events": [event]}))
                time.sleep(0.1)
        time.sleep(0.3)
        _, err = server.end(signal.SIGINT)
        assert "Traceback" not in err
    gesture = ov.load_gesture(take)
    assert gesture.theta2.max() == pytest.approx(0.4 * math.pi)
    assert not gesture.touching[-1]
    assert {ov.gestures.SOURCES[one] for one in gesture.source} == {"remote"}


def test_beyond_this_machine_it_is_https_with_its_fingerprint_and_a_qr_code(tmp_path):
    with running("serve", MATCH, "--port", 0, "--host", "0.0.0.0", folder=tmp_path) as server:
        assert server.origin.startswith("https://")
        pem = next(tmp_path.rglob("server.pem"))
        assert pem.stat().st_mode & 0o077 == 0
        trusted = ssl.create_default_context(cafile=str(pem))
        with httpx.Client(verify=trusted) as client:
            answer = client.post(server.origin + "/session", headers=server.headers)
            assert answer.status_code == 204
            cookie = answer.headers["set-cookie"]
            assert cookie.startswith("__Host-overview-")
            assert "Secure" in cookie
            assert client.get(server.origin + "/data/timeline.json").status_code == 200
        with pytest.raises(httpx.HTTPError):  # not without TLS
            httpx.get(server.origin.replace("https", "http") + "/")
        _, err = server.end()
    from overview_dsp.web.certificate import fingerprint
    from overview_dsp.web.server import qr_text

    assert fingerprint(pem) in err
    assert qr_text(f"{server.origin}/#token={server.token}") in err


def test_play_remote_opens_the_server_beside_the_session(tmp_path):
    arguments = ("play", MATCH, "--device", "none", "--remote", ":0", "--screen", "json")
    with running(*arguments, folder=tmp_path) as server:
        told = httpx.get(server.origin + "/data/timeline.json", headers=server.headers).json()
        assert told["server"]["audio"] == "host"
        out, err = server.end()
        assert "Traceback" not in err
        assert "summary" in json.loads(out.splitlines()[-1])


def test_play_remote_shows_the_address_in_the_terminal(tmp_path):
    pty = pytest.importorskip("pty", reason="needs a terminal as on POSIX")
    pid, terminal = pty.fork()
    if pid == 0:  # the child
        os.environ.update(COLUMNS="140", LINES="40", TERM="xterm-256color")
        arguments = ["play", MATCH, "--device", "none", "--remote", ":0"]
        os.execv(sys.executable, [sys.executable, "-m", "overview_dsp", *arguments])
    shown = b""
    try:
        end = time.monotonic() + 30.0
        # once before the screen is taken over, and once on it
        while b"#token=" not in shown.partition(b"\x1b[?1049h")[2]:
            assert time.monotonic() < end, shown[-500:]
            if select.select([terminal], [], [], 0.5)[0]:
                shown += os.read(terminal, 65536)
    finally:
        os.kill(pid, signal.SIGTERM)
        with contextlib.suppress(OSError):  # what it says at its end must not block it
            while os.read(terminal, 65536):
                pass
        os.waitpid(pid, 0)
        os.close(terminal)


def test_play_without_remote_opens_no_port(tmp_path):
    done = overview("play", MATCH, "--device", "none", "--screen", "json", "--seconds", 0.2)
    assert done.code == 0, done.err
    assert "open http" not in done.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--port", "99999"), ("--port",)),
        (("--host", "203.0.113.7", "--cert", "x.pem"), ("x.pem",)),
        (("--key", "x.pem"), ("--cert",)),
        (("--media", "none.mp4"), ("none.mp4",)),
        (("--media", "none.mp4,offset=7"), ("none.mp4: can't be read",)),
        (("--media", "none.mp4,offset=soon"), ("none.mp4,offset=soon", "seconds")),
        (("--media", "none.txt"), ("none.txt",)),
        (("--preset", "none"), ("none",)),
        (("--window", "5", "1"), ("--window",)),
        (("--host", "no such host"), ("no such host", "--host")),
    ],
)
def test_bad_input_gives_a_one_line_error(tmp_path, monkeypatch, arguments, words):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    refused(overview("serve", MATCH, *arguments), *words)


def test_an_option_without_effect_is_refused():
    refused(overview("serve", MATCH, "--record", "take.csv"), "--record", "--audio host")
    refused(overview("serve", MATCH, "--set", "tactor.gain=3"), "--set", "--audio host")


@pytest.mark.parametrize("address", ["localhost:99999", "two words", "a:b", "[::1"])
def test_an_invalid_address_is_refused(address):
    play = ("play", MATCH, "--device", "none")
    refused(overview(*play, "--remote", address), f"--remote is {address}", "such as 0.0.0.0:8765")


def test_a_port_that_is_taken_gives_a_one_line_error(tmp_path):
    with running("serve", MATCH, "--port", 0, folder=tmp_path) as server:
        port = server.origin.rpartition(":")[2]
        refused(overview("serve", MATCH, "--port", port), port, "--port")


def test_a_missing_package_gives_a_one_line_error_that_says_how_to_install_it(monkeypatch):
    import importlib.util

    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "uvicorn" else found(name)
    )
    refused(overview("serve", MATCH), "uvicorn", install_command("web"))
    refused(overview("play", MATCH, "--device", "none", "--remote"), install_command("web"))


def test_an_address_before_the_timeline_does_not_swallow_it():
    swallowed = overview("play", "--device", "none", "--remote", MATCH)
    refused(swallowed, f"--remote {MATCH} is an address", "TIMELINE")
