"""
A fast and a slow sweep
=======================

Why friction: torque is friction times speed, so the same data feels different at another speed. A
vibration mapped straight from the data would be the same twice.
"""

import matplotlib.pyplot as plt

import overview_dsp as ov

match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
fast = ov.render(match, preset, ov.sweep(1.0))
slow = ov.render(match, preset, ov.sweep(4.0))

figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
for result, colour, name in ((fast, "#D55E00", "fast, 1 s"), (slow, "#0072B2", "slow, 4 s")):
    out = result.trace.engaged > 0.5
    axes.plot(
        result.trace.cursor[out],
        1e3 * result.trace.torque[out],
        color=colour,
        linewidth=0.8,
        label=name,
    )
axes.set(xlabel="part of the match", ylabel="torque, mN·m")
axes.legend(frameon=False)
axes.set_title("Torque over the match: the fast sweep's spikes are higher than the slow one's")
print(f"peak torque: fast {1e3 * fast.trace.torque.max():.0f} mN·m")
print(f"peak torque: slow {1e3 * slow.trace.torque.max():.0f} mN·m")
assert fast.trace.torque.max() > slow.trace.torque.max()

# %%
# The fast sweep:

fast

# %%
# The slow one:

slow
