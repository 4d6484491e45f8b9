"""How soon hundreds of pages have what is new, from one server: notice and update of each.

    python tools/measure_pages.py [PAGES [UPDATES [DEVICE]]]

starts `overview serve --follow` with the host's disk (on DEVICE; "none" if left out), opens so many
pages' connections to it, adds a goal a few seconds, and prints how long it took from the line that
was written to the feed until each page had its update, and what the host's audio says of its
blocks.
"""

from __future__ import annotations

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

BETWEEN_S = 4.0
"""Less than a connection may be idle."""


async def ask(host: str, port: int, path: str, cookie: str, token: str = "") -> tuple[str, bytes]:
    """One request on a connection of its own; the head and the body."""
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


async def fetch(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, host: str, port: int, cookie: str
) -> bytes:
    """An update, on a connection that stays open."""
    writer.write(
        f"GET /live/update?since=-1&rate=0 HTTP/1.1\r\nHost: {host}:{port}\r\n"
        f"Cookie: {cookie}\r\n\r\n".encode()
    )
    head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").lower()
    return await reader.readexactly(int(head.partition("content-length:")[2].split()[0]))


async def page(host: str, port: int, cookie: str, took: dict[str, list[float]]) -> None:
    """A page without sound of its own: it is told, and fetches."""
    kept = await asyncio.open_connection(host, port)  # as a browser does
    await fetch(*kept, host, port, cookie)
    reader, writer = await asyncio.open_connection(host, port)
    writer.write(
        f"GET /live/events HTTP/1.1\r\nHost: {host}:{port}\r\nCookie: {cookie}\r\n\r\n".encode()
    )
    while line := await reader.readline():
        if not line.startswith(b"data: "):
            continue
        told = json.loads(line[6:])
        goals = [one["label"] for one in told["news"] if one["kind"] == "goal"]
        if not goals:
            continue
        now = time.time()
        try:
            body = await fetch(*kept, host, port, cookie)
        except (asyncio.IncompleteReadError, ConnectionError):  # idle for too long
            kept = await asyncio.open_connection(host, port)
            body = await fetch(*kept, host, port, cookie)
        assert goals[-1].encode() in body
        took["notice"].append(now - float(goals[-1]))
        took["update"].append(time.time() - float(goals[-1]))
        took["bytes"].append(len(body))


async def measure(pages: int, updates: int, device: str) -> None:
    folder = Path(tempfile.mkdtemp())
    feed = folder / "match.feed"
    feed.write_text('{"overview_feed": 1, "title": "A - B", "expect_s": 5700}\n'
                    '{"event": {"time_s": 0, "kind": "period"}}\n')  # fmt: skip
    server = subprocess.Popen(
        [sys.executable, "-m", "overview_dsp", "serve", "--follow", str(feed), "--port", "0",
         "--audio", "host", "--device", device, "--json", "--tell", "none"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ,
    )  # fmt: skip
    assert server.stdout is not None
    where = json.loads(server.stdout.readline())["address"]
    parts = urlsplit(where)
    host, port, token = parts.hostname, parts.port, parts.fragment.removeprefix("token=")
    head, _ = await ask(host, port, "/session", "", token)
    cookie = next(line for line in head.split("\r\n") if line.lower().startswith("set-cookie:"))
    cookie = cookie.partition(":")[2].partition(";")[0].strip()
    took: dict[str, list[float]] = {"notice": [], "update": [], "bytes": []}
    open_pages = []
    for _ in range(pages):
        open_pages.append(asyncio.create_task(page(host, port, cookie, took)))
        await asyncio.sleep(0.01)
    await asyncio.sleep(3.0)
    for n in range(updates):
        with feed.open("a") as file:
            label = f"{time.time():.6f}"
            goal = {"event": {"time_s": 60 + 60 * n, "kind": "goal", "label": label}}
            file.write(json.dumps(goal) + "\n")
        await asyncio.sleep(BETWEEN_S)
    server.terminate()
    summary = [json.loads(line) for line in server.stdout.read().splitlines()][-1]["summary"]
    for one in open_pages:
        one.cancel()
    for what in ("notice", "update"):
        values = sorted(took[what])
        print(f"{what}: {len(values)} of {pages * updates}, median "
              f"{statistics.median(values):.3f} s, p99 {values[int(len(values) * 0.99)]:.3f} s, "
              f"longest {values[-1]:.3f} s")  # fmt: skip
    print(f"an update: {max(took['bytes']) / 1000:.1f} kB without the surface")
    names = ("blocks", "late_callbacks", "underflows", "callback_p99_us")
    print("host: " + ", ".join(f"{name} {summary[name]}" for name in names))


if __name__ == "__main__":
    pages, updates, device = (sys.argv[1:] + ["300", "8", "none"][len(sys.argv) - 1 :])[:3]
    asyncio.run(measure(int(pages), int(updates), device))
