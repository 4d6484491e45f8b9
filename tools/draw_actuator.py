"""Plot drive and motion of a C-2 with and without overdrive into docs/pictures.

python tools/draw_actuator.py [FOLDER]

The signal is a tone at the resonance for 60 ms. Scipy computes the motion from the profile's
resonance, which is taken as measured.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import cont2discrete, lfilter

import overview_dsp as ov
from overview_dsp.offline.plots.style import BLUE, GREY, VERMILION, save_figure
from overview_dsp.signal.actuators.stage import ActuatorStage

FOLDER = Path(__file__).parent.parent / "docs" / "pictures"
RATE = 48_000
ON_S, END_S = 0.06, 0.12
LEVEL = 0.7  # of the tactor's full signal


def drawn(actuator: ov.Actuator) -> Figure:
    time = np.arange(round(END_S * RATE)) / RATE
    w0 = 2.0 * np.pi * actuator.resonance_hz
    tone = LEVEL * np.sin(w0 * time) * (time < ON_S)
    b, a, _ = cont2discrete(([w0 * w0], [1.0, w0 / actuator.q, w0 * w0]), 1.0 / RATE)
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    given, moved = figure.subplots(2, 1, sharex=True)
    for one, words, colour in (
        (actuator.unshaped, "as it is", GREY),
        (actuator, "overdriven and braked", BLUE),
    ):
        samples = np.stack([np.zeros_like(tone), tone], axis=1).astype(np.float32)
        ActuatorStage(one, RATE).process(samples, 1)
        place = lfilter(b.ravel(), a, samples[:, 1])
        motion = np.hypot(place, np.gradient(place) * RATE / w0)
        given.plot(time * 1e3, samples[:, 1] * one.full_scale, color=colour, linewidth=0.9)
        moved.plot(time * 1e3, motion / (LEVEL * one.nominal * one.q), color=colour, label=words)
    unit = actuator.values["drive.unit"]
    for side in (-1.0, 1.0):
        given.axhline(side * actuator.number("drive.peak"), color=VERMILION, linewidth=0.7)
    given.set_ylabel(f"drive, {unit}")
    moved.set_ylabel("motion, of the level meant")
    moved.set_xlabel("ms")
    moved.set_ylim(0.0, 1.2)
    moved.legend(frameon=False)
    for axes in (given, moved):
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_xlim(0.0, END_S * 1e3)
    title = f"{actuator.title}: {actuator.resonance_hz:g} Hz, on for {ON_S * 1e3:g} ms"
    given.set_title(title, loc="left", fontsize=10)
    return figure


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    c2 = ov.load_actuator("c2")
    known = {"resonance.tolerance_percent": 0.2, "shaping.overdrive": 4.0}
    measured = replace(c2, values={**c2.values, **known})
    for path in save_figure(drawn(measured), folder / "actuator"):
        if path.suffix != ".png":
            path.unlink()


if __name__ == "__main__":
    main()
