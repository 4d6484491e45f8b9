"""Compare the printed errors of exported clips to those on the players of MPEG and Meta.

MPEG's reference software (https://github.com/MPEGGroup/HapticReferenceSoftware) plays HJIF and
reads AHAP: after `cmake -S . -B build && cmake --build build`, its programs Synthesizer and Encoder
are the first two options. HJIF is played with phases of 0 and 90 degrees: the squares of the two
signals add to the square of the amplitude. AHAP has no public player. MPEG's reader plays
intensities as amplitudes times 0.6138 (events) or 0.792 (transients); their squares are compared.
Meta's renderer (https://github.com/facebook/meta-haptics-sdk) is a library. `--meta-player PATH` is
a program with the arguments MODE FILE OUTPUT that writes float32 amplitudes of a `.haptic` FILE
with the settings of the Quest. MODE is curve (ParametricHapticRenderer, amplitude curve at 2 kHz)
or android (render_waveform, each millisecond). Android's files are read by the rules of its API.

python tools/measure_players.py [--mpeg-synthesizer PATH] ... [TIMELINE ...]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import wave
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import overview_dsp as ov
from overview_dsp.arrays import FloatArray
from overview_dsp.offline.export.clip import clip_of, perceptual_error

MATCH, SHARE = "world-cup-final-2018", "made-up-share"
CLIPS = [
    *((MATCH, "football", f"sweep:{s}") for s in (1, 2, 3, 4, 5, 6)),
    *((MATCH, "football", f"tap:{place}") for place in (0.2, 0.5, 0.8)),
    *((MATCH, f"football-{kind}", "sweep:4") for kind in ("discreet", "stadium", "training")),
    *((SHARE, preset, f"sweep:{s}") for preset in ("series", "stocks", "weather") for s in (2, 5)),
    *(
        (SHARE, name, "sweep:3")
        for name in ("heart", "crowd", "gravel", "silk", "plain", "ratchet")
    ),
    (MATCH, "silk", "sweep:1"),
]
FORMATS = ov.export.formats()[:4]
META_MODES = {"Quest": "curve", "Android, steps of 10 ms": "android"}
RATE, META_RATE = 8000, 2000
EVENT_SCALE, TRANSIENT_SCALE, TRANSIENT_HZ = 0.6138, 0.792, 1000.0 / 11.0


def signal(synthesizer: str, file: Path, turn: float) -> FloatArray:
    """Return the sum of the channels of an HJIF document's first perception, phases turned."""
    document = json.loads(file.read_text())
    channels = document["perceptions"][0]["channels"]
    for effect in [one for each in channels for band in each["bands"] for one in band["effects"]]:
        effect["phase"] += turn
    turned, sound = file.with_suffix(".turned.hjif"), file.with_suffix(".wav")
    turned.write_text(json.dumps(document))
    subprocess.check_output([synthesizer, "-f", turned, "-o", sound, "-fs", str(RATE)])
    with wave.open(str(sound)) as read:
        samples = np.frombuffer(read.readframes(read.getnframes()), np.int16) / 32767.0
        return samples.reshape(-1, read.getnchannels())[:, : len(channels)].sum(axis=1)


