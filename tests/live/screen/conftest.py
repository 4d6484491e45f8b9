from __future__ import annotations

import pytest

from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch


@pytest.fixture
def opened():
    """A function that opens a timeline; all players are closed at the end."""
    players = []

    def open_one(timeline, preset="plain"):
        players.append(
            Player(
                timeline,
                PresetWatch(preset),
                lambda engine, settings: NullStream(engine, 256, settings),
                OutputSettings(),
                callback="python",
            )
        )
        return players[-1]

    yield open_one
    for one in players:
        one.close()
