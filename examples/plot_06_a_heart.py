"""
A heart
=======

For a clinician or the curious: heart rate as the roughness, beats out of turn as hard edges, a
missed beat as a thud. This heart is made up, as a timeline built in Python; WFDB records and ECG
tables load with ``ov.load_timeline`` (``pip install '.[ecg]'``).
"""

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

random = np.random.default_rng(3)
beats, kinds, now = [], [], 0.5
while now < 119.0:
    rate = 62.0 + 18.0 * np.exp(-(((now - 70.0) / 20.0) ** 2))  # an effort in the second minute
    interval = 60.0 / rate * random.normal(1.0, 0.02)
    kind = random.choice(["beat", "premature_ventricular", "missed_beat"], p=[0.95, 0.03, 0.02])
    now += interval * {"beat": 1.0, "premature_ventricular": 0.7, "missed_beat": 1.9}[kind]
    beats.append(now)
    kinds.append(str(kind))

times = np.array(beats[1:])
heart = ov.Timeline(
    "A made-up heart, two minutes",
    120.5,
    tuple(ov.Event(t, k) for t, k in zip(beats, kinds, strict=True) if k != "beat"),
    ov.Intensity(times, 60.0 / np.diff(beats), "beats/min"),
)
print(heart.kinds())

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(times, heart.intensity.value, color="#D55E00", linewidth=0.8)
axes.set(xlabel="seconds", ylabel="beats a minute")
axes.set_title(
    "The rate rises with an effort in the second minute; spikes are early and late beats"
)

# %%
result = ov.render(heart, ov.load_preset("heart"), ov.sweep(6.0))
result
