"""
A share, closer and closer
==========================

For an investor: one twist of the wrist spans years of a price, then the same twist spans the last
weeks. This is the second scenario of the paper. (The bundled share is synthetic. A real index is
used where the environment variable ``OVERVIEW_TEST_DATA`` names a folder with one.)
"""

import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

DAY_S = 86_400.0
real = Path(os.environ.get("OVERVIEW_TEST_DATA", "")) / "stocks" / "sp500-2000.csv"
share = ov.load_timeline(real if real.is_file() else "made-up-share")
looks = {
    "the whole, in one twist of the hand": share,
    "its last year, in the same twist of the hand": share.window(
        max(0.0, share.duration_s - 365.0 * DAY_S), share.duration_s
    ),
    "its last six weeks, in the same twist of the hand": share.window(
        share.duration_s - 42.0 * DAY_S, share.duration_s
    ),
}

figure, grid = plt.subplots(len(looks), 1, figsize=(8, 6), layout="constrained")
for axes, (words, look) in zip(grid, looks.items(), strict=True):
    days = np.linspace(0.0, look.duration_s, 2000)
    axes.plot(days / DAY_S, look.intensity_at(days), color="#767676", linewidth=1.0)
    for event in look.events:
        axes.axvline(event.time_s / DAY_S, color="#0072B2", linewidth=0.5 * event.weight)
    axes.set(xlim=(0.0, look.duration_s / DAY_S), ylabel="price")
    axes.set_title(f"The price and its {len(look.events)} events: {words}", fontsize=10)
grid[-1].set(xlabel="days of the part shown")

# %%
# All its years, in three seconds:

ov.render(share, "stocks", "sweep:3")

# %%
# The last six weeks, in three seconds; a frame of the trace is a row of a DataFrame
# (``result.trace.to_dataframe()``), if that is what you work with:

result = ov.render(looks["its last six weeks, in the same twist of the hand"], "stocks", "sweep:3")
result
