"""
The engine in your audio callback
=================================

For an engineer: ``ov.Engine`` has the interface of an audio plugin. Control events may come at
any rate, and blocks may have any size: the same events give the same bits.
``ov.live.OutputStream`` is the ready-made callback; this example is one of your own.
"""

import matplotlib.pyplot as plt
import numpy as np

import overview_dsp as ov

engine = ov.Engine(ov.load_preset("football"), ov.load_timeline("world-cup-final-2018"))
engine.prepare(sample_rate=48_000, max_block_size=512)
print(f"latency {engine.latency_samples} samples, tail {engine.tail_seconds:.1f} s")


def callback(out: np.ndarray) -> None:
    """Fill one block of the host, float32 (frames, channels), without allocating."""
    engine.process(out)


blocks = []
for number in range(400):
    if number % 5 == 0:  # a sensor at 75 Hz
        angle = np.pi * 0.5 * (1.0 - np.cos(2.0 * np.pi * number / 400.0))
        engine.control(theta2=angle, touching=True)
    if number == 200:
        engine.set("tactor.gain_db", -6.0)  # glides
    out = np.zeros((256, 2), dtype=np.float32)
    callback(out)
    blocks.append(out)
samples = np.concatenate(blocks)

# %%
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
time = np.arange(len(samples)) / engine.sample_rate
axes.plot(time, samples[:, 1], color="#D55E00", linewidth=0.3, label="tactor")
axes.plot(time, samples[:, 0], color="#0072B2", linewidth=0.5, label="click")
axes.set(xlabel="seconds", ylabel="full scale")
axes.legend(frameon=False, loc="upper right")
axes.set_title(
    "Click and tactor of a movement forwards and backwards; the tactor is 6 dB lower from 1.07 s"
)

# %%
# What the engine reports:

print(engine.meters)
strikes = engine.pop_strikes()
print(f"{len(strikes)} strikes, the strongest {20 * np.log10(strikes.level.max()):.1f} dB")

# %%
# The same hand through the offline renderer, for a player: a gesture is a list of control events.

offline = ov.render(engine.timeline, engine.preset, ov.sweep(1.07) + ov.sweep(1.07, 1.0, 0.0))
offline
