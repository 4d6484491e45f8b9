"""Measure how long a trial takes to be stored: `python tools/measure_study.py`.

Builds a small study, serves it by `overview study serve` in a process of its own, and lets 24
participants answer, each one second after the last answer. A time is from the request to the
response that confirms storage on disk.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

STUDY = """
title = "Was there a goal?"
participants = {people}
[task]
name = "identify"
[stimuli]
made = {{ kinds = ["goal"] }}
gestures = ["sweep:0.5"]
[phases]
main = {{ repeats = {trials} }}
catch = 0.5
"""
THINK_S = 1.0
TAKE = {"sample_rate": 48_000, "samples": 96_000,
        "events": [[400 * i, 0.0123456789 * i, 1, "touch"] for i in range(240)]}  # fmt: skip


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--participants", type=int, default=24)
    options.add_argument(
        "--trials", type=int, default=20, help="trials per event kind and participant"
    )
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "study.toml")
        file.write_text(
            STUDY.format(people=asked.participants, trials=asked.trials), encoding="utf-8"
        )
        overview = [sys.executable, "-m", "overview_dsp", "study"]
        subprocess.run([*overview, "build", file, "-o", f"{folder}/page"], check=True)
        server = subprocess.Popen(
            [*overview, "serve", f"{folder}/page", "--db", f"{folder}/r.sqlite", "--port", "0",
             "--json"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        try:
            assert server.stdout is not None
            address = urlsplit(json.loads(server.stdout.readline())["address"])
            times = take_part(
                address.port, address.fragment.removeprefix("token="), asked.participants
            )
        finally:
            server.terminate()
            server.wait()
    median, late = 1e3 * np.percentile(times, [50, 99])
    load = os.getloadavg()[0]
    print(
        f"{len(times)} trials of {asked.participants} participants at once, each with 240 "
        f"events: median {median:.1f} ms, p99 {late:.1f} ms; load {load:.1f}"
    )


def take_part(port: int | None, token: str, people: int) -> list[float]:
    """Let everybody answer everything; how long each answer took to be stored, s."""
    times: list[float] = []

    def one() -> None:
        connection = http.client.HTTPConnection("127.0.0.1", port or 80, timeout=60)
        headers = {"authorization": f"Bearer {token}", "origin": f"http://127.0.0.1:{port}"}

        def ask(method: str, path: str, body: object = None) -> dict:
            data = None if body is None else json.dumps(body).encode()
            connection.request(method, path, data, headers)
            answer = connection.getresponse()
            text = answer.read()
            assert answer.status < 300, text
            return json.loads(text)

        told = ask("POST", "/study/sessions", {"request": uuid.uuid4().hex})
        headers["x-study-secret"] = told["secret"]
        content = ask("GET", f"/lists/{told['list']:03d}.json")
        for step in content["steps"]:
            if step["type"] == "trial":
                time.sleep(THINK_S)
                began = time.perf_counter()
                row = {"response": "goal", "rt_ms": 500.0, "take": TAKE}
                ask("PUT", f"/study/sessions/{told['session']}/trials/{step['id']}", row)
                times.append(time.perf_counter() - began)

    threads = [threading.Thread(target=one) for _ in range(people)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return times


if __name__ == "__main__":
    main()
