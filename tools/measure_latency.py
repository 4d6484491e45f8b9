"""Measure how long events wait for the audio block, and write the table of the latency page.

    python tools/measure_latency.py [--events 300]

An event applies in the first block that begins after it. The wait is the time from the start of
that block, as known when the event was sent, to the sample at which the engine applied it: 0 where
nothing held it back. The sources are the program's own inputs: OSC over UDP, MIDI messages from the
thread of a port, a potentiometer on a serial line (a pseudo-terminal) at 100 Hz, and a page over a
WebSocket. The results are stored with the machine in docs/explanation/latency.json; the page shows
them between two comments.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import random
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from websockets.sync.client import connect

import overview_dsp as ov
from overview_dsp.devices.controllers.midi_messages import BEND_MIDDLE, MidiReader
from overview_dsp.devices.controllers.osc_messages import OscReader, encode_message
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.live.inputs.controllers import ControllerInput
from overview_dsp.live.inputs.sensors import SensorInput
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.ports.osc import OscPort
from overview_dsp.live.ports.port import QueuedPort
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from overview_dsp.units import HALF_TURN
from overview_dsp.web.data import data_routes
from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.server import WebServer, listen, make_app
from overview_dsp.web.session import HostSession

DOCS = Path(__file__).resolve().parents[1] / "docs" / "explanation"
RESULTS, PAGE = DOCS / "latency.json", DOCS / "latency.md"
BEGIN = "<!-- measured: begin, by tools/measure_latency.py -->"
END = "<!-- measured: end -->"
BLOCKS = (64, 256, 1024)
EVERY_S = 0.01
"""Interval of the potentiometer's readings, and of the session's loop."""

STEPS = 1 << 20
"""Steps of the potentiometer, so that each movement has a value of its own."""

Send = Callable[[float], int]
"""Sends a position (0 to 1), and returns the engine's sample time at which it was sent."""


@contextlib.contextmanager
def keys(player: Player) -> Iterator[Send]:
    def send(position: float) -> int:
        sent = player.engine.sample_time
        player.engine.control(position * HALF_TURN, True)
        return sent

    yield send


