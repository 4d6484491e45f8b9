"""Sources of live timelines: growing files, streams and URLs; each event is added once."""

from __future__ import annotations

import gzip
import io
import itertools
import json
import os
import random
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.feeds import follower as follower_module
from overview_dsp.data.feeds import network_sources, sources
from overview_dsp.data.feeds.feed_lines import encode_line
from overview_dsp.data.feeds.follower import Follower
from overview_dsp.data.feeds.sources import LoudnessMonitor
from overview_dsp.data.readers import native
from overview_dsp.live.inputs.feeds import open_source
from tests.data.feeds.feeds import apply_line, lines_of
from tests.data.feeds.servers import FeedServer, event_stream, wait_until


@pytest.fixture(autouse=True)
def short_intervals(monkeypatch):
    monkeypatch.setattr(network_sources, "POLL_EVERY_S", 0.02)
    monkeypatch.setattr(follower_module, "RETRY_S", (0.005, 0.01))
    monkeypatch.setattr(sources, "POLL_EVERY_S", 0.005)
    monkeypatch.setattr(sources, "READ_AGAIN_S", 0.005)


@pytest.fixture
def follow():
    followers = []

    def following(text, stdin=None, **live):
        one = Follower(ov.LiveTimeline(**live), open_source(str(text), stdin))
        followers.append(one)
        return one.start()

    yield following
    for one in followers:
        one.close()


@pytest.fixture(scope="module")
def feed_text(match):
    return [encode_line(line) for line in lines_of(match)]


