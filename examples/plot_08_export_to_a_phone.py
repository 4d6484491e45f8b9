"""
Export to a phone
=================

For an app developer: a rendered gesture becomes a clip that the haptics of a phone can play. Each
export reports its error against the render.
"""

import json
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import overview_dsp as ov

match, preset = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
result = ov.render(match, preset, ov.tap(0.8, hold_seconds=0.5))

with tempfile.TemporaryDirectory() as folder:
    for format in ("ahap", "haptic", "hjif"):
        done = ov.export.export(result, format, Path(folder) / f"tap.{format}")
        size = sum(path.stat().st_size for path in done.files)
        print(
            f"{format:7} {len(done.files)} file(s), {size / 1e3:.0f} kB, {done.points} points, "
            f"{done.transients} strikes, {done.error.median_db:.1f} dB from what was rendered"
        )
    clip = json.loads((Path(folder) / "tap.ahap").read_text())

# %%
# Apple's AHAP holds the vibration as a curve of intensity:

points = [
    (part["ParameterCurve"]["Time"] + point["Time"], point["ParameterValue"])
    for part in clip["Pattern"]
    if part.get("ParameterCurve", {}).get("ParameterID") == "HapticIntensityControl"
    for point in part["ParameterCurve"]["ParameterCurveControlPoints"]
]
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(
    result.trace.time, result.trace.envelope, color="#767676", linewidth=0.8, label="rendered"
)
axes.plot(*zip(*points, strict=True), color="#D55E00", linewidth=0.8, label="AHAP")
axes.set(xlabel="seconds", ylabel="intensity")
axes.legend(frameon=False)
axes.set_title("The exported curve of the tap beside the rendered envelope")

# %%
result
