"""
A tap plays everything up to there
==================================

A tap is a step of the hand (the paper's figure 6): the disk runs to the finger over every event on
its way, rests, and recoils when the finger lets go.
"""

import matplotlib.pyplot as plt

import overview_dsp as ov

match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
result = ov.render(match, preset, ov.tap(0.8, hold_seconds=1.0))

trace = result.trace
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(trace.time, trace.cursor, color="#000000")
axes.axhline(0.8, color="#009E73", linestyle="--", linewidth=1.0)
axes.set(xlabel="seconds", ylabel="position of the disk", ylim=(0.0, 1.0))
axes.set_title("The disk jumps to the finger at 0.8, rests, and falls back when it lets go")

# %%
result
