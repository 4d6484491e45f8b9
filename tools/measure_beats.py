"""Compare detectors of heartbeats on real records with noise added; prints the tables of the docs.

OVERVIEW_TEST_DATA=FOLDER python tools/measure_beats.py

Rows: ours, and of NeuroKit2, wfdb and SleepECG what is installed (`pip install neurokit2 wfdb
sleepecg`; wfdb reads record 100). A beat is found if it is named within 150 ms (ANSI/AAMI EC57).
"""

from __future__ import annotations

import importlib
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parent.parent))

from overview_dsp.data.analysis.heart_signal import Samples
from overview_dsp.data.analysis.heartbeats import find_beats
from overview_dsp.data.analysis.rhythm import MISSED, NORMAL, beat_events
from overview_dsp.data.readers.cardiac.build import beats_of
from tests.data.readers.make_cardiac import agreement, with_ectopic_beats
from tests.data.readers.make_noise import RealNoise, unit, usual_height, with_noise

RATE = 360.0
SNRS = (None, 12.0, 6.0, 0.0)
SEEDS = (101, 202, 303)
REAL_SNRS = (24.0, 12.0, 9.0, 6.0, 4.0, 2.0, 0.0)
OFFSETS = (0, 3000, 7000)
NEUROKIT = (
    "rodrigues2021",
    "neurokit",
    "pantompkins1985",
    "hamilton2002",
    "elgendi2010",
    "khamis2016",
)

Signal = NDArray[np.float64]
Detector = Callable[[Signal], Signal]


def records(folder: Path) -> Iterator[tuple[str, Signal, NDArray[np.int64]]]:
    """Name, samples and annotated beats: five minutes of 100 (either lead), two of 118e24."""
    told = np.loadtxt(folder / "118e24_ann.csv").astype(np.int64)
    yield "118e24", np.loadtxt(folder / "118e24.csv"), told
    wfdb = importlib.import_module("wfdb")
    record = wfdb.rdrecord(str(folder / "100"))
    said = wfdb.rdann(str(folder / "100"), "atr")
    beats = said.sample[np.isin(said.symbol, ["N", "A", "V"])]
    end = round(300 * RATE)
    for lead, name in enumerate(record.sig_name):
        yield f"100 {name}", record.p_signal[:end, lead], beats[beats < end]


def ours(samples: Signal) -> Signal:
    return find_beats(Samples("x", RATE, samples.astype(np.float32)), "ECG", gaps=False).beats


def outside_gaps(samples: Signal) -> tuple[Signal, Signal]:
    """Return our beats outside of the gaps, and which samples lie outside."""
    found = find_beats(Samples("x", RATE, samples.astype(np.float32)))
    clear = np.ones(len(samples), np.bool_)
    for first, end in found.noisy:
        clear[first:end] = False
    return found.beats, clear


def pooled(pairs: list[tuple[Signal, Signal]]) -> str:
    """Return the pooled recall / precision of pairs of found and annotated beats."""
    found, told = (sum(len(pair[i]) for pair in pairs) for i in (0, 1))
    right = sum(
        agreement(beats / RATE, true / RATE, 0.15)[0] * len(true)
        for beats, true in pairs
        if len(beats) and len(true)
    )
    return f"{right / told:.3f} / {right / found:.3f}" if told and found else "-"


def synthetic(samples: Signal, beats: Signal, snr_db: float, band: tuple[float, float]) -> Signal:
    """Add filtered noise at the level of the real one."""
    from scipy.signal import butter, sosfilt

    sections = butter(2, band, "bandpass", fs=RATE, output="sos")
    noise = unit(sosfilt(sections, np.random.default_rng(1).normal(size=len(samples))))
    height = usual_height(samples, beats) / np.sqrt(8.0)
    return np.asarray(samples + noise * height * 10.0 ** (-snr_db / 20.0))


def print_real_noise(folder: Path) -> None:
    """Print recall and precision outside and inside of the gaps, and of the other detectors."""
    noise, sets = RealNoise(folder.parent), list(records(folder))
    print(f"\n| noise | {' | '.join(f'{snr:g} dB' for snr in REAL_SNRS)} |")
    print("|---" * (len(REAL_SNRS) + 1) + "|")
    makers: dict[str, Callable[[Signal, Signal, float], list[Signal]]] = {
        "electrode": lambda x, beats, snr: [noise.added(x, beats, snr, at) for at in OFFSETS],
        "muscle (synthetic)": lambda x, beats, snr: [synthetic(x, beats, snr, (15.0, 100.0))],
        "baseline (synthetic)": lambda x, beats, snr: [synthetic(x, beats, snr, (0.05, 0.7))],
    }
    for name, make in makers.items():
        rows: dict[str, list[str]] = {"outside the gaps": [], "inside": [], "gaps, %": []}
        for snr in REAL_SNRS:
            inside, outside, gaps = [], [], []
            for _, samples, beats in sets:
                for noisy in make(samples, beats, snr):
                    found, clear = outside_gaps(noisy)
                    outside.append((found, beats[clear[beats]]))
                    every = ours(noisy)
                    inside.append((every[~clear[every]], beats[~clear[beats]]))
                    gaps.append(100.0 * (1.0 - clear.mean()))
            rows["outside the gaps"].append(pooled(outside))
            rows["inside"].append(pooled(inside))
            rows["gaps, %"].append(f"{np.mean(gaps):.0f}")
        for row, cells in rows.items():
            print(f"| {name}, {row} | {' | '.join(cells)} |", flush=True)
    for name, detect in detectors():
        if name != "overView DSP":
            cells = []
            for snr in REAL_SNRS:
                pairs = [
                    (np.sort(detect(noisy)), beats)
                    for _, samples, beats in sets
                    for noisy in makers["electrode"](samples, beats, snr)
                ]
                cells.append(pooled(pairs))
            print(f"| electrode, {name} | {' | '.join(cells)} |", flush=True)


