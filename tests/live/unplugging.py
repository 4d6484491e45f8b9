"""The 16 cases of cubeb's tests in which a device is unplugged, as sessions of `overview play`.

An input stream is a sound that is followed (`--follow audio:NAME`), an output stream the session's
output, a duplex stream both. A device that isn't the default is one that the user named. A stream
that is destroyed after the device was unplugged is a session that `q` ends at once; a stream that
is suspended or initialized again is one that goes on. Both benches, the simulated PortAudio and a
JACK server, run the same sessions.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from dataclasses import dataclass

import overview_dsp as ov
from overview_dsp.data.feeds.follower import Follower
from overview_dsp.live.inputs import feeds
from overview_dsp.live.output import portaudio_library, reconnecting_stream
from overview_dsp.live.output.reconnecting_stream import StreamOpener
from overview_dsp.live.screen import plain_mode
from overview_dsp.live.session.live_updates import FollowSettings
from overview_dsp.live.session.player import OpenedPlayer, PlayerSettings

WITHIN_S = 20.0


@dataclass(frozen=True)
class Case:
    """The kind of stream, the device that is unplugged, whether it was named, and what follows."""

    stream: str
    unplugged: str
    named: bool
    quits: bool

    @property
    def name(self) -> str:
        """Name of the test in cubeb's `device_change.rs`."""
        verb = "suspend" if self.named else "reinit"
        verb, how = ("destroy", "after") if self.quits else (verb, "by")
        kind = "nondefault" if self.named else "default"
        return f"{verb}_{self.stream}_stream_{how}_unplugging_a_{kind}_{self.unplugged}_device"


CASES = {
    case.name: case
    for stream, scopes in (("input", "i"), ("output", "o"), ("duplex", "io"))
    for scope in scopes
    for named in (True, False)
    for quits in (True, False)
    for case in [Case(stream, {"i": "input", "o": "output"}[scope], named, quits)]
}


class Attempts:
    """Counter of the attempts to open an output or a sound input."""

    def __init__(self):
        self.count = 0
        self._lock = threading.Lock()

    def counted(self, function):
        def call(*arguments):
            with self._lock:
                self.count += 1
            return function(*arguments)

        return call


class Session:
    """One session, played by the keys of a script; `report` has what a user noticed."""

    def __init__(self, case, bench, folder):
        self.case, self.bench, self.folder = case, bench, folder
        self.said, self.report = [], {}
        self.attempts = Attempts()

    def run(self):
        case, bench = self.case, self.bench
        named = {case.unplugged: bench.named[case.unplugged]} if case.named else {}
        follower, timeline = None, ov.load_timeline("world-cup-final-2018")
        follow = None
        take = os.path.join(self.folder, "take.csv")
        with contextlib.ExitStack() as stack:
            patch = stack.enter_context(bench.patching())
            patch(reconnecting_stream, "RETRY_EVERY_S", 0.1)
            patch(feeds, "RETRY_S", 0.1)
            patch(feeds, "WAIT_S", 0.05)
            patch(StreamOpener, "__call__", self.attempts.counted(StreamOpener.__call__))
            patch(feeds.SoundInput, "_open", self.attempts.counted(feeds.SoundInput._open))
            patch(plain_mode, "_raw_keys", lambda: contextlib.nullcontext(self._read))
            if case.stream != "output":
                live = ov.LiveTimeline()
                source = feeds.open_source(f"audio:{named.get('input', '')}", None)
                follower = Follower(live, source).start()
                stack.callback(follower.close)
                timeline, follow = live.padded_snapshot(), FollowSettings(live, follower)
            self.follower = follower
            device = "none" if case.stream == "input" else named.get("output")
            settings = PlayerSettings("football", device=device, record=take, follow=follow)
            opened = OpenedPlayer(timeline, settings, self.said.append, self.said.append)
            self.script = self._script()
            with opened as self.player:
                plain_mode.run(self.player, None, lambda: False, self.said.append)
                self.report["last"] = vars(self.player.state)
        gesture = ov.load_gesture(take)
        self.report["touches"] = [bool(one) for one in gesture.touching]
        self.report["left open"] = len(portaudio_library.OPEN_STREAMS)
        self.report["said"] = self.said
        return self.report

    def _read(self):
        """Return the next keys of the script, then `q`."""
        time.sleep(0.01)
        return next(self.script, "q")

    def _until(self, condition, goal):
        until = time.monotonic() + WITHIN_S
        while not condition():
            assert time.monotonic() < until, (goal, self.player.state, self.said)
            yield ""

    def _script(self):
        case, player, bench, report = self.case, self.player, self.bench, self.report
        output, follower = player.output, self.follower
        yield "\x1b[F"  # touches the end
        yield from self._until(
            lambda: (
                player.state.name == "running"
                and output.meters.callbacks > 5
                and (follower is None or follower.live.revision > 0)
            ),
            "start",
        )
        bench.unplug(case.unplugged, case.named)
        if case.quits:
            return

        def lost():
            if case.unplugged == "output":
                return player.state.name == "output lost"
            return "lost" in follower.status_text

        def attempts_and(count):
            before = self.attempts.count
            yield from self._until(lambda: self.attempts.count >= before + count, "attempts")

        def played(count=10):
            before = output.meters.callbacks
            yield from self._until(lambda: output.meters.callbacks >= before + count, "sound")

        yield from self._until(lost, "loss")
        report["state"] = vars(player.state)
        report["touching"] = player.pointer.touching
        before = len(self.said)
        yield "w"
        report["words"] = self.said[before:]
        if case.unplugged == "input" and bench.plays_without_input:
            yield from played()
            report["state"] = vars(player.state)
        if case.named or case.stream not in bench.follows:
            bench.offer_another()
            yield from attempts_and(2)
            report["still lost"] = lost()
            bench.replug(case.unplugged, case.named)
        else:
            bench.offer_another()
        if case.name in bench.never_found_again:
            yield from played()
            report["after"] = vars(player.state)
            return
        yield from self._until(lambda: not lost(), "return")
        yield from played()
        if follower is not None:
            yield from self._until(lambda: "lost" not in follower.status_text, "feed")
        report["back"] = output.name
        report["recorded"] = getattr(bench, "recorded", lambda: None)()
        yield "\x1b[F"
        yield from self._until(lambda: player.state.name == "running", "touch")
        report["after"] = vars(player.state)
