"""
The minute before a goal
========================

For who felt a goal in a glance and wants to know how it came about: the same hand over a window of
a minute feels passes and shots one by one. This is the paper's first scenario. (A real match is
taken where the environment variable ``OVERVIEW_TEST_DATA`` names a folder with one; the passes of
the bundled match are made up.)
"""

import os
from pathlib import Path

import matplotlib.pyplot as plt

import overview_dsp as ov

real = Path(os.environ.get("OVERVIEW_TEST_DATA", "")) / "football" / "statsbomb" / "22936.json"
match = ov.load_timeline(real if real.is_file() else "world-cup-final-2018")
preset = ov.load_preset("football")
print(match)
goal = match.event("goal", 2)
minute = match.window(goal.time_s - 55.0, goal.time_s + 5.0)
print(goal.label)
print("the whole match:", match.kinds())
print("this minute:", minute.kinds())

figure, axes = plt.subplots(figsize=(8, 2.2), layout="constrained")
for height, kind in enumerate(minute.kinds()):
    times = [event.time_s for event in minute.events if event.kind == kind]
    axes.plot(times, [height] * len(times), "|", markersize=16)
axes.margins(y=0.4)
axes.set_yticks(range(len(minute.kinds())), list(minute.kinds()))
axes.set(xlabel="seconds of the window")
axes.set_title("Touches, one by one, of the minute about the goal")

# %%
# An eight-second sweep over that minute:

result = ov.render(minute, preset, ov.sweep(8.0))
result
