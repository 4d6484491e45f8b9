"""What people follow: server-sent events, JSON, sounds, gzip and files without a suffix.

Each input is followed with its true events or values, or refused in one line that says why.
"""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import threading
from dataclasses import dataclass

import numpy as np
import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.data.feeds import follower as follower_module
from overview_dsp.data.feeds import network_sources, sources
from overview_dsp.data.feeds.follower import Follower
from overview_dsp.live.inputs.feeds import open_source
from tests.data.feeds.servers import event_stream, wait_until

GOAL, FOUL = (60.0, "goal", "Ada"), (120.0, "foul", "")
LINES = (
    '{"event": {"time_s": 60, "kind": "goal", "label": "Ada"}}',
    '{"event": {"time_s": 120, "kind": "foul"}}',
)
ROWS = '{"time_s": 60, "event": "goal", "label": "Ada"}\n{"time_s": 120, "event": "foul"}\n'
CSV = "time_s,kind,label\n60,goal,Ada\n120,foul,\n"
LOAD = "".join(f"2024-06-03 09:{n:02d},{n % 5}\n" for n in range(12))
VALUES = tuple(float(n % 5) for n in range(12))


@pytest.fixture(autouse=True)
def short_intervals(monkeypatch):
    monkeypatch.setattr(network_sources, "POLL_EVERY_S", 0.02)
    monkeypatch.setattr(follower_module, "RETRY_S", (0.005, 0.01))
    monkeypatch.setattr(sources, "POLL_EVERY_S", 0.005)
    monkeypatch.setattr(sources, "READ_AGAIN_S", 0.005)


@dataclass(frozen=True)
class Followed:
    """A file with its events (time, kind, label) or values, or words of the refusing line."""

    shape: str
    file: str
    data: bytes
    events: tuple = ()
    values: tuple = ()
    words: str = ""


def document(**more):
    """A timeline in this package's own JSON."""
    return {
        "schema": 1,
        "title": "made",
        "duration_s": 180.0,
        "events": [
            {"time_s": 60.0, "kind": "goal", "label": "Ada"},
            {"time_s": 120.0, "kind": "foul", "label": ""},
        ],
        **more,
    }


def sound(rate, channels=1, subtype="PCM_16", form="WAV"):
    """Two seconds of a tone that grows."""
    t = np.arange(2 * rate) / rate
    tone = 0.4 * t / 2 * np.sin(2 * np.pi * 440 * t)
    file = io.BytesIO()
    soundfile.write(file, np.stack([tone] * channels, axis=1), rate, subtype, format=form)
    return file.getvalue()


