"""Measurement of a board that plays alone: strikes and levels against `render`, memory, time.

    python tools/measure_board.py                # on this machine, and on a Cortex-M7 in qemu
    python tools/measure_board.py --only here --random 5    # and 15 random timelines

`overview export --to board` writes the library and its data; `board_rig.c` plays gestures in it. A
match, a series and a heartbeat are swept in 4 s, tapped, and swept by an arm. Every strike counts:
its event, its order, and the levels of both channels in the 60 ms after it, each measured from its
own strike on. Levels below -70 dBFS in `render` are not compared, as they are not heard or felt.

Memory is that of the compiler. The instructions are counted by qemu, whose time isn't that of a
board: a Cortex-M7 does up to two in a cycle, and waits for its flash. Debian has no compiler for an
ESP32-S3. The code printed for it is that of an ESP8266 (gcc-xtensa-lx106), which has the same
instructions, but none for floating point. The exit code is the number of strikes and levels that
differ.
"""

from __future__ import annotations

import argparse
import functools
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np

import overview_dsp as ov
from overview_dsp.measure.synthetic_data import random_heart, random_match, random_weather

HERE = Path(__file__).resolve().parent
RIG = HERE / "board_rig.c"
LINKED = HERE.parent / "tests" / "firmware" / "arm.ld"
RATE = 44_100
AFTER_S = 0.06
FAINT = 10.0 ** (-70.0 / 20.0)
LEVEL_DB = 1.0
BUDGETS = {"Teensy 4": 600e6 / RATE, "ESP32-S3": 240e6 / RATE}  # cycles of a sample
M7 = ("-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-O2")
MACHINES = ("here", "cortex-m7")

TIMELINES = {
    "match": (lambda: ov.load_timeline("world-cup-final-2018"), "football"),
    "series": (lambda: random_weather(1), "weather"),
    "heartbeat": (lambda: random_heart(1), "heart"),
}
GESTURES = {
    "sweep": lambda: ov.sweep(4.0),
    "tap": lambda: ov.tap(0.8),
    "arm": lambda: ov.arm(3.0),
}


@dataclass
class Played:
    """Strikes (sample, event, level), samples and counted instructions of a board."""

    strikes: np.ndarray
    samples: np.ndarray
    lost: int
    mean: float  # instructions a sample
    highest: float


@dataclass
class Difference:
    """Strikes in `render`, those that differ, and levels of both channels, dB."""

    strikes: int
    failed: int  # missing, added or lost
    late_ms: float  # largest difference of a strike's time
    events_db: tuple[float, float]  # largest differences of click and tactor
    compared: tuple[int, int]
    whole_db: tuple[float, float]

    @property
    def failures(self) -> int:
        """Number of strikes and levels beyond the limits."""
        return self.failed + sum(abs(db) > LEVEL_DB for db in (*self.events_db, *self.whole_db))


def missing(machine: str) -> str:
    """Return what must be installed to play on a machine, or nothing."""
    if machine == "here":
        return "" if shutil.which("gcc") else "gcc"
    names = {
        "arm-none-eabi-gcc": "gcc-arm-none-eabi libnewlib-arm-none-eabi",
        "qemu-system-arm": "qemu-system-arm",
    }
    return " ".join(names[name] for name in names if not shutil.which(name))


def export(timeline, preset, folder: Path) -> Path:
    """Write the sketches; return the folder of one."""
    ov.export.export_board(timeline, preset, folder)
    return folder / "teensy4"


def build(machine: str, source: Path, *options: str) -> Path:
    """Compile the rig with an export for a machine."""
    program = source / f"rig-{machine}"
    compiler = ["gcc", "-O2", "-std=c99"]
    if machine != "here":
        compiler = ["arm-none-eabi-gcc", *M7, "--specs=rdimon.specs", "-nostartfiles"]
        compiler += ["-T", str(LINKED)]
    command = [*compiler, *options, f"-I{source}", str(RIG), "-o", str(program)]
    subprocess.run(command, check=True)
    return program


