"""A session whose output and clock go on when a test steps them: what came, sample by sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import read_meters
from overview_dsp.live.session import commands, live_updates
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch

RATE = 16_000
BLOCK = 160


class SteppedOutput:
    """Runs the engine when it is told, before any device gain; keeps samples and trace."""

    name = "stepped"
    waits_for_server = False
    missing_connections = ()
    block_size = BLOCK
    active = True

    def __init__(self, engine, settings):
        self._engine = engine
        self.sound, self.trace = [], []

    def start(self):
        pass

    def close(self):
        pass

    def restart(self, begin):
        begin()
        self.sound, self.trace = [], []

    def step(self):
        out = np.empty((BLOCK, 2), np.float32)
        trace = np.empty((BLOCK, layout.TRACE))
        self._engine.process(out, trace)
        self.sound.append(out)
        self.trace.append(trace)

    @property
    def meters(self):
        count = len(self.sound)
        now = read_meters(self._engine.memory, BLOCK / RATE)
        return replace(now, callbacks=count, frames=count * BLOCK)


class Session:
    """A player of a timeline that grows, 20 ms a step as its callers poll it."""

    def __init__(self, live, monkeypatch, preset="football", timeline=None, **keywords):
        """With a `timeline` nothing grows."""
        self.now = 1000.0
        monkeypatch.setattr(live_updates, "time", self)
        self.live = live
        self.messages = []
        follow = live_updates.FollowSettings(
            live,
            **{
                k: keywords.pop(k)
                for k in ("after_s", "announce", "layout_is_explicit")
                if k in keywords
            },
        )
        self.player = Player(
            live.padded_snapshot() if timeline is None else timeline,
            PresetWatch(preset),
            self._open,
            OutputSettings(),
            sample_rate=RATE,
            max_block_size=BLOCK,
            callback="python",
            follow=follow if timeline is None else None,
            **keywords,
        )

    def _open(self, engine, settings):
        self.output = SteppedOutput(engine, settings)
        return self.output

    def monotonic(self):
        return self.now

    def run(self, seconds, each=lambda: None):
        """Let time go on; `each` is called at every poll."""
        for _ in range(round(seconds / 0.02)):
            each()
            self.messages += commands.poll(self.player).messages
            for _ in range(round(0.02 * RATE / BLOCK)):
                self.output.step()
                self.now += BLOCK / RATE

    @property
    def samples(self):
        return np.concatenate(self.output.sound)

    @property
    def trace(self):
        return np.concatenate(self.output.trace)

    @property
    def window_timeline(self):
        return self.player.engine.timeline


def event(time_s, kind, label=""):
    return ov.Event(float(time_s), kind, label)
