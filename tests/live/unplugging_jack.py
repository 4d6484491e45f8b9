"""The unplugged sessions on a real JACK server, whose table of them is a program of its own.

    python -m tests.live.unplugging_jack FOLDER CASE...

A named device is a client with ports, `deck`, in a process of its own; the default one is the
server's. The server ends with all its devices, or it freezes. A line of JSON per case is printed.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import traceback
from unittest import mock

from overview_dsp.live.output import portaudio_library
from tests.live.unplugging import CASES, Session

DECK = """
import sys, jack
client = jack.Client("deck")
for number in (1, 2):
    client.inports.register(f"in_{number}")
    client.outports.register(f"out_{number}")
client.set_process_callback(lambda frames: None)  # without one, no client after it is called
client.activate()
print(client.name, flush=True)
sys.stdin.read()
"""


class JackBench:
    """A server and a deck, which end, return and freeze."""

    named = {"output": "deck", "input": "deck"}  # noqa: RUF012
    follows = ("input", "output", "duplex")
    plays_without_input = False
    never_found_again = ("suspend_duplex_stream_by_unplugging_a_nondefault_input_device",)
    """A deck that returns after the output does: PortAudio doesn't list it while that plays."""

    def __init__(self):
        self.server = self.deck = None
        atexit.register(self.end)  # first, so that it runs after PortAudio has ended

    def start(self):
        name = os.environ["JACK_DEFAULT_SERVER"]
        self.server = subprocess.Popen(
            f"jackd -n {name} -r -d dummy -r 48000 -p 256 -C 2 -P 2".split(),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        until = time.monotonic() + 10.0
        look = ["jack_wait", "-c"]
        while not subprocess.run(look, capture_output=True).stdout.startswith(b"run"):
            assert self.server.poll() is None, "jackd did not start"
            assert time.monotonic() < until, "jackd did not start"
            time.sleep(0.02)

    def start_deck(self):
        self.deck = subprocess.Popen(
            [sys.executable, "-c", DECK], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.deck.stdout.readline().strip() == "deck"

    def end(self):
        """End the server; killed, it would leave its place in the table of servers.

        It ends first: it would wait some seconds for a deck that has ended.
        """
        for one in (self.server, self.deck):
            if one is not None:
                one.terminate()
                one.send_signal(signal.SIGCONT)
                one.wait()
        self.deck = self.server = None

    def restore(self):
        """Have server and deck run, and PortAudio know them."""
        if self.server is None:
            self.start()
        if self.deck is None:
            self.start_deck()
        self.server.send_signal(signal.SIGCONT)
        portaudio_library.rescan()
        # not a plugin of ALSA that plays to JACK
        portaudio_library.import_sounddevice().default.device = "system", "system"

    @contextlib.contextmanager
    def patching(self):
        with contextlib.ExitStack() as stack:
            yield lambda *given: stack.enter_context(mock.patch.object(*given))

    def unplug(self, kind, named):
        if named or not self.freezes:
            self.end()
        else:
            self.server.send_signal(signal.SIGSTOP)

    def offer_another(self):
        if self.server is None:
            self.start()
        self.server.send_signal(signal.SIGCONT)

    def replug(self, kind, named):
        self.start_deck()


def left():
    """Numbers of threads and open files of this process."""
    return len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))


def main():
    folder = pathlib.Path(sys.argv[1])
    bench = JackBench()
    for number, name in enumerate(sys.argv[2:]):
        case, began = CASES[name], time.monotonic()
        bench.freezes = case.quits
        try:
            bench.restore()
            os.mkdir(folder / str(number))
            before = left()
            report = Session(case, bench, folder / str(number)).run()
            bench.restore()
            report["left"] = [before, left()]
            listed = subprocess.run(["jack_lsp"], capture_output=True, text=True).stdout
            report["ports"] = [port for port in listed.split() if port.startswith("overview:")]
        except Exception:
            report = {"failed": traceback.format_exc()}
        report["took_s"] = round(time.monotonic() - began, 2)
        print(json.dumps({"case": case.name, **report}), flush=True)
        if "failed" in report:  # a stream may be open, for which PortAudio's end would wait
            bench.end()
            os._exit(1)


if __name__ == "__main__":
    main()