def play(machine: str, program: Path, gesture, frames: int) -> Played:
    """Play a gesture in the rig."""
    events = np.zeros(len(gesture.theta2), [("at", "<i4"), ("theta2", "<f4"), ("touching", "<i4")])
    events["at"] = gesture.stamps(RATE)
    events["theta2"], events["touching"] = gesture.theta2, gesture.touching
    folder = program.parent
    (folder / "gesture").write_bytes(np.int32(frames).tobytes() + events.tobytes())
    command = [str(program)]
    if machine != "here":
        command = [
            "qemu-system-arm", "-M", "mps2-an500", "-nographic", "-monitor", "none",
            "-serial", "none", "-icount", "shift=0",
            "-semihosting-config", "enable=on,target=native", "-kernel", str(program),
        ]  # fmt: skip
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    said = done.stdout + done.stderr
    strikes = re.findall(r"^strike (\d+) (-?\d+) ([\d.]+)\s*$", said, re.M)
    lost, mean, highest, _ = re.search(
        r"^end (\d+) ([\d.]+) ([\d.]+) (\d+)\s*$", said, re.M
    ).groups()
    return Played(
        np.array(strikes, float).reshape(-1, 3),
        np.fromfile(folder / "samples", np.float32).reshape(-1, 2),
        int(lost), float(mean), float(highest),
    )  # fmt: skip


def level(samples: np.ndarray) -> np.ndarray:
    """Return the RMS of both channels."""
    return np.sqrt(np.mean(samples.astype(float) ** 2, axis=0))


def compare(played: Played, result) -> Difference:
    """Compare what a board played with a render."""
    strikes = result.strikes
    given, expected = played.strikes[:, 1].astype(int).tolist(), strikes.event.tolist()
    blocks = SequenceMatcher(None, given, expected, autojunk=False).get_matching_blocks()
    ours = np.concatenate([np.arange(one.a, one.a + one.size) for one in blocks])
    theirs = np.concatenate([np.arange(one.b, one.b + one.size) for one in blocks])
    failed = len(given) + len(expected) - 2 * len(ours) + played.lost
    struck, expected_s = played.strikes[ours, 0], strikes.time_s[theirs]
    late = struck / RATE - expected_s
    windows = [
        [level(samples[round(at) : round(at + AFTER_S * RATE)]) for at in (starts or [0.0])]
        for samples, starts in (
            (played.samples, struck.tolist()),
            (result.samples, (expected_s * RATE).tolist()),
        )
    ]
    there, here = np.array(windows)
    heard = here > FAINT
    off = np.abs(20.0 * np.log10(np.maximum(there, 1e-9) / np.maximum(here, 1e-9)))
    worst = np.where(heard, off, 0.0).max(axis=0)
    whole = 20.0 * np.log10(level(played.samples) / level(result.samples))
    return Difference(
        len(strikes.event), failed, float(1e3 * np.abs(late).max(initial=0.0)),
        tuple(map(float, worst)), tuple(map(int, heard.sum(axis=0))), tuple(map(float, whole)),
    )  # fmt: skip


def sections(compiler: str, options: tuple[str, ...], source: Path, name: str) -> dict[str, int]:
    """Return bytes of code, constants and RAM of the library with an export."""
    text = '#include "overview_board.h"\n#include "timeline.h"\nOverviewBoard voice;\n'
    text += "void begin(void) { overview_board_init(&voice, &OVERVIEW_TIMELINE); }\n"
    text += "void set(float x, int t) { overview_board_set(&voice, x, t); }\n"
    text += "void play(float *a, float *b, int n) { overview_board_process(&voice, a, b, n); }\n"
    if name == "knob":
        text = '#include "surface.h"\n' + text.split("OverviewBoard", maxsplit=1)[0]
        text += "Knob knob;\nvoid begin(float x) { knob_begin(&knob, x);\n"
        text += "  overview_board_knob(&knob, OVERVIEW_KNOB, sizeof OVERVIEW_KNOB); }\n"
        text += "float step(float x) { return knob_step(&knob, x); }\n"
    made = source / f"{name}.c"
    made.write_text(text)
    built = made.with_suffix(".o")
    subprocess.run(
        [f"{compiler}-gcc", *options, f"-I{source}", "-w", "-c", str(made), "-o", str(built)],
        check=True,
    )
    listed = subprocess.run(
        [f"{compiler}-size", "-A", str(built)], capture_output=True, text=True, check=True
    ).stdout
    found = {"code": 0, "constants": 0, "RAM": 0}
    for section, size in re.findall(r"^(\.\S+)\s+(\d+)\s+\d+\s*$", listed, re.M):
        for kind, start in (("code", ".text"), ("constants", ".rodata"), ("RAM", ".bss"),
                            ("RAM", ".data"), ("code", ".literal")):  # fmt: skip
            if section.startswith(start):
                found[kind] += int(size)
    return found


