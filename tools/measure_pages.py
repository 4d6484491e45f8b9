"""Measure how fast hundreds of pages receive updates from one server, and the load on its audio.

    python tools/measure_pages.py [PAGES] [UPDATES] [--sound] [--device NAME]

The script starts `overview serve --follow` with a disk on the host and opens the connections of the
pages. It adds a goal every few seconds. It prints the time from the line in the feed until each
page has its update. By default the host has no output but a clock in Python. With `--device`
PortAudio plays the sound, for example on a headless JACK server. With `--sound` the pages play
instead and receive the changes of their surface. The pages run in one process of low priority on
the same machine.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

INTERVAL_S = 4.0


async def request(
    host: str, port: int, path: str, cookie: str, token: str = ""
) -> tuple[str, bytes]:
    """Send one request on a new connection; return header and body."""
    reader, writer = await asyncio.open_connection(host, port)
    more = f"Authorization: Bearer {token}\r\nContent-Length: 0\r\n" if token else ""
    method = "POST" if token else "GET"
    writer.write(
        f"{method} {path} HTTP/1.1\r\nHost: {host}:{port}\r\nOrigin: http://{host}:{port}\r\n"
        f"Cookie: {cookie}\r\n{more}Connection: close\r\n\r\n".encode()
    )
    head, _, body = (await reader.read()).partition(b"\r\n\r\n")
    writer.close()
    return head.decode("latin-1"), body


async def page(
    host: str, port: int, cookie: str, rate: int, results: dict[str, list[float]]
) -> None:
    """Receive notices with their updates, as a page does."""
    reader, writer = await asyncio.open_connection(host, port, limit=1 << 24)
    writer.write(
        f"GET /live/events?since=0&rate={rate}&have=-1 HTTP/1.1\r\nHost: {host}:{port}\r\n"
        f"Cookie: {cookie}\r\n\r\n".encode()
    )
    while line := await reader.readline():
        if not line.startswith(b"data: "):
            continue
        received = time.time()
        # the changes precede the update
        head = line[6:].split(b', "update": ')[0] + b"}"
        goals = [one["label"] for one in json.loads(head)["changes"] if one["kind"] == "goal"]
        if goals:
            results["seconds"].append(received - float(goals[-1]))
            results["bytes"].append(len(line))


async def measure(pages: int, updates: int, sound: bool, device: str) -> None:
    folder = Path(tempfile.mkdtemp())
    feed = folder / "match.feed"
    feed.write_text('{"overview_feed": 1, "title": "A - B", "expected_duration_s": 5700}\n'
                    '{"event": {"time_s": 0, "kind": "period"}}\n')  # fmt: skip
    plays = [] if sound else ["--audio", "host", "--device", device, "--announce", "none"]
    server = subprocess.Popen(
        [sys.executable, "-m", "overview_dsp", "serve", "--follow", str(feed), "--port", "0",
         "--json", *plays],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ,
    )  # fmt: skip
    os.nice(10)  # pages are elsewhere: what they cost isn't the server's
    assert server.stdout is not None
    where = json.loads(server.stdout.readline())["address"]
    parts = urlsplit(where)
    host, port, token = parts.hostname, parts.port, parts.fragment.removeprefix("token=")
    head, _ = await request(host, port, "/session", "", token)
    cookie = next(line for line in head.split("\r\n") if line.lower().startswith("set-cookie:"))
    cookie = cookie.partition(":")[2].partition(";")[0].strip()
    results: dict[str, list[float]] = {"seconds": [], "bytes": []}
    rate = 48_000 if sound else 0
    open_pages = []
    for _ in range(pages):
        open_pages.append(asyncio.create_task(page(host, port, cookie, rate, results)))
        await asyncio.sleep(0.01)
    await asyncio.sleep(3.0)
    for n in range(updates):
        with feed.open("a") as file:
            label = f"{time.time():.6f}"
            goal = {"event": {"time_s": 60 + 60 * n, "kind": "goal", "label": label}}
            file.write(json.dumps(goal) + "\n")
        await asyncio.sleep(INTERVAL_S)
    server.terminate()
    lines = server.stdout.read().splitlines()
    for one in open_pages:
        one.cancel()
    values = sorted(results["seconds"])
    print(f"updates: {len(values)} of {pages * updates}, median "
          f"{statistics.median(values):.3f} s, p99 {values[int(len(values) * 0.99)]:.3f} s, "
          f"longest {values[-1]:.3f} s, {max(results['bytes']) / 1000:.0f} kB each")  # fmt: skip
    if not sound:
        summary = json.loads(lines[-1])["summary"]
        names = ("blocks", "late_callbacks", "underflows", "callback_p99_us")
        print("host: " + ", ".join(f"{name} {summary[name]}" for name in names))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("pages", type=int, nargs="?", default=300)
    parser.add_argument("updates", type=int, nargs="?", default=8)
    parser.add_argument("--sound", action="store_true")
    parser.add_argument("--device", default="none")
    given = parser.parse_args()
    asyncio.run(measure(given.pages, given.updates, given.sound, given.device))
