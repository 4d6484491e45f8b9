"""
The match is on
===============

For anyone: a match in progress, as in the first scenario of the paper. A fan meets a friend during
the match, and twists the device now and then to feel whether the score has changed.

What you should feel: the first twist meets the kick-off and a few soft bumps, and behind them the
future, smooth and heavy. In the second there is a hard knock, an own goal, and in the third there
are two more. Then the hand looks closer at one, and stops just before it.
"""

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

match = ov.load_timeline("world-cup-final-2018")
preset = ov.load_preset("football")
rate = 48_000

# %%
# The match is played at 60 times its speed: one second of sound per minute of play. In a program
# of your own, the events come from a feed; here they are those of the bundled match, each at its
# time. During a touch the map stays the same: new events are added to the engine between twists.

live = ov.LiveTimeline(match.title.split(" ", 1)[0], expected_duration_s=match.duration_s)
engine = ov.Engine(preset, live.snapshot())
engine.prepare(rate, 480)
twist = ov.sweep(1.6, 0.0, 0.6)
twists = {6.0: twist, 20.0: twist, 40.0: twist}  # s of sound: minutes of play
hand, places, sound = iter(()), [], []
due = next(hand, None)
holds = False
for block in range(45 * 100):
    now_s = block * 0.01
    if now_s in twists:
        gesture = twists[now_s]
        hand = zip(gesture.time_s + now_s, gesture.theta2, gesture.touching, strict=True)
        due = next(hand)
    while due is not None and due[0] <= now_s:
        holds = bool(due[2])
        engine.control(float(due[1]), holds)
        due = next(hand, None)
    if not holds and block % 50 == 0:
        clock_s = 60.0 * now_s
        came = [event for event in match.events if event.time_s <= clock_s]
        live.append(events=came, clock_s=clock_s)  # what is there already stays as it is
        engine.set_timeline(live.snapshot())
    out = np.zeros((480, 2), dtype=np.float32)
    engine.process(out)
    sound.append(out)
    places.append(engine.meters.cursor)
sound = np.concatenate(sound)
print(f"after {live.now_s / 60.0:.0f} minutes: {live.snapshot().kinds()}")

# %%
# What was felt: the tactor's signal over the minutes of play, and where the disk was. The second
# twist meets an own goal; the third one adds the goals.

figure, (felt, disk) = plt.subplots(2, 1, figsize=(8, 4.5), sharex=True, layout="constrained")
minutes = np.arange(len(sound)) / rate
felt.plot(minutes, sound[:, 1], color="#767676", linewidth=0.3)
felt.set(ylabel="tactor", title="Three twists while the match goes on: the tactor's signal")
disk.plot(np.arange(len(places)) * 0.01, places, color="#0072B2")
disk.fill_between(minutes[::480], minutes[::480] * 60.0 / match.duration_s, 1.0, color="#DDDDDD")
disk.set(xlabel="minutes of play (seconds of sound)", ylabel="disk, 0 to 1", ylim=(0.0, 0.6))
disk.set_title("Where the disk was, and in grey the future, smooth and heavy")
disk.annotate("the future", (1.0, 0.5))

# %%
# The third twist by itself.

now = live.snapshot()
ov.render(now, preset, twist)

# %%
# A closer view of this goal: the hand moves to a point just before it, over the preceding events.

goal = now.event("goal", 1)
print(goal.label, "at", now.moment_text(goal.time_s))
part = now.window(goal.time_s - 120.0, goal.time_s + 20.0)
closer = ov.render(part, preset, ov.sweep(3.0, 0.0, 0.84))
closer
