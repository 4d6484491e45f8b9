"""What the first start of a command costs where nothing is compiled or kept yet.

python tools/measure_first_starts.py [--json] [COMMAND ...]

Each command runs in a process, a folder and caches of its own. Told is processor time: of its
imports, from there to the first sound (for `serve`, to the first page that has got its sound), and
to the end of those that end by themselves.
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
TOLD = "told.json"
HEARD = "heard"

# of each: its arguments, the file that its first sound is in, whether it ends by itself
COMMANDS: dict[str, tuple[list[str], str, bool]] = {
    "demo": (["demo"], "overview-demo/*.wav", True),
    "play": (
        ["play", MATCH, "--device", "none", "--replay", "sweep:1", "--screen", "json"],
        HEARD,
        False,
    ),
    "batch": (["batch", "jobs.toml"], "study/sounds/**/*.wav", True),
    "serve": (["serve", MATCH, "--port", "0", "--json"], HEARD, False),
}


@dataclass(frozen=True)
class Start:
    """Processor time, s; `whole_s` is None for what plays on."""

    command: str
    imports_s: float
    first_sound_s: float
    whole_s: float | None


class Imports:
    """Processor time that modules take to be imported, whoever does it."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._local = threading.local()
        bootstrap: Any = importlib._bootstrap  # type: ignore[attr-defined]
        self._found = bootstrap._find_and_load
        bootstrap._find_and_load = self._timed

    def _timed(self, *given: Any) -> Any:
        if getattr(self._local, "inside", False):
            return self._found(*given)
        self._local.inside, began = True, time.thread_time()
        try:
            return self._found(*given)
        finally:
            self._local.inside = False
            self.seconds += time.thread_time() - began


def run(name: str) -> None:
    """The command in this process and folder; writes what it cost to `TOLD`."""
    imports = Imports()
    arguments, first, ends = COMMANDS[name]
    told: dict[str, float] = {}

    def since_imports() -> float:
        """Of this process, and of its processes that have ended."""
        ended = os.times()
        return time.process_time() + ended[2] + ended[3] - imports.seconds

    def watch() -> None:
        while not any(Path().glob(first)):
            time.sleep(LOOK_EVERY_S)
        told.update(imports_s=imports.seconds, first_sound_s=since_imports())
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
            told["whole_s"] = since_imports()
        Path(TOLD).write_text(json.dumps(told))


def mark_first_block() -> None:
    """Have the first block that an output without a device plays write `HEARD`."""
    from overview_dsp.live.output import null_stream

    play: Callable[..., bool] = null_stream.run_block

    def marked(engine: Any, out: Any) -> bool:
        over = play(engine, out)
        if len(out):
            null_stream.run_block = play
            Path(HEARD).touch()
        return over

    null_stream.run_block = marked


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
            (Path(folder) / HEARD).touch()
        _, complaint = process.communicate(timeout=LONGEST_S)
        told = json.loads((Path(folder) / TOLD).read_text())
        if "first_sound_s" not in told:
            sys.exit(f"{name}: no sound: {complaint.strip()[-500:]}")
        return Start(name, told["imports_s"], told["first_sound_s"], told.get("whole_s"))


def report(commands: list[str]) -> dict[str, Any]:
    """What `--json` prints."""
    from datetime import date

    sys.path.insert(0, str(ROOT))
    from overview_dsp.measure.bench.speeds import this_machine

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
    told = report(asked.commands or list(COMMANDS))
    if asked.json:
        print(json.dumps(told))
    else:
        print(f"{told['date']}, {told['machine']}")
        print("\n".join(lines([Start(**one) for one in told["first_starts"]])))
