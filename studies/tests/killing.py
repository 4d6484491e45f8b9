"""A server of a study that is killed over and over while a page answers: a program of its own.

``python -m studies.tests.killing FOLDER KILLS SEED`` prints what was acknowledged as JSON. Each
server is a fork, so that a kill costs milliseconds; another fork kills it at a random moment. Now
and then the page itself forgets all that it knew, as a tab that was killed.
"""

from __future__ import annotations

import http.client
import json
import os
import random
import signal
import sys
import threading
import time
from pathlib import Path

# what a server imports when it begins: once here, not in each fork
import anyio._backends._asyncio  # noqa: F401
import uvicorn.lifespan.off
import uvicorn.loops.asyncio  # noqa: F401

from overview_dsp.web.server import listen
from overview_studies.store import Store
from studies.tests.client import Page, serve

LONGEST_S = 0.3


class Killed:
    """A server and its killer."""

    def __init__(self, folder, rng):
        self.folder, self.rng = folder, rng
        with listen("127.0.0.1", 0) as socket:
            self.port = socket.getsockname()[1]
        self.kills = 0
        self.start()

    def start(self):
        self.server = os.fork()
        if self.server == 0:
            store = Store(self.folder / "responses.sqlite")
            # its own socket: who waits in its queue hears of its death
            serve(self.folder, store, listen("127.0.0.1", self.port))
            threading.Event().wait()
        server, pause = self.server, self.rng.uniform(0.0, LONGEST_S)
        self.killer = os.fork()
        if self.killer == 0:
            time.sleep(pause)
            os.kill(server, signal.SIGKILL)
            os._exit(0)

    def again(self):
        """Start it anew if it has been killed; else wait a moment: it may be starting."""
        if os.waitpid(self.server, os.WNOHANG)[0]:
            os.waitpid(self.killer, 0)
            self.kills += 1
            self.start()
        else:
            time.sleep(0.002)

    def end(self):
        os.waitpid(self.server, 0)
        os.waitpid(self.killer, 0)


def patiently(killed, ask):
    """The first answer that comes, however often the server is killed before."""
    while True:
        try:
            return ask()
        except (OSError, http.client.HTTPException):
            killed.again()


def answered(killed, port, lists, rng, acknowledged):
    """One participant's whole session; every acknowledged row is noted."""
    page = Page(port)
    status, told = patiently(killed, page.begin)
    assert status in (200, 201), told
    trials = [s["id"] for s in lists[str(told["list"])]["steps"] if s["type"] in ("trial", "form")]
    done = 0
    while done < len(trials):
        row = {"response": "goal", "rt_ms": rng.random()}
        status, said = patiently(killed, lambda: page.put(trials[done], row))  # noqa: B023
        assert status in (200, 201), said
        if status == 201:
            acknowledged.append((told["session"], trials[done], row))
        if rng.random() < 0.1:  # a double click: another answer to the same trial
            again = {"response": "none", "rt_ms": 99.0}
            assert patiently(killed, lambda: page.put(trials[done], again))[0] == 200  # noqa: B023
        done += 1
        if rng.random() < 0.1:  # a killed tab: what it knows, it has from the server
            status, seen = patiently(killed, page.look)
            assert status == 200
            assert list(seen["answers"]) == trials[:done]
    assert patiently(killed, page.finish)[0] == 200
    return told["list"]


def main(folder, kills, seed):
    rng = random.Random(seed)
    (folder / "files.js").write_text('self.FILES = {"page": [], "more": []};\n')
    with open(folder / "lists.json") as file:
        lists = json.load(file)
    killed = Killed(folder, rng)
    acknowledged, given = [], []
    while killed.kills < kills:
        given.append(answered(killed, killed.port, lists, rng, acknowledged))
    killed.end()
    print(json.dumps({"acknowledged": acknowledged, "lists": given, "kills": killed.kills}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