def print_ectopic() -> None:
    """Print how many ectopic beats are named."""
    print("\n| synthetic | clean | 18 dB | 12 dB |\n|---|---|---|---|")
    for ventricular in (True, False):
        for every in (2, 9):
            samples, beats, early = with_ectopic_beats(every, ventricular)
            cells = []
            for snr in (None, 18.0, 12.0):
                noisy = samples
                if snr is not None:
                    noisy = with_noise(samples, 250.0, np.rint(beats * 250).astype(int), snr, 3)
                found = find_beats(Samples("x", 250.0, noisy.astype(np.float32)))
                events, _ = beat_events(beats_of(found, 250.0), ())
                named = [event.time_s for event in events if event.kind not in (NORMAL, MISSED)]
                hit = agreement(np.array(named), early, 0.1)[0] * len(early)
                cells.append(f"{hit:.0f} of {len(early)} ({len(named) - hit:.0f} others)")
            kind = "ventricular" if ventricular else "atrial"
            print(f"| {kind}, one beat of {every} | {' | '.join(cells)} |")


def detectors() -> Iterator[tuple[str, Detector]]:
    yield "overView DSP", ours
    if (nk := installed("neurokit2")) is not None:
        for method in NEUROKIT:
            yield f"NeuroKit2 {method}", of_neurokit(nk, method)
    if (processing := installed("wfdb.processing")) is not None:

        def xqrs(samples: Signal) -> Signal:
            search = processing.XQRS(sig=samples, fs=RATE)
            search.detect(verbose=False)
            return np.asarray(search.qrs_inds)

        yield "wfdb xqrs", xqrs
    if (sleepecg := installed("sleepecg")) is not None:
        yield "SleepECG", lambda samples: sleepecg.detect_heartbeats(samples, RATE)


def of_neurokit(nk: Any, method: str) -> Detector:
    def detect(samples: Signal) -> Signal:
        try:
            cleaned = nk.ecg_clean(samples, sampling_rate=RATE, method=method)
        except ValueError:  # a detector without a filter of its own
            cleaned = nk.ecg_clean(samples, sampling_rate=RATE)
        return np.asarray(nk.ecg_findpeaks(cleaned, RATE, method=method)["ECG_R_Peaks"], float)

    return detect


def installed(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"({name} isn't installed)", file=sys.stderr)
        return None


def noisy_records(folder: Path, snr_db: float | None) -> Iterator[tuple[Signal, Signal]]:
    for number, (_, samples, beats) in enumerate(records(folder)):
        for seed in SEEDS if snr_db is not None else SEEDS[:1]:
            noisy = samples
            if snr_db is not None:
                noisy = with_noise(samples, RATE, beats, snr_db, seed + number)
            yield noisy, beats


def main() -> None:
    warnings.simplefilter("ignore")
    folder = Path(os.environ["OVERVIEW_TEST_DATA"]) / "ecg"
    data = {snr: list(noisy_records(folder, snr)) for snr in SNRS}
    print("| detector | clean | 12 dB | 6 dB | 0 dB | CPU ms a minute |\n|---|---|---|---|---|---|")
    for name, detect in detectors():
        begun, minutes, cells = time.process_time(), 0.0, []
        for snr in SNRS:
            scores = []
            for samples, beats in data[snr]:
                found = np.sort(detect(samples))
                sensitivity, precision = (0.0, 1.0)
                if len(found):
                    sensitivity, precision = agreement(found / RATE, beats / RATE, 0.15)
                scores.append((sensitivity, precision))
                minutes += len(samples) / RATE / 60.0
            cells.append("{:.3f} / {:.3f}".format(*np.mean(scores, axis=0)))
        spent = 1000.0 * (time.process_time() - begun) / minutes
        print(f"| {name} | {' | '.join(cells)} | {spent:.0f} |", flush=True)
    cells = []
    for snr in SNRS:
        scores = []
        for samples, beats in data[snr]:
            found, clear = outside_gaps(samples)
            told = beats[clear[beats]]
            both = (
                agreement(found / RATE, told / RATE, 0.15) if len(told) and len(found) else (1, 1)
            )
            scores.append((*both, 100.0 * clear.mean()))
        cells.append("{:.3f} / {:.3f} ({:.0f} %)".format(*np.mean(scores, axis=0)))
    print(f"| outside of our gaps (how much that is) | {' | '.join(cells)} | |")
    print_real_noise(folder)
    print_ectopic()


if __name__ == "__main__":
    main()