@contextlib.contextmanager
def osc(player: Player) -> Iterator[Send]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    reader = ControllerInput(player.engine, "osc", lambda: OscPort(str(port)), OscReader)

    def send(position: float) -> int:
        data = encode_message("/overview/theta2", [position * HALF_TURN, 1])
        sent = player.engine.sample_time
        sender.sendto(data, ("127.0.0.1", port))
        return sent

    with (
        contextlib.closing(reader),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        yield send


@contextlib.contextmanager
def midi(player: Player) -> Iterator[Send]:
    port = QueuedPort("measured", 4096)
    reader = ControllerInput(
        player.engine, "midi", lambda: port, lambda counters: MidiReader(counters=counters)
    )

    def send(position: float) -> int:
        bend = BEND_MIDDLE + round(position * (BEND_MIDDLE - 1))
        sent = player.engine.sample_time
        port.put(bytes((0xE0, bend & 0x7F, bend >> 7)))
        return sent

    with contextlib.closing(reader):
        send(0.0)  # rest, from which a turn touches
        time.sleep(0.2)
        yield send


@contextlib.contextmanager
def serial(player: Player) -> Iterator[Send]:
    import pty  # not on Windows
    import tty

    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    pot = Sensor(columns=("t_ms", "pot"), values={"potentiometer.high": float(STEPS)})
    reader = SensorInput(player.engine, os.ttyname(theirs), pot)
    wanted, sent, ended = [0.0], [(0.0, 0)], threading.Event()

    def write() -> None:
        began = time.monotonic()
        for number in range(10**9):
            if ended.wait(max(0.0, began + number * EVERY_S - time.monotonic())):
                return
            position = wanted[0]
            if position != sent[0][0]:
                sent[0] = position, player.engine.sample_time
            os.write(ours, f"{number * 10},{round(position * STEPS)}\n".encode())

    def send(position: float) -> int:
        wanted[0] = position
        while sent[0][0] != position:
            time.sleep(0.0005)
        return sent[0][1]

    writer = threading.Thread(target=write)
    writer.start()
    try:
        time.sleep(1.0)  # the format is detected, and rest is known
        yield send
    finally:
        ended.set()
        writer.join()
        reader.close()
        os.close(ours)
        os.close(theirs)


@contextlib.contextmanager
def page(player: Player) -> Iterator[Send]:
    session, access, listener = HostSession(player), Access(), listen("127.0.0.1", 0)
    routes = data_routes(player.engine.timeline, "football", audio="host")
    app = make_app(access, (), print, session, routes)
    server = WebServer(app, [listener], None, print, False)
    origin = f"127.0.0.1:{listener.getsockname()[1]}"
    headers = {"Origin": f"http://{origin}", "Authorization": f"Bearer {access.token}"}
    ended = threading.Event()

    def poll() -> None:
        while not ended.wait(EVERY_S):
            session.poll(player.engine)
            player.poll()

    def answer() -> None:
        with contextlib.suppress(OSError, EOFError):
            for text in connection:
                message = json.loads(text)
                if "ping" in message:
                    pong = {"pong": message["ping"], "time_ms": 1e3 * time.monotonic()}
                    connection.send(json.dumps(pong))

    def send(position: float) -> int:
        sent = player.engine.sample_time
        event = [1e3 * time.monotonic(), position * HALF_TURN, 1]
        connection.send(json.dumps({"events": [event]}))
        return sent

    threads = [threading.Thread(target=poll), threading.Thread(target=answer)]
    with (
        contextlib.closing(server),
        connect(f"ws://{origin}/control", additional_headers=headers, proxy=None) as connection,
    ):
        for one in threads:
            one.start()
        try:
            time.sleep(3.0)  # the clocks are compared
            yield send
        finally:
            ended.set()
            connection.close()
            for one in threads:
                one.join()


SOURCES = {"mouse and keys": keys, "OSC": osc, "MIDI": midi, "serial sensor": serial, "page": page}


def measure(source: str, block: int, events: int) -> dict[str, float]:
    """Return median, 99th percentile and worst wait of a source's events, ms."""
    player = Player(
        ov.load_timeline("world-cup-final-2018"),
        PresetWatch("football"),
        lambda engine, settings: ov.live.NullStream(engine, block, settings),
        OutputSettings(),
        max_block_size=block,
    )
    dice, waits = random.Random(1), []
    with contextlib.closing(player), SOURCES[source](player) as send:
        time.sleep(0.5)
        for number in range(events):
            time.sleep(dice.uniform(0.005, 0.03))
            _, seen = player.engine.pop_applied(0)
            sent = send(0.3 + 0.6 * (number + 1) / events)
            until, applied = time.monotonic() + 5.0, np.zeros(0)
            while not len(applied) and time.monotonic() < until:
                time.sleep(0.0005)
                found, seen = player.engine.pop_applied(seen)
                applied = found[(found["touching"] != 0) & (found["sample"] >= sent)]
            if not len(applied):
                raise SystemExit(f"{source}, {block} frames: event {number} never applied")
            # sample_time advances within a block: the next one begins at a multiple of blocks
            begins = -(-sent // block) * block
            waits.append(1e3 * (int(applied["sample"][0]) - begins) / player.engine.sample_rate)
    return {
        "median": float(np.median(waits)),
        "p99": float(np.percentile(waits, 99)),
        "worst": max(waits),
    }


def table(results: dict[str, object]) -> str:
    """Return the lines of the page between the two comments."""
    rows = [
        f"Measured on {results['machine']}, {results['events']} events each, output without a "
        f"device, load {results['load']}. Each cell is the wait beyond the next block in ms: "
        "median / 99 % / worst.",
        "",
        "| source | " + " | ".join(f"{block} frames" for block in BLOCKS) + " |",
        "|---|" + "---|" * len(BLOCKS),
    ]
    for source, found in results["waits_ms"].items():  # type: ignore[attr-defined]
        cells = [found[str(block)] for block in BLOCKS]
        texts = [f"{one['median']:.1f} / {one['p99']:.1f} / {one['worst']:.1f}" for one in cells]
        rows.append(f"| {source} | " + " | ".join(texts) + " |")
    return "\n".join(rows)


def renewed(text: str, results: dict[str, object]) -> str:
    """Return the page with the table of these results."""
    before, _, rest = text.partition(BEGIN)
    return f"{before}{BEGIN}\n\n{table(results)}\n\n{END}{rest.partition(END)[2]}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--events", type=int, default=300)
    events = parser.parse_args().events
    waits = {
        source: {str(block): measure(source, block, events) for block in BLOCKS}
        for source in SOURCES
    }
    results = {
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "load": round(os.getloadavg()[0], 1),
        "events": events,
        "waits_ms": waits,
    }
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8"), results), encoding="utf-8")
    print(table(results))


if __name__ == "__main__":
    main()
