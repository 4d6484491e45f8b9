"""
A series from a CSV file
========================

For an analyst: a table of times and values (a file or a DataFrame) becomes a timeline. An option
chooses what becomes friction. Gaps stay gaps; extremes, turning points and large moves become
events.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

# a year of temperatures, with a sensor that failed for a month in autumn
days = np.arange("2023-01-01", "2024-01-01", dtype="datetime64[D]")
season = 12.0 - 10.0 * np.cos(2.0 * np.pi * (np.arange(365) - 15.0) / 365.0)
celsius = season + np.random.default_rng(7).normal(0.0, 2.0, 365)
rows = [f"{days[i]},{celsius[i]:.1f}\n" for i in range(365) if not 270 < i < 300]

with tempfile.TemporaryDirectory() as folder:
    table = Path(folder) / "station.csv"
    table.write_text("date,celsius\n" + "".join(rows))
    level = ov.load_timeline(table, value="celsius")
    activity = ov.load_timeline(table, value="celsius", map="activity")

print(*level.notes, sep="\n")
print(level.kinds())

# %%
figure, grid = plt.subplots(2, 1, figsize=(8, 4), sharex=True, layout="constrained")
day = np.linspace(0.0, 365.0, 1000)
grid[0].plot(day, level.normalised_intensity_at(day * 86400.0 * 364.0 / 365.0), color="#0072B2")
grid[0].set_title("Level becomes friction: summer is rough; the gap of October is not the level 0")
grid[1].plot(day, activity.normalised_intensity_at(day * 86400.0 * 364.0 / 365.0), color="#D55E00")
grid[1].set_title("Activity becomes friction: restless weeks are rough, whatever their level")
grid[1].set(xlabel="day of the year")

# %%
# The level, in a sweep of three seconds with the preset ``weather``:

result = ov.render(level, ov.load_preset("weather"), ov.sweep(3.0))
result
