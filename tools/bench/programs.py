"""The model in audio languages, where their compilers are installed: Faust and Csound."""

from __future__ import annotations

import ctypes
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from overview_dsp.errors import OverviewError
from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.bench import (
    DISK,
    RATE,
    SECONDS,
    SWEEP_S,
    VOICE,
    Contender,
    prepared,
    timed,
)
from overview_dsp.signal.engine.engine import Engine
from tools.bench.building import PEERS, MissingError, built
from tools.bench.c_rows import pointer, sweep_input
from tools.bench.disk import Disk
from tools.bench.plain_settings import SETTINGS, plain_settings

FAST = ("-Ofast", "-march=native")
BUILDS = {"scalar": (), "-vec -lv 1": ("-vec", "-lv", "1")}
SHORT_S = 0.01


class FaustPeer:
    """One process of voice.dsp, compiled."""

    def __init__(self, process: str, options: tuple[str, ...], engine: Engine) -> None:
        """`process` is a definition in voice.dsp, `options` are Faust's."""
        folder = Path(tempfile.mkdtemp(prefix="overview-faust-"))
        for name in ("voice.dsp", "faust_host.c", "tables.h"):
            shutil.copy(PEERS / name, folder / name)
        settings = plain_settings(engine)
        numbers = (f"{name} = {getattr(settings, name)!r};" for name in SETTINGS)
        (folder / "settings.lib").write_text("\n".join(numbers) + "\n", encoding="utf-8")
        command = ["faust", "-lang", "c", "-double", "-pn", process, *options]
        command += ["-I", str(folder), "voice.dsp", "-o", "generated.c"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise OverviewError(f"voice.dsp: faust failed: {done.stderr.strip()[:300]}")
        # the host includes Faust's output, so each has its own folder
        library = built(folder / "faust_host.c", (*FAST, f"-I{folder}"), folder)
        self._c = ctypes.CDLL(str(library))
        surface = engine.surface
        places = surface.position * CELLS
        below = np.searchsorted(places, np.arange(CELLS + 1), side="right").astype(np.float64)
        self._tables = (
            np.ascontiguousarray(surface.friction),
            below,
            surface.release[np.maximum(below.astype(np.int64) - 1, 0)],
        )
        self._c.peer_tables(*(pointer(table) for table in self._tables))

    def run(self, inputs: list[np.ndarray], outputs: list[np.ndarray]) -> None:
        """Process all frames of float64 arrays of one length."""
        ins = (ctypes.c_void_p * len(inputs))(*(array.ctypes.data for array in inputs))
        outs = (ctypes.c_void_p * len(outputs))(*(array.ctypes.data for array in outputs))
        self._c.peer_run(ins, outs, ctypes.c_int32(len(outputs[0])))


def faust() -> list[Contender]:
    """Return the full voice and the disk alone, in each of Faust's builds.

    Raises
    ------
    MissingError
        Faust, a C compiler or the source checkout is missing.
    """
    if not shutil.which("faust"):
        raise MissingError("Faust is not installed (apt-get install faust)")
    engine = prepared()
    disk = Disk.of(engine)
    frames = round(SECONDS * RATE)
    angles, touching = sweep_input(frames)
    touch = touching.astype(np.float64)
    output = [np.empty(frames), np.empty(frames)]
    torque = [np.empty(len(disk.angles))]
    rows = []
    for name, options in BUILDS.items():
        voice = FaustPeer("voice", options, engine)
        alone = FaustPeer("disk_alone", options, engine)

        def play(voice: FaustPeer = voice) -> float:
            return timed(SECONDS, lambda: voice.run([angles, touch], output))

        def turn(alone: FaustPeer = alone) -> float:
            return timed(SWEEP_S, lambda: alone.run([disk.angles], torque))

        rows += [
            Contender(VOICE, f"Faust, {name}, {FAST[0]}", play),
            Contender(DISK, f"Faust, {name}, {FAST[0]}", turn),
        ]
    return rows


def csound() -> list[Contender]:
    """Return the disk alone.

    Raises
    ------
    MissingError
        Csound or the source checkout is missing.
    """
    if not shutil.which("csound"):
        raise MissingError("Csound is not installed (apt-get install csound)")
    disk = Disk.of(prepared())
    folder = Path(tempfile.mkdtemp(prefix="overview-csound-"))
    np.savetxt(folder / "friction.txt", disk.friction)
    text = (PEERS / "disk.csd").read_text(encoding="utf-8")
    for name in ("inertia", "k1", "k2"):
        text = text.replace("{" + name + "}", repr(float(getattr(disk, name))))
    text = text.replace("{speed}", repr(np.pi / SWEEP_S))

    def spent(seconds: float) -> float:
        """Return the CPU time (s) of a process that makes `seconds` of sound."""
        score = folder / f"{seconds:g}.csd"
        score.write_text(text.replace("{seconds}", repr(seconds)), encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        done = subprocess.run(["csound", score.name], cwd=folder, capture_output=True)
        if done.returncode:
            raise OverviewError(f"disk.csd: csound ended with {done.returncode}")
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    def run() -> float:
        # the start is not part of the work
        return (SWEEP_S - SHORT_S) / (spent(SWEEP_S) - spent(SHORT_S))

    return [Contender(DISK, "Csound, ksmps = 1", run)]
