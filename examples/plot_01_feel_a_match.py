"""
Feel a match
============

For anyone: the World Cup final 2018 in one sweep of the hand. Left is heard, right is felt.

What you should feel: an even hum that swells with the crowd, fouls as soft bumps, cards as short
snaps, goals as hard knocks on which the disk catches and breaks loose. After four seconds the hand
releases, the disk arrives, and everything passes again, backwards.
"""

import matplotlib.pyplot as plt

import overview_dsp as ov

match = ov.load_timeline("world-cup-final-2018")
print(match.title)
print(match.kinds())

# %%
# What was loaded: the intensity of the match is the friction's ground, events stand on it.

figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(match.intensity.time_s / 60.0, match.intensity.value, color="#767676", linewidth=0.8)
for event in match.events:
    if event.kind == "goal":
        axes.axvline(event.time_s / 60.0, color="#0072B2", linewidth=2.0)
axes.set(xlabel="minutes", ylabel="intensity")
axes.set_title("The final's intensity over its minutes, with its goals as blue lines")

# %%
# A sweep of four seconds.

result = ov.render(match, ov.load_preset("football"), ov.sweep(4.0))
arrived_s = result.trace.time[result.trace.engaged > 0.5][-1]
assert 4.0 < arrived_s < 4.5
met = result.strikes.of_events()
assert set(met.event[met.time_s <= arrived_s]) == set(range(len(match.events)))
result
