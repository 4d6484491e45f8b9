"""
A tap plays everything up to there
==================================

A tap is a step of the input that is released at once (figure 6 of the paper). The disk runs over
every event on its way to the tapped position, and then recoils.
"""

import matplotlib.pyplot as plt

import overview_dsp as ov

match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
result = ov.render(match, preset, ov.tap(0.8))

trace = result.trace
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(trace.time, trace.cursor, color="#000000")
axes.axhline(0.8, color="#009E73", linestyle="--", linewidth=1.0)
axes.set(xlabel="seconds", ylabel="position of the disk", ylim=(0.0, 1.0))
axes.set_title("A tap of 0.05 s: the disk runs all the way to 0.8 and falls back")
assert trace.touching.sum() / result.sample_rate < 0.06
assert abs(trace.cursor.max() - 0.8) < 0.01

# %%
result