BOTH = (GOAL, FOUL)
LIST = json.dumps(document()["events"])
ONE_LINE = [
    ("a timeline", json.dumps(document()), BOTH),
    ("with a line end", json.dumps(document()) + "\n", BOTH),
    ("with a byte order mark", "\ufeff" + json.dumps(document()), BOTH),
    ("without spaces", json.dumps(document(), separators=(",", ":")), BOTH),
    ("a list of events", LIST, BOTH),
    ("a list in a member", f'{{"source": "club", "events": {LIST}}}', BOTH),
    ("other characters", json.dumps(document(title="Zürich – Łódź"), ensure_ascii=False), BOTH),
    ("escaped characters", json.dumps(document(title="Zürich – Łódź")), BOTH),
    ("members in another order", json.dumps(dict(reversed(document().items()))), BOTH),
    ("one event", json.dumps(document()["events"][:1]), (GOAL,)),
]
KEYED = [
    ("words", ROWS, BOTH),
    ("CRLF", ROWS.replace("\n", "\r\n"), BOTH),
    ("an incomplete row", ROWS + '{"time_s": 130, "ev', BOTH),
    ("empty lines", ROWS.replace("\n", "\n\n"), BOTH),
    ("numbers as texts", ROWS.replace("60", '"60"').replace("120", '"120"'), BOTH),
    (
        "the event first",
        '{"event": "goal", "label": "Ada", "time_s": 60}\n{"event": "foul", "time_s": 120}\n',
        BOTH,
    ),
    ("a name in capitals", ROWS.replace('"event"', '"Event"'), BOTH),
    ("clocks", ROWS.replace(": 60", ': "0:01:00"').replace(": 120", ': "0:02:00"'), BOTH),
    ("objects", "\n".join(LINES) + "\n", BOTH),
    ("no space", ROWS.replace(": ", ":").replace(", ", ","), BOTH),
]
SERIES = [
    ("commas", "time,load\n" + LOAD, "load.csv"),
    ("semicolons", "time;load\n" + LOAD.replace(",", ";"), "load.csv"),
    ("tabs", "time\tload\n" + LOAD.replace(",", "\t"), "load.tsv"),
]
SOUNDS = [
    ("8 kHz", sound(8000), "a.wav"),
    ("stereo of 24 bits", sound(44100, 2, "PCM_24"), "a.wav"),
    ("floats", sound(48000, 1, "FLOAT"), "a.wav"),
    ("unsigned bytes", sound(11025, 1, "PCM_U8"), "a.wav"),
    ("no suffix", sound(16000), "crowd"),
    ("capitals", sound(16000), "CROWD.WAV"),
    ("gzip", gzip.compress(sound(16000)), "a.wav.gz"),
    ("FLAC", sound(16000, form="FLAC"), "a.flac"),
]
INPUTS = [
    *(
        Followed(f"one line: {name}", "a.json", text.encode(), events)
        for name, text, events in ONE_LINE
    ),
    *(Followed(f"rows: {name}", "a.jsonl", text.encode(), events) for name, text, events in KEYED),
    *(
        Followed(f"no suffix: {name}", "a", text.encode(), events)
        for name, text, events in KEYED[:3]
    ),
    *(
        Followed(f"no suffix: {name}", "a", text.encode(), events)
        for name, text, events in ONE_LINE[:3]
    ),
    Followed("no suffix: table of events", "a", CSV.encode(), BOTH),
    *(
        Followed(f"no suffix: {name}", "a", text.encode(), values=VALUES)
        for name, text, _ in SERIES
    ),
    Followed("no suffix: gzip", "a", gzip.compress(CSV.encode()), BOTH),
    Followed("no suffix: words", "a", b"no table\nof anything\n", words="no longer followed"),
    *(
        Followed(f"gzip: {name}", f"{file}.gz", gzip.compress(text.encode()), values=VALUES)
        for name, text, file in SERIES
    ),
    Followed("gzip: events", "a.csv.gz", gzip.compress(CSV.encode()), BOTH),
    Followed("gzip: rows", "a.jsonl.gz", gzip.compress(ROWS.encode()), BOTH),
    Followed("gzip: one line", "a.json.gz", gzip.compress(ONE_LINE[0][1].encode()), BOTH),
    Followed(
        "gzip: two members",
        "a.csv.gz",
        b"".join(map(gzip.compress, (CSV[:30].encode(), CSV[30:].encode()))),
        BOTH,
    ),
    Followed("gzip: another name", "a.csv", gzip.compress(CSV.encode()), BOTH),
    Followed("gzip: cut", "a.csv.gz", gzip.compress(CSV.encode())[:-12], words="a.csv.gz"),
    Followed("gzip: damaged", "a.csv.gz", b"\x1f\x8b\x08\x00" + bytes(40), words="a.csv.gz"),
]
# the parts of a stream, and its events
STREAMS = [
    ("one line each", [f"data: {line}\n\n" for line in LINES]),
    ("CRLF", [f"data: {line}\r\n\r\n" for line in LINES]),
    ("no space", [f"data:{line}\n\n" for line in LINES]),
    ("comments", [f": hello\n\ndata: {line}\n\n: bye\n\n" for line in LINES]),
    (
        "names and numbers",
        [f"event: update\nid: {n}\nretry: 10\ndata: {line}\n\n" for n, line in enumerate(LINES)],
    ),
    (
        "an object over lines",
        [
            f"data: {line.replace(': {', ':{', 1).replace('{', '{' + chr(10) + 'data: ', 1)}\n\n"
            for line in LINES
        ],
    ),
    ("two lines in one", [f"data: {LINES[0]}\ndata: {LINES[1]}\n\n"]),
    ("a byte order mark", ["\ufeff" + f"data: {LINES[0]}\n\n", f"data: {LINES[1]}\n\n"]),
    ("pieces of bytes", list("".join(f"data: {line}\n\n" for line in LINES))),
    ("unknown fields", [f"colour: red\ndata: {line}\n\n" for line in LINES]),
]


