"""What a session does when a device is unplugged: cubeb's 16 cases, on two systems."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading

import pytest

from tests.live import jack_server, simulated_portaudio
from tests.live.unplugging import CASES, Session


class SimulatedBench:
    """Two outputs and two inputs, whose names begin alike; the first ones are unplugged."""

    named = {"output": "Speakers", "input": "Microphone"}  # noqa: RUF012
    follows = ("input", "output")
    """Streams that follow the default: PortAudio looks for devices only while nothing plays."""
    plays_without_input = True
    never_found_again = ()

    def __init__(self, ends, monkeypatch):
        self.machine = simulated_portaudio.Machine(ends)
        for number in (" 2", ""):
            self.machine.plug(f"Microphone{number}", inputs=1)
            self.machine.plug(f"Speakers{number}", outputs=2)
        self._monkeypatch = monkeypatch
        self.machine.default.update(input="Microphone", output="Speakers")
        simulated_portaudio.use(self.machine, monkeypatch)

    @contextlib.contextmanager
    def patching(self):
        yield self._monkeypatch.setattr

    def unplug(self, kind, named):
        self.machine.unplug(self.named[kind])
        self.machine.default[kind] = f"{self.named[kind]} 2"

    def offer_another(self):
        """Do nothing: it is there already."""

    def replug(self, kind, named):
        self.machine.plug("USB", inputs=2, outputs=2)  # another number for all
        name = self.named[kind]
        self.machine.plug(name, **{f"{kind}s": 2 if kind == "output" else 1})

    def recorded(self):
        return [one.device.name for one in self.machine.streams if not one.closed]


def left():
    """Threads and open files of this process."""
    return sorted(one.name for one in threading.enumerate()), len(os.listdir("/proc/self/fd"))


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    for kind in ("STATE", "CONFIG"):
        monkeypatch.setenv(f"XDG_{kind}_HOME", str(tmp_path / kind))


def check(case, report, first):
    """What a user notices on either system; `first` is the default output at the start."""
    assert report["touches"][0]  # the take is whole
    assert not report["touches"][-1]
    assert report["left open"] == 0
    if case.quits:
        return
    if case.unplugged == "output":
        assert report["state"]["name"] == "output lost"
        assert any(" Output lost: " in line for line in report["words"])
        lost = f"output lost: {report['back'] if case.named else first} disconnected"
        assert report["state"]["last_stop"] == report["after"]["last_stop"] == lost
        assert not report["touching"]
        said = f"output {lost.split()[2]} disconnected; disk released"
        assert sum(line.startswith(said) for line in report["said"]) == 1
    else:
        assert sum(": lost (" in line for line in report["said"]) == 1
    if case.named:
        assert report["still lost"]  # no other device took its place


ENDS = [(name, True) for name in CASES] + [
    (name, False) for name, case in CASES.items() if case.stream != "duplex"
]
"""Each case with a stream that ends, as on ALSA, or is never called again, as on other systems."""


@pytest.mark.parametrize(("name", "ends"), ENDS)
def test_unplugging_on_a_simulated_portaudio(name, ends, tmp_path, monkeypatch):
    case, bench = CASES[name], SimulatedBench(ends, monkeypatch)
    before = left()
    report = Session(case, bench, tmp_path).run()
    check(case, report, "Speakers")
    assert left() == before
    assert bench.machine.terminated_open == 0
    assert all(stream.closed for stream in bench.machine.streams)
    if not case.quits:
        assert report["after"]["name"] == "running"
        if case.unplugged == "input":
            assert report["state"]["name"] == "running"  # the sound goes on
            assert report["touching"]
            assert sum("connected again" in line for line in report["said"]) == 1
        follows = not case.named and case.stream in bench.follows
        device = bench.named[case.unplugged] + (" 2" if follows else "")
        assert device in report["recorded"]
        if case.unplugged == "output":
            assert report["back"] == device


def play_on_jack(names, folder, server):
    """Start a program that plays these cases on a server of this name; its process."""
    environment = {
        **os.environ, "JACK_DEFAULT_SERVER": server,
        "XDG_STATE_HOME": str(folder), "XDG_CONFIG_HOME": str(folder),
    }  # fmt: skip
    with (folder / "printed").open("w") as printed:
        return subprocess.Popen(
            [sys.executable, "-m", "tests.live.unplugging_jack", str(folder), *names],
            stdout=printed, stderr=subprocess.DEVNULL, env=environment,
        )  # fmt: skip


def end_server(server):
    """End a server that a program has left, with its deck."""
    found = subprocess.run(["pgrep", "-f", f"^jackd -n {server} "], capture_output=True, text=True)
    for number in map(int, found.stdout.split()):
        os.kill(number, signal.SIGTERM)
        os.kill(number, signal.SIGCONT)


@pytest.fixture(scope="module")
def on_jack(tmp_path_factory):
    """Exit codes of the programs, and reports of all cases on JACK by their names.

    Two programs play at the same time. What has failed is repeated in new programs.
    """
    codes, reports = [], {}
    for attempt in range(jack_server.ATTEMPTS):
        rest = [name for name in CASES if "failed" in reports.get(name, {"failed": ""})]
        if not rest:
            break
        for name in rest if attempt else ():
            print(f"repeated: {name}: {reports.get(name, {}).get('failed', 'no report')}")
        programs, codes = [], []
        for half in (0, 1):
            folder = tmp_path_factory.mktemp("jack")
            server = f"overview-unplugged-{os.getpid()}-{attempt}-{half}"
            programs.append((play_on_jack(rest[half::2], folder, server), folder, server))
        for program, folder, server in programs:
            try:
                program.wait(100.0)
            except subprocess.TimeoutExpired:
                program.kill()
                end_server(server)
            codes.append(program.wait())
            for line in (folder / "printed").read_text().splitlines():
                report = json.loads(line)
                reports[report["case"]] = report
    return codes, reports


@pytest.mark.realtime
@pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
@pytest.mark.parametrize("name", CASES)
def test_unplugging_on_a_jack_server(name, on_jack):
    case, report = CASES[name], on_jack[1][name]
    print(name, report["took_s"])
    assert "failed" not in report, report["failed"]
    check(case, report, "system")
    before, after = report["left"]
    assert after[1] == before[1]  # open files
    assert report["ports"] == []
    if not case.quits and case.unplugged == "output":
        assert report["back"] == ("deck" if case.named else "system")


@pytest.mark.realtime
@pytest.mark.skipif(not jack_server.available(), reason=jack_server.INSTALL)
def test_the_programs_on_jack_end_by_themselves(on_jack):
    assert on_jack[0] == [0, 0]
