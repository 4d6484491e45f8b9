"""`overview feed`, and `play` with what it tells."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import click
import pytest

import overview_dsp as ov
from overview_dsp.cli.options.follow import Feed
from overview_dsp.cli.options.reading import Reading
from tests.cli.running import MATCH, environment, overview, refused


def test_a_feed_writes_a_match_as_json_lines():
    outcome = overview("feed", MATCH, "--speed", "inf")
    assert outcome.code == 0
    lines = [json.loads(line) for line in outcome.out.splitlines()]
    assert lines[0]["overview_feed"] == 1
    assert lines[-1]["end"] == 5880.0
    assert sum("event" in line for line in lines) == 32


def test_a_feed_keeps_its_speed(tmp_path):
    path = tmp_path / "short.csv"
    path.write_text("# duration_s: 40\ntime_s,kind\n20,goal\n")
    begun = time.monotonic()
    assert overview("feed", path, "--speed", "40").code == 0
    assert time.monotonic() - begun >= 1.0


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("feed", MATCH, "--speed", "0"), ("--speed", "above 0")),
        (("feed", "nothing.json"), ("nothing.json",)),
        (("play",), ("--follow",)),
        (("play", MATCH, "--follow", "x.feed"), ("replaces TIMELINE; remove", MATCH)),
        (("play", MATCH, "--expected-duration", "95m"), ("--expected-duration", "--follow")),
        (("play", "--follow", "x.feed", "--expected-duration", "soon"), ("soon", "95m")),
        (("play", "--follow", "x.feed", "--layout", "level"), ("level", "so-far")),
        (("play", "--follow", "x.feed", "--value-column", "Close"), ("--value-column", "--follow")),
        (("play", "--follow", "x.feed,held=-1"), ("--follow: held=-1; must be 0 s or more",)),
        (("play", "--follow", "x.feed,held=nan"), ("--follow: held=nan; must be 0 s or more",)),
        (("play", "--follow", "x.feed,held=soon"), ("held=soon; must be 0 s or more",)),
        (("play", "--follow", "pcm:48000", "--input", "-"), ("both read standard input",)),
        (("play", "--follow", "pcm:loud"), ("pcm:RATE",)),
        (("serve", MATCH, "--announce", "goal"), ("--announce", "--follow")),
    ],
)
def test_what_cannot_be_followed_gives_a_one_line_error(words, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(overview(*words), *named)


def test_a_match_from_a_feed_is_played_recorded_and_rendered(tmp_path):
    take = tmp_path / "take.csv"
    hand = tmp_path / "hand.csv"
    ov.save_gesture(ov.tap(0.5, 0.5) + ov.pause(1.0) + ov.tap(0.9, 0.5) + ov.pause(4.0), hand)
    lines = overview("feed", MATCH, "--speed", "inf").out.splitlines(keepends=True)
    goals = [n for n, line in enumerate(lines) if '"kind": "goal"' in line]
    played = subprocess.Popen(
        [sys.executable, "-m", "overview_dsp", "play", "--follow", "-", "--device", "none",
         "--screen", "json", "--layout", "so-far", "--record", str(take), "--input", str(hand)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment(),
    )  # fmt: skip
    played.stdin.write("".join(lines[: goals[0]]))
    played.stdin.flush()
    first = json.loads(played.stdout.readline())  # it plays: what comes now is new
    assert first["following"].startswith("data until")
    said = played.communicate("".join(lines[goals[0] :]), timeout=300)[1]
    assert played.returncode == 0
    assert "new: goal" in said
    changes = json.loads(take.with_suffix(".json").read_text())["changes"]
    assert any("timeline" in change for change in changes)
    on = take.with_suffix(".timeline.json")
    outcome = overview("render", on, "--gesture", take, "-o", tmp_path / "again.wav",
                       "--sample-rate", "8000")  # fmt: skip
    assert outcome.code == 0


@pytest.mark.parametrize(("suffix", "after_s"), [("", None), (",held=0.5", 0.5), (",held=0", 0.0)])
def test_a_held_disk_is_updated_after_the_seconds_that_are_named(tmp_path, suffix, after_s):
    path = tmp_path / "a.feed"
    path.write_text('{"overview_feed": 1}\n{"event": {"time_s": 2, "kind": "goal"}}\n')
    feed = Feed(follow=f"{path}{suffix}")
    with click.Context(click.Command("play")), feed.opened(None, Reading()) as settings:
        assert settings.after_s == after_s
        assert len(settings.live.snapshot().events) == 1
