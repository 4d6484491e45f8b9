"""
Design a preset, and morph it into another
==========================================

For a designer: change the values of a preset (they are checked, and presets never change in
place), listen to the difference, measure how strong each event kind feels, and morph one preset
into another.
"""

import matplotlib.pyplot as plt

import overview_dsp as ov

match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
goal = football.kinds["goal"]
harder = football.with_value("kinds.goal.height", 2.0 * goal.height)
harder = harder.with_value("surface.intensity_gain", 0.2)

# %%
# Goals twice as high, on a quieter ground:

result = ov.render(match, harder, ov.sweep(2.0))
result

# %%
# What a finger gets of each kind, in slow, medium and fast sweeps, a tap and the recoils:

report = ov.measure.feel_report(harder, match)
print(report.table())

# %%
# From felt to silk in five presets; each is a preset like any other and can be saved.

figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
for number, preset in enumerate(ov.presets.morph(football, ov.load_preset("silk"), steps=5)):
    surface = ov.build_surface(match, preset)
    shown = surface.friction[20000:24000]
    axes.semilogy(1e3 * shown, color=str(0.15 * number), linewidth=0.8, label=preset.name)
axes.set(xlabel="cells of the surface", ylabel="friction, mN·m·s/rad")
axes.legend(frameon=False, fontsize=7)
axes.set_title("A part of the surface in five presets from football (black) to silk (grey)")