def by_millisecond(energy: FloatArray, rate: int) -> FloatArray:
    """Return the RMS of the amplitude around each millisecond."""
    each = rate // 1000
    energy = np.pad(energy, (each // 2, each))
    return np.sqrt(energy[: len(energy) // each * each].reshape(-1, each).mean(axis=1))


def hjif(synthesizer: str, file: Path) -> FloatArray:
    """Return the amplitude of an HJIF document."""
    parts = [signal(synthesizer, file, turn) for turn in (0.0, np.pi / 2.0)]
    return by_millisecond(np.sum(np.square(parts), axis=0), RATE)


def ahap(synthesizer: str, encoder: str, files: tuple[Path, ...]) -> FloatArray:
    """Return the amplitude of the AHAP files of vibration and, if there are any, strikes."""
    for file in files:
        subprocess.check_output([encoder, "-f", file, "-o", file.with_suffix(".out")])
    parts = [(hjif(synthesizer, files[0].with_suffix(".out")) / EVENT_SCALE) ** 2]
    for strikes in files[1:]:
        # transients have no phase: the cosine is the derivative of the sine
        sine = signal(synthesizer, strikes.with_suffix(".out"), 0.0)
        cosine = np.gradient(sine) / np.sin(2.0 * np.pi * TRANSIENT_HZ / RATE)
        parts.append((by_millisecond(sine**2 + cosine**2, RATE) / TRANSIENT_SCALE) ** 2)
    padded = [np.pad(one, (0, max(map(len, parts)) - len(one))) for one in parts]
    return np.asarray(np.sqrt(np.sum(np.square(padded), axis=0)))


def meta(player: str, mode: str, file: Path) -> FloatArray:
    """Return the amplitude of a `.haptic` document."""
    subprocess.run([player, mode, file, file.with_suffix(".f32")], check=True)
    level = np.fromfile(file.with_suffix(".f32"), np.float32).astype(np.float64)
    return by_millisecond(level**2, META_RATE) if mode == "curve" else level


def android(file: Path) -> Iterator[FloatArray]:
    """Yield the amplitude of a waveform (steps), and of envelope effects (ramps from silence)."""
    document = json.loads(file.read_text())
    steps = document["waveform"]
    yield np.repeat(np.array(steps["amplitudes"]) / 255.0, steps["timings"])
    level: list[float] = []
    for effect in document["envelopeEffects"]:
        level += [0.0] * (effect["startMs"] - len(level))
        last = 0.0
        for point in effect["controlPoints"]:
            level += np.linspace(last, point["amplitude"], point["durationMs"], False).tolist()
            last = point["amplitude"]
    yield np.array(level)


def main() -> None:
    """Print a line for each clip and player, and the number of clips that differ."""
    parser = argparse.ArgumentParser()
    for name in ("--mpeg-synthesizer", "--mpeg-encoder", "--meta-player"):
        parser.add_argument(name)
    parser.add_argument("timelines", nargs="*", metavar="TIMELINE")
    options = parser.parse_args()
    mpeg, encoder, player = options.mpeg_synthesizer, options.mpeg_encoder, options.meta_player
    print("" if mpeg else __doc__)
    off: dict[str, list[bool]] = {}
    for timeline, preset, gesture in CLIPS + [(one, None, "sweep:4") for one in options.timelines]:
        clip = clip_of(result := ov.render(timeline, preset, gesture))
        with tempfile.TemporaryDirectory() as folder:
            done = {to: ov.export.export(result, to, f"{folder}/clip.{to}") for to in FORMATS}
            files = {to: one.files for to, one in done.items()}
            levels = dict(zip(done["android"].players, android(files["android"][0]), strict=True))
            if mpeg:
                levels["MPEG reference"] = hjif(mpeg, files["hjif"][0])
            if mpeg and encoder:
                levels["Core Haptics, strikes of 22 ms"] = ahap(mpeg, encoder, files["ahap"])
            for name, mode in META_MODES.items() if player else ():
                levels[name] = meta(player, mode, files["haptic"][0])
        printed = {name: error for one in done.values() for name, error in one.players.items()}
        for name, level in levels.items():
            real, ours = perceptual_error(level, clip.level, clip.transients), printed[name]
            db, points = real.median_db - ours.median_db, real.within_percent - ours.within_percent
            off.setdefault(name, []).append(abs(db) > 0.2 or abs(points) > 2.0)
            other = "" if ours.worst_event == real.worst_event else ", other worst event"
            print(
                f"{Path(timeline).name} {preset or ''} {gesture}, {name}: {ours.median_db:.2f} dB, "
                f"{ours.within_percent:.1f} %; played {db:+.2f} dB, {points:+.1f} points{other}"
            )
    for name, each in off.items():
        print(f"{name}: {sum(each)} of {len(each)} differ by more than 0.2 dB or 2 points")


if __name__ == "__main__":
    main()