def test_a_feed_in_a_file_is_read_on_as_it_grows(follow, feed_text, match, tmp_path):
    path = tmp_path / "match.feed"
    one = follow(path)
    whole = "".join(feed_text)
    cuts = [0, 10, len(whole) // 3, len(whole) // 2, len(whole)]
    for start, end in itertools.pairwise(cuts):
        with open(path, "a", encoding="utf-8") as file:
            file.write(whole[start:end])
        whole_lines = whole[:end].count('"event"') - ('"event"' in whole[:end].split("\n")[-1])
        assert wait_until(lambda n=whole_lines: len(one.live.snapshot().events) == n)
    assert wait_until(lambda: one.live.ended)
    assert one.live.snapshot() == match
    assert one.status_text.startswith("the end, data until 1:38:00")


def test_a_feed_that_restarts_in_its_file_changes_nothing(follow, feed_text, match, tmp_path):
    path = tmp_path / "match.feed"
    path.write_text("".join(feed_text))
    one = follow(path)
    assert wait_until(lambda: one.live.ended)
    revision = one.live.revision
    other = tmp_path / "other"
    other.write_text("".join(feed_text[: len(feed_text) // 2]))
    os.replace(other, path)
    with open(path, "a", encoding="utf-8") as file:
        file.write('{"event": {"time_s": 5000.5, "kind": "foul", "label": "late"}}\n')
    assert wait_until(lambda: one.live.snapshot().kinds().get("foul", 0) > match.kinds()["foul"])
    assert one.live.snapshot().title == match.title  # the header has the title without the score
    assert one.live.revision == revision + 1


@pytest.mark.parametrize(
    ("name", "header", "rows"),
    [
        ("e.csv", "time_s,kind,label\n", [f"{60 * n},foul,{n}\n" for n in range(1, 9)]),
        ("s.csv", "time,load\n", [f"2024-06-03 09:{n:02d},{n % 5}\n" for n in range(12)]),
        ("s.jsonl", "", [f'{{"time_s": {n}, "value": {n * n}}}\n' for n in range(1, 12)]),
    ],
)
def test_a_growing_table_equals_the_file_at_every_step(follow, tmp_path, name, header, rows):
    path, whole = tmp_path / name, tmp_path / f"whole-{name}"
    text = header + "".join(rows[:3])
    path.write_text(text)
    one = follow(path, layout="so far")
    for row in (*rows[3:], ""):
        whole.write_text(text)
        read = ov.load_timeline(whole)
        # the text has no name, and so the timeline no title
        assert wait_until(
            lambda read=read: (
                (now := one.live.snapshot()).events == read.events
                and now.intensity == read.intensity
                and now.duration_s == read.duration_s
            )
        ), (one.take_messages(), one.live.snapshot(), read)
        with open(path, "a", encoding="utf-8") as file:
            file.write(row[:4])  # an incomplete line
            file.flush()
            file.write(row[4:])
        text += row
    assert one.lost == one.rejected == 0


def test_standard_input_is_followed_to_its_end(follow, feed_text, match):
    reading, writing = os.pipe()
    with os.fdopen(reading, "rb") as stdin, os.fdopen(writing, "wb") as out:
        one = follow("-", stdin)
        threading.Thread(
            target=lambda: (out.write("".join(feed_text).encode()), out.close())
        ).start()
        assert wait_until(lambda: one.over)
    assert one.live.snapshot() == match


def test_a_feed_at_a_url_is_requested_again_with_its_etag(follow, feed_text, match):
    server = FeedServer().start()
    server.lines = feed_text
    one = follow(f"{server.address}/feed")
    for server.available in (1, 40, len(feed_text) // 2, len(feed_text)):
        events = "".join(feed_text[: server.available]).count('"event"')
        assert wait_until(lambda n=events: len(one.live.snapshot().events) == n)
        requests = len(server.requests)
        assert wait_until(lambda n=requests: len(server.requests) > n + 2)
    assert one.live.snapshot() == match
    assert server.statuses[-1] == 304
    assert server.statuses.count(200) < 12
    server.kill()
    assert wait_until(lambda: one.status_text.startswith(("feed lost", "the end")))


def test_a_document_that_is_invalid_for_a_moment_is_read_when_it_is_valid(
    follow, tmp_path, monkeypatch
):
    read = []
    monkeypatch.setattr(
        sources, "load_timeline", lambda data: (read.append(data), ov.load_timeline(data))[1]
    )
    path = tmp_path / "events.csv"
    path.write_text("time_s,kind\n10,foul\n20,goal\n")
    one = follow(path, layout="so far")
    assert wait_until(lambda: one.live.snapshot().kinds() == {"foul": 1, "goal": 1})
    path.write_text("\0\0\n")
    assert wait_until(lambda: read[-1] == b"\0\0\n")
    path.write_text("time_s,kind\n10,foul\n20,goal\n50,foul\n")
    assert wait_until(lambda: one.live.now_s == 50.0)


@pytest.mark.parametrize(("rate", "channels"), [(768_001, 2), (99, 2), (48_000, 0), (48_000, 65)])
def test_a_sound_that_cannot_be_measured_is_a_one_line_error(rate, channels):
    with pytest.raises(ov.InputError, match=f"{channels} channels at {rate} Hz; must be 1 to 64"):
        LoudnessMonitor(rate, channels, print)
    LoudnessMonitor(768_000, 64, print)


def test_a_document_at_a_url_is_read_again_when_it_changes(follow, match):
    server = FeedServer().start()
    rows = ["time_s,kind\n", "10,foul\n", "20,goal\n", "50,foul\n"]
    server.lines, server.available = rows, 3
    one = follow(f"{server.address}/events.csv", layout="so far")
    assert wait_until(lambda: one.live.snapshot().kinds() == {"foul": 1, "goal": 1})
    revision = one.live.revision
    server.available = 4
    assert wait_until(lambda: one.live.now_s == 50.0)
    assert [change.event.time_s for change in one.live.changes_since(revision)] == [50.0]
    server.kill()


def test_no_event_is_lost_or_repeated_when_the_server_is_killed(follow, feed_text, match):
    random.seed(7)
    server = FeedServer().start()
    server.lines = feed_text
    one = follow(f"{server.address}/events")
    stops = sorted(random.sample(range(1, len(feed_text)), 20))
    for stop in stops:
        server.available = stop
        until = "".join(feed_text[:stop]).count('"event"')
        if random.random() < 0.5:  # while it sends, or after
            assert wait_until(lambda n=until: len(one.live.snapshot().events) >= n)
        server.kill()
        assert wait_until(lambda: one.status_text.startswith("feed lost"))
        server.start()
        assert wait_until(lambda: not one.status_text.startswith("feed lost"))
    server.available = len(feed_text)
    assert wait_until(lambda: one.live.ended)
    assert one.live.snapshot() == match
    changes = one.live.changes_since(0)
    assert len(changes) == len(match.events)
    assert {change.event for change in changes} == set(match.events)
    assert one.lost == 20
    messages = one.take_messages()
    assert sum("trying again" in line for line in messages) == 20
    assert sum("connected again" in line for line in messages) >= 19
    server.kill()


def test_an_event_that_is_truncated_after_its_id_is_requested_again(follow, feed_text, match):
    """The server truncates every response at a different byte."""
    lines = feed_text[:40]
    whole = [f"id: {n + 1}\ndata: {line.rstrip()}\n\n".encode() for n, line in enumerate(lines)]

    class Cutting(BaseHTTPRequestHandler):
        count = 0

        def log_message(self, *arguments):
            pass

        def do_GET(self):
            since = int(self.headers.get("Last-Event-ID", 0))
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.end_headers()
            rest = b"".join(whole[since:])
            Cutting.count += 1
            self.wfile.write(rest[: 60 + 7 * Cutting.count])

    server = ThreadingHTTPServer(("127.0.0.1", 0), Cutting)
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    one = follow(f"http://127.0.0.1:{server.server_port}/")
    known = ov.LiveTimeline()
    for line in lines:
        apply_line(known, line)
    assert wait_until(lambda: one.live.padded_snapshot() == known.padded_snapshot())
    server.shutdown()
    server.server_close()


def test_websocket_messages_of_one_and_of_many_lines_are_read(follow, feed_text, match):
    serve = pytest.importorskip("websockets.sync.server").serve

    def handler(socket):
        socket.send(feed_text[0])
        socket.send("".join(feed_text[1:2000]))
        for number, line in enumerate(feed_text[2000:]):
            text = line.rstrip("\n")
            socket.send(text.encode() if number % 2 else text)

    with serve(handler, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        port = server.socket.getsockname()[1]
        one = follow(f"ws://127.0.0.1:{port}/")
        assert wait_until(lambda: one.live.ended)
        assert one.live.snapshot() == match
        server.shutdown()


def test_each_invalid_line_is_a_one_line_message_and_the_rest_is_read(follow, feed_text, match):
    lines = [*feed_text]
    rng = random.Random(1)
    for junk in ("{", "x" * 1_000_000, '{"event": 3}', '{"clock": NaN}', "\x00\x01", '{"new": 1}'):
        for _ in range(3):
            lines.insert(rng.randrange(len(lines)), junk + "\n")
    one = follow("-", io.BytesIO("".join(lines).encode()))
    assert wait_until(lambda: one.over)
    assert one.live.snapshot() == match
    messages = one.take_messages()
    assert 5 <= len(messages) <= 8
    assert all(len(line) < 300 and "\n" not in line for line in messages)
    assert any("longer than 64 KB" in line for line in messages)
    assert any("a line of a later version" in line for line in messages)
    assert one.rejected == 18


def test_ten_thousand_events_per_second_are_read_in_bounded_memory(follow):
    one = follow("-", io.BytesIO(b"".join(
        b'{"event": {"time_s": %d, "kind": "foul", "label": "%d"}}\n' % (n // 10, n)
        for n in range(50_000)
    )))  # fmt: skip
    assert wait_until(lambda: one.over)
    assert len(one.live.snapshot().events) <= 20_000
    assert one.live.now_s >= 4_998.0


@pytest.mark.parametrize(
    ("text", "word"),
    [("", "must be a file"), ("pcm:abc", "pcm:RATE"), ("pcm:48000:2:3", "pcm:RATE")],
)
def test_an_invalid_source_is_a_one_line_error(text, word):
    with pytest.raises(ov.InputError, match=word):
        open_source(text, io.BytesIO())


def test_rows_with_a_key_event_a_one_line_document_and_binary_files_are_followed(
    follow, match, crowd_file, tmp_path
):
    rows = "".join(json.dumps({"time_s": n * 60, "event": "foul"}) + "\n" for n in range(5))
    document = json.dumps(json.loads(native.encode(match)))
    contents = {
        "rows.jsonl": rows.encode(),
        "rows": rows.encode(),
        "document.json": document.encode(),
        "document": document.encode(),
        "indented": json.dumps(json.loads(document), indent=1).encode(),
        "rows.jsonl.gz": gzip.compress(rows.encode()),
        "sound": crowd_file.read_bytes(),
    }
    for name, data in contents.items():
        path = tmp_path / name
        path.write_bytes(data)
        one = follow(path)
        read = ov.load_timeline(data)
        assert wait_until(lambda one=one: one.live.revision > 0 or one.over), name
        now = one.live.snapshot()
        assert one.take_messages() == (), name
        assert (now.events, now.intensity) == (read.events, read.intensity), name


def test_a_server_sent_event_without_an_end_is_lost_in_one_line_and_in_bounded_memory(
    follow, monkeypatch
):
    monkeypatch.setattr(network_sources, "MAX_MESSAGE_BYTES", 1 << 20)

    def write(file):
        while True:
            file.write(b"data: x\n" * 1000)

    with event_stream(write) as address:
        one = follow(address)
        assert wait_until(lambda: one.lost > 0)
        (line,) = one.take_messages()
        assert "more than 1 MB" in line
        assert "empty line" in line
        one.close()
        assert wait_until(lambda: one.over)


def test_a_source_that_cannot_be_read_ends_with_a_message(follow, tmp_path):
    bad = tmp_path / "x.csv"
    bad.write_text("this is no table\nof anything\n")
    one = follow(bad)
    assert wait_until(lambda: one.over)
    (line,) = one.take_messages()
    assert "no longer followed" in line
    busy = FeedServer().start()
    two = follow(f"{busy.address}/busy")
    assert wait_until(lambda: two.lost == 1)
    assert "503" in two.take_messages()[0]
    busy.kill()


def test_silence_is_reported_once_with_the_time_of_the_latest_data(follow, monkeypatch, tmp_path):
    monkeypatch.setattr(follower_module, "SILENT_S", 0.2)
    path = tmp_path / "m.feed"
    path.write_text('{"event": {"time_s": 3780, "kind": "foul"}}\n')
    one = follow(path)
    messages = []
    assert wait_until(lambda: bool(messages.extend(one.take_messages()) or messages))
    for _ in range(5):
        messages += one.take_messages()
    assert messages == [f"{path}: silent; data until 1:03:00.0"]
    with open(path, "a") as file:
        file.write('{"end": 5700}\n')
    assert wait_until(lambda: one.live.ended)
    assert one.status_text == "the end, data until 1:03:00.0"


@pytest.fixture(scope="module")
def crowd_file(tmp_path_factory):
    """Return a file with 90 s of murmur, two cheers and a whistle."""
    import soundfile

    rng = np.random.default_rng(3)
    rate = 8000
    level = np.full(90 * rate, 0.01)
    for start, end, gain in ((20, 26, 0.2), (41, 41.5, 0.3), (70, 78, 0.25)):
        level[round(start * rate) : round(end * rate)] = gain
    sound = (level * rng.standard_normal(len(level))).clip(-1.0, 1.0)
    path = tmp_path_factory.mktemp("crowd") / "crowd.wav"
    soundfile.write(path, sound, rate, subtype="PCM_16")
    return path


def test_a_live_sound_has_the_same_cheers_as_its_file(follow, crowd_file):
    import soundfile

    read = ov.load_timeline(crowd_file)
    sound, rate = soundfile.read(crowd_file, dtype="int16")
    reading, writing = os.pipe()
    with os.fdopen(reading, "rb") as stdin, os.fdopen(writing, "wb") as out:
        one = follow(f"pcm:{rate}", stdin, layout="so far")
        data = sound.tobytes()
        for start in range(0, len(data), 9_999):  # any lengths, halves of samples too
            out.write(data[start : start + 9_999])
        out.close()
        assert wait_until(lambda: one.over)
    live = one.live.snapshot()
    assert live.kinds() == read.kinds()
    assert live.events == read.events
    assert live.intensity == read.intensity
    assert len(read.events) >= 3


def test_the_wait_is_short_again_after_a_connection_succeeded(monkeypatch):
    monkeypatch.setattr(follower_module, "RETRY_S", (0.001, 60.0))

    class Losing:
        name, close_timeout_s = "losing", 1.0
        times = 0

        def read(self):
            self.times += 1
            if self.times > 25:  # without a reset the wait would be a minute by now
                return
            yield b"\n"
            raise sources.LostError("gone")

    one = Follower(ov.LiveTimeline(), Losing()).start()
    try:
        assert wait_until(lambda: one.over)
    finally:
        one.close()
    assert one.lost == 25
