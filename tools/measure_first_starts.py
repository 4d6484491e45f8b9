"""Measure the first start of each command, with nothing compiled or cached.

python tools/measure_first_starts.py [--json] [COMMAND ...]

Each command runs in a process, a folder and caches of its own. The figures are processor time: of
its imports, from there to the first sound (for `serve`, to the first page with sound), and to the
end of those that end by themselves.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
MATCH = "world-cup-final-2018"
JOBS = f"""
out = "study"
timelines = ["{MATCH}"]
gestures = ["sweep:1"]
seeds = 8
tail = "none"
"""
LOOK_EVERY_S = 0.01
LONGEST_S = 600.0
TIMES = "times.json"
FIRST_SOUND = "first-sound"

# of each: its arguments, the file that its first sound is in, whether it ends by itself
COMMANDS: dict[str, tuple[list[str], str, bool]] = {
    "demo": (["demo"], "overview-demo/*.wav", True),
    "play": (
        ["play", MATCH, "--device", "none", "--replay", "sweep:1", "--screen", "json"],
        FIRST_SOUND,
        False,
    ),
    "batch": (["batch", "jobs.toml"], "study/sounds/**/*.wav", True),
    "serve": (["serve", MATCH, "--port", "0", "--json"], FIRST_SOUND, False),
}


@dataclass(frozen=True)
class Start:
    """Processor time, s; `whole_s` is None for commands that run until they are stopped."""

    command: str
    imports_s: float
    first_sound_s: float
    whole_s: float | None


class Imports:
    """Processor time of all imports, in any thread."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._local = threading.local()
        bootstrap: Any = importlib._bootstrap  # type: ignore[attr-defined]
        self._found = bootstrap._find_and_load
        bootstrap._find_and_load = self._timed

    def _timed(self, *arguments: Any) -> Any:
        if getattr(self._local, "inside", False):
            return self._found(*arguments)
        self._local.inside, began = True, time.thread_time()
        try:
            return self._found(*arguments)
        finally:
            self._local.inside = False
            self.seconds += time.thread_time() - began


def run(name: str) -> None:
    """Run the command in this process and folder, and write its times to `TIMES`."""
    imports = Imports()
    arguments, first, ends = COMMANDS[name]
    times: dict[str, float] = {}

    def since_imports() -> float:
        """Return the processor time of this process and its ended children, s."""
        ended = os.times()
        return time.process_time() + ended[2] + ended[3] - imports.seconds

    def watch() -> None:
        while not any(Path().glob(first)):
            time.sleep(LOOK_EVERY_S)
        times.update(imports_s=imports.seconds, first_sound_s=since_imports())
        if not ends:
            os.kill(os.getpid(), signal.SIGINT)

    if name == "play":
        mark_first_block()
    watching = threading.Thread(target=watch, daemon=True)
    watching.start()
    sys.argv = ["overview", *arguments]
    try:
        from overview_dsp.cli import main

        main()
    finally:
        watching.join(1.0)
        if ends:
            times["whole_s"] = since_imports()
        Path(TIMES).write_text(json.dumps(times))


def mark_first_block() -> None:
    """Have the first block that an output without a device plays write `FIRST_SOUND`."""
    from overview_dsp.live.output import stream

    play: Callable[..., bool] = stream.run_block

    def marked(engine: Any, out: Any) -> bool:
        over = play(engine, out)
        if len(out):
            stream.run_block = play
            Path(FIRST_SOUND).touch()
        return over

    stream.run_block = marked


def hear_served(address: str) -> None:
    """Get a page's sound from a server, as its script does."""
    origin, _, token = address.partition("/#")
    asked = urllib.request.Request(f"{origin}/sound/0.packed")
    asked.add_header("Authorization", f"Bearer {token.partition('=')[2] or token}")
    with urllib.request.urlopen(asked, timeout=LONGEST_S) as answer:
        answer.read()


def measured(name: str) -> Start:
    """A command's first start, in a process of its own."""
    with tempfile.TemporaryDirectory(prefix="overview-first-") as folder:
        (Path(folder) / "jobs.toml").write_text(JOBS)
        kept = {"HOME": folder, "XDG_CACHE_HOME": f"{folder}/cache", "XDG_STATE_HOME": folder}
        environment = {**os.environ, **kept, "NUMBA_CACHE_DIR": f"{folder}/numba"}
        search = [str(ROOT), os.environ.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, search))
        environment.pop("OVERVIEW_JIT", None)
        process = subprocess.Popen(
            [sys.executable, __file__, "--run", name],
            cwd=folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        assert process.stdout is not None
        if name == "serve":
            hear_served(json.loads(process.stdout.readline())["address"])
            (Path(folder) / FIRST_SOUND).touch()
        _, complaint = process.communicate(timeout=LONGEST_S)
        times = json.loads((Path(folder) / TIMES).read_text())
        if "first_sound_s" not in times:
            sys.exit(f"{name}: no sound: {complaint.strip()[-500:]}")
        return Start(name, times["imports_s"], times["first_sound_s"], times.get("whole_s"))


def report(commands: list[str]) -> dict[str, Any]:
    """Return the object that `--json` prints."""
    from datetime import date

    sys.path.insert(0, str(ROOT))
    from overview_dsp.measure.bench import this_machine

    starts = [asdict(measured(name)) for name in commands]
    return {"machine": this_machine(), "date": date.today().isoformat(), "first_starts": starts}


def lines(starts: list[Start]) -> list[str]:
    found = [f"{'CPU s':<8}{'imports':>9}{'to the first sound':>20}{'to the end':>12}"]
    for one in starts:
        whole = "-" if one.whole_s is None else f"{one.whole_s:.2f}"
        found.append(f"{one.command:<8}{one.imports_s:>9.2f}{one.first_sound_s:>20.2f}{whole:>12}")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("commands", nargs="*", metavar="COMMAND", help=", ".join(COMMANDS))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--run", choices=COMMANDS, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.run:
        run(asked.run)
    if unknown := set(asked.commands) - set(COMMANDS):
        sys.exit(f"no such command: {', '.join(unknown)}; known: {', '.join(COMMANDS)}")
    times = report(asked.commands or list(COMMANDS))
    if asked.json:
        print(json.dumps(times))
    else:
        print(f"{times['date']}, {times['machine']}")
        print("\n".join(lines([Start(**one) for one in times["first_starts"]])))
