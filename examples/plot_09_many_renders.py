"""
Many renders for a study
========================

For a researcher: every combination of presets, gestures and seeds, rendered on all cores, in order,
with the bits that each has alone. ``overview batch`` does it from a file, with a manifest, on a
cluster if need be.
"""

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
heights = (4.0, 8.0, 16.0, 32.0)
presets = [football.with_value("kinds.goal.height", height) for height in heights]
jobs = ov.render_jobs([match], presets, [ov.sweep(1.0), ov.sweep(2.0)], seeds=range(3))

level = {}
for result in ov.render_many(jobs, tail="none"):
    height = result.job.preset.kinds["goal"].height
    seconds = result.job.gesture.duration_s
    goals = [
        strike
        for strike, event in zip(result.strikes.level, result.strikes.event, strict=True)
        if event >= 0 and match.events[event].kind == "goal"
    ]
    level.setdefault(seconds, {}).setdefault(height, []).append(np.mean(goals))

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for (seconds, means), marker in zip(sorted(level.items()), "os", strict=True):
    decibels = [20.0 * np.log10(np.mean(means[height])) for height in heights]
    axes.semilogx(heights, decibels, marker=marker, label=f"gesture of {seconds:g} s")
axes.set_xticks(heights, [f"{height:g}" for height in heights])
axes.set(xlabel="height of a goal, times the ground", ylabel="strike, dB of full scale")
axes.legend(frameon=False)
axes.set_title("The higher a goal's friction and the faster the hand, the harder it strikes")

# %%
# One of the stimuli:

ov.render(match, presets[-1], ov.sweep(1.0), seed=2)