def print_memory(source: Path) -> None:
    """Print RAM and flash for both boards."""
    boards = {
        "Teensy 4 (Cortex-M7)": ("arm-none-eabi", M7),
        "ESP8266, for ESP32-S3": ("xtensa-lx106-elf", ("-O2", "-mlongcalls")),
    }
    print(f"\n{'bytes, match':<30}{'code':>9}{'constants':>11}{'flash':>9}{'RAM':>8}")
    for board, (compiler, options) in boards.items():
        if not shutil.which(f"{compiler}-gcc"):
            print(f"{board:<30} needs gcc-{compiler.removesuffix('-elf')}")
            continue
        for name in ("voice", "knob"):
            s = sections(compiler, options, source, name)
            flash = s["code"] + s["constants"]
            row = f"{board}, {name}"
            print(f"{row:<30}{s['code']:>9}{s['constants']:>11}{flash:>9}{s['RAM']:>8}")


def random_timelines(count: int) -> Iterator[tuple[str, tuple[Callable, str]]]:
    """Yield names, functions and presets of random timelines, `count` of each sort."""
    sorts = {"match": random_match, "series": random_weather, "heartbeat": random_heart}
    for seed in range(2, 2 + count):
        for name, make in sorts.items():
            yield f"{name} {seed}", (functools.partial(make, seed), TIMELINES[name][1])


def main() -> int:
    """Print the tables; return the number of failures."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--only", choices=MACHINES)
    arguments.add_argument("--random", type=int, default=0, metavar="N")
    given = arguments.parse_args()
    only, failures, strikes = given.only, 0, 0
    machines = [machine for machine in MACHINES if only in (None, machine)]
    print(
        f"{'machine':<10}{'timeline':<13}{'gesture':<8}{'strikes':>8}{'wrong':>6}{'ms':>6}"
        f"{'click dB':>10}{'tactor dB':>10}{'whole dB':>16}{'instructions':>16}"
    )
    with tempfile.TemporaryDirectory() as made:
        for name, (load, preset) in [*TIMELINES.items(), *random_timelines(given.random)]:
            timeline, chosen = load(), ov.load_preset(preset)
            source = export(timeline, chosen, Path(made, name))
            for machine in machines:
                if needs := missing(machine):
                    print(f"{machine:<10}{name:<13}needs {needs}")
                    continue
                program = build(machine, source)
                for gesture, make in GESTURES.items():
                    result = ov.render(timeline, chosen, make(), RATE)
                    played = play(machine, program, make(), len(result.samples))
                    d = compare(played, result)
                    failures += d.failures
                    strikes += d.strikes
                    counted = f"{played.mean:.0f}, {played.highest:.0f}" if played.mean else ""
                    whole = f"{d.whole_db[0]:+.3f}, {d.whole_db[1]:+.3f}"
                    print(
                        f"{machine:<10}{name:<13}{gesture:<8}{d.strikes:>8}{d.failed:>6}"
                        f"{d.late_ms:>6.2f}{d.events_db[0]:>10.3f}{d.events_db[1]:>10.3f}"
                        f"{whole:>16}{counted:>16}"
                    )
        print_memory(Path(made, "match", "teensy4"))
    cycles = ", ".join(f"{board} {budget:.0f}" for board, budget in BUDGETS.items())
    print(f"\ncycles of a sample at {RATE} Hz: {cycles}; {strikes} strikes, failures: {failures}")
    return failures


if __name__ == "__main__":
    sys.exit(main())