def found(live):
    """The events of a live timeline as (time, kind, label)."""
    return tuple((one.time_s, one.kind, one.label) for one in live.snapshot().events)


@contextlib.contextmanager
def followed(source):
    one = Follower(ov.LiveTimeline(), open_source(source, None)).start()
    try:
        yield one
    finally:
        one.close()


@pytest.mark.parametrize("made", INPUTS, ids=[one.shape for one in INPUTS])
def test_a_file_is_followed_with_what_it_holds_or_refused(made, tmp_path):
    path = tmp_path / made.file
    path.write_bytes(made.data)
    with followed(str(path)) as one:
        assert wait_until(lambda: one.live.revision > 0 or one.over, 20)
        messages = one.take_messages()
        if made.words:
            assert found(one.live) == ()
            (line,) = messages
            assert made.words in line
            assert "\n" not in line
            return
        assert messages == ()
        if made.values:
            curve = one.live.snapshot().intensity
            assert tuple(curve.value) == made.values
            assert curve.time_s[-1] - curve.time_s[0] == 11 * 60.0
        else:
            assert wait_until(lambda: found(one.live) == made.events, 20), found(one.live)


@pytest.mark.parametrize(
    ("data", "file"), [one[1:] for one in SOUNDS], ids=[one[0] for one in SOUNDS]
)
def test_a_sound_is_followed_with_its_loudness(data, file, tmp_path):
    path = tmp_path / file
    path.write_bytes(data)
    with followed(str(path)) as one:
        assert wait_until(lambda: one.live.revision > 0 or one.over, 20)
        assert one.take_messages() == ()
        curve = one.live.snapshot().intensity
        assert curve.time_s[-1] == pytest.approx(2.0, abs=0.3)
        loud = curve.value[np.isfinite(curve.value)]
        assert loud[-1] > loud[0]  # the tone grows


@pytest.mark.parametrize("parts", [one[1] for one in STREAMS], ids=[one[0] for one in STREAMS])
def test_a_stream_of_server_sent_events_that_never_ends_is_followed(parts):
    done = threading.Event()

    def write(file):
        for part in parts:
            file.write(part.encode())
            file.flush()
        while not done.wait(0.05):
            file.write(b": alive\n\n")

    with event_stream(write) as address, followed(address) as one:
        is_right = wait_until(lambda: found(one.live) == BOTH, 20)
        done.set()
        assert is_right, (found(one.live), one.take_messages())
        assert one.take_messages() == ()


@pytest.mark.parametrize(
    ("file", "rows"),
    [
        ("load.csv", ["time,load\n", *LOAD.splitlines(keepends=True)]),
        ("load", ["time;load\n", *LOAD.replace(",", ";").splitlines(keepends=True)]),
        ("goals.csv", CSV.splitlines(keepends=True)),
        ("goals.jsonl", ROWS.splitlines(keepends=True)),
        ("goals", ROWS.splitlines(keepends=True)),
    ],
)
def test_a_table_is_followed_from_its_first_line_on(file, rows, tmp_path):
    path = tmp_path / file
    path.write_text(rows[0])
    with followed(str(path)) as one:
        for row in rows[1:]:
            wait_until(lambda: one.over, 0.05)
            with open(path, "a", encoding="utf-8") as out:
                out.write(row)
        if "goals" in file:
            assert wait_until(lambda: found(one.live) == BOTH, 20), one.take_messages()
        else:
            assert wait_until(
                lambda: one.live.revision and one.live.snapshot().duration_s == 660, 20
            )
        assert one.take_messages() == ()


def test_a_stream_of_rows_is_refused_with_what_its_lines_must_be(tmp_path):
    path = tmp_path / "rows.feed"
    path.write_text(LINES[0] + "\n" + ROWS)
    with followed(str(path)) as one:
        assert wait_until(lambda: one.rejected == 2, 20)
        assert found(one.live) == (GOAL,)
        assert all("unknown key" in line and "allowed" in line for line in one.take_messages())
