"""The screen of a timeline that grows."""

from __future__ import annotations

import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.screen.app import PlayApp
from overview_dsp.live.session.live_updates import FollowSettings
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from tests.live.screen.test_app import run


def test_the_screen_shows_how_far_live_data_reach_and_new_events():
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(events=[ov.Event(300.0, "foul")], clock_s=800.0)

    async def watched():
        player = Player(
            live.padded_snapshot(),
            PresetWatch("football"),
            lambda engine, settings: NullStream(engine, 256, settings),
            OutputSettings(),
            callback="python",
            follow=FollowSettings(live),
        )
        app = PlayApp(player)
        async with app.run_test(size=(100, 30)) as pilot:
            live.append(events=[ov.Event(900.0, "goal", "1-0 Parris")], clock_s=1070.0)
            is_announced, seen = False, ""
            for _ in range(1200):
                await pilot.pause(0.05)
                seen = "\n".join(strip.text for strip in app.screen._compositor.render_strips())
                # the message may have gone by the time a busy machine has built the surface
                is_announced = is_announced or "new: goal 1-0 Parris" in seen
                if is_announced and "data until 17:50" in seen and "Now 17:50" in seen:
                    break
        player.close()
        return is_announced, seen

    is_announced, seen = run(watched())
    assert is_announced
    assert "data until 17:50" in seen
    # now is marked in the curve, beyond which there is none, and in the groove
    (row,) = [line for line in seen.splitlines() if "│ Now 17:50" in line]
    now = row.index("│ Now 17:50")
    assert abs(now - 2 - 1070.0 / 5700.0 * 95.0) < 3.0
    # (what to do is written over the beginning of the groove)
    (groove,) = [line for line in seen.splitlines() if line.count("·") > 40]
    assert set(groove[now + 30 : 98]) == {"·"}
    assert "╱" in seen
