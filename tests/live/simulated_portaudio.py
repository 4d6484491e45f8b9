"""A simulated PortAudio, in place of sounddevice: devices that a test plugs in and unplugs.

As the real one, it lists the devices that were there when it was initialized, finds them by parts
of their names, opens only those that are there, and runs the real native callback in a thread per
stream. An input gives a quiet noise, ten times as fast as a real one.
"""

from __future__ import annotations

import ctypes
import threading
import time
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from overview_dsp.live.inputs import feeds
from overview_dsp.live.output import devices, portaudio_library, reconnecting_stream

RATE, SPEED = 48_000, 10
CALLBACK = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_void_p,
    ctypes.c_ulong,
    ctypes.c_void_p,
    ctypes.c_ulong,
    ctypes.c_void_p,
)
USERS = (devices, portaudio_library)
"""Modules that import sounddevice by the library's module."""


class PortAudioError(Exception):
    """An error of the simulated library."""


@dataclass
class Device:
    """A device by its name; one with the same name is the same device, plugged in again."""

    name: str
    inputs: int = 0
    outputs: int = 0
    there: bool = True


@dataclass
class Machine:
    """Devices in the order of their numbers, and the names of the default input and output.

    `ends`: whether a stream ends when its device is unplugged (as on ALSA), or is never called
    again but stays active (as on other systems).
    """

    ends: bool
    devices: list[Device] = field(default_factory=list)
    default: dict[str, str] = field(default_factory=dict)
    streams: list[Stream] = field(default_factory=list)
    terminated_open: int = 0  # times that an open stream was lost by a new search

    def plug(self, name: str, inputs: int = 0, outputs: int = 0) -> None:
        """Plug a device in; it gets the first number."""
        self.devices.insert(0, Device(name, inputs, outputs))

    def unplug(self, name: str) -> None:
        """Unplug a device; the numbers of all later ones change."""
        device = next(one for one in self.devices if one.name == name)
        device.there = False
        self.devices.remove(device)

    def library(self) -> SimpleNamespace:
        """Return the module that programs import."""
        found = SimpleNamespace(
            PortAudioError=PortAudioError,
            CallbackStop=StopIteration,
            _ffi=SimpleNamespace(cast=lambda kind, value: value),
            _StreamBase=lambda kind, **given: Stream(self, kind, **given),
            OutputStream=None,  # the Python callback
            InputStream=lambda rate, **given: Stream(self, "input", samplerate=rate, **given),
            query_devices=self._query,
            query_hostapis=lambda n=None: self.hosts if n is None else self.hosts[n],
            _initialize=self._list,
            _terminate=self._terminate,
        )
        found.default = self
        self._list()
        return found

    hosts = ({"name": "simulated"},)

    def _list(self) -> None:
        self.listed = list(self.devices)
        names = [one.name for one in self.listed]
        self.device = [names.index(self.default[kind]) for kind in ("input", "output")]

    def _terminate(self) -> None:
        self.terminated_open += sum(not stream.closed for stream in self.streams)

    def _query(self, device=None, kind=None):
        infos = [
            {
                "index": n,
                "name": one.name,
                "hostapi": 0,
                "max_input_channels": one.inputs,
                "max_output_channels": one.outputs,
                "default_samplerate": float(RATE),
                "default_low_input_latency": 0.01,
                "default_low_output_latency": 0.01,
            }
            for n, one in enumerate(self.listed)
        ]
        if kind is None:
            return infos
        if device is None:
            device = self.device[kind == "output"]
        if isinstance(device, str):
            named = [
                n
                for n, one in enumerate(infos)
                if device.lower() in one["name"].lower() and one[f"max_{kind}_channels"]
            ]
            named = [n for n in named if infos[n]["name"] == device] or named
            if len(named) != 1:
                raise ValueError(f"No {kind} device matching {device!r}")
            device = named[0]
        if not 0 <= device < len(infos):
            raise PortAudioError(f"Error querying device {device}")
        return infos[device]

    def find(self, device, kind) -> Device:
        """Return the device of a number or name, if it can be opened now."""
        name = self.listed[self._query(device, kind)["index"]].name
        for one in self.devices:
            if one.name == name:
                return one
        raise PortAudioError("Error opening stream: Device unavailable [PaErrorCode -9985]")


class Stream:
    """An open stream, whose thread calls as long as its device is there."""

    def __init__(
        self, machine, kind, samplerate, device, channels, dtype, callback, blocksize=480,
        latency=0.0, userdata=None,
    ):  # fmt: skip
        self.device = machine.find(device, kind)
        self._machine, self._kind, self._user = machine, kind, userdata
        self._callback = callback if callable(callback) else CALLBACK(callback)
        self._block, self._channels = blocksize or 480, channels
        self._thread, self._over, self.closed = None, threading.Event(), False
        self.latency = 0.01
        machine.streams.append(self)

    def start(self):
        if not self.device.there:
            raise PortAudioError("Error starting stream: Device unavailable [PaErrorCode -9985]")
        self._over.clear()
        self._thread = threading.Thread(target=self._run, name="simulated", daemon=True)
        self._thread.start()

    def _run(self):
        speed = SPEED if self._kind == "input" else 1
        block = np.zeros((self._block * speed, self._channels), np.float32)
        block[:] = 1e-3 * np.sin(np.arange(len(block)) * 0.1)[:, None]
        due = time.monotonic()
        while not self._over.is_set():
            due += self._block / RATE
            time.sleep(max(0.0, due - time.monotonic()))
            if not self.device.there:
                if self._machine.ends:
                    return
            elif self._kind == "input":
                self._callback(block, len(block), None, 0)
            elif self._callback(None, block.ctypes.data, self._block, None, 0, self._user):
                return

    @property
    def active(self):
        return self._thread is not None and self._thread.is_alive()

    def stop(self):
        if self._thread is not None:
            self._over.set()
            self._thread.join()

    def close(self):
        assert not self.closed
        self.stop()
        self.closed = True


def use(machine: Machine, monkeypatch) -> None:
    """Have the program play on this machine, and miss its callbacks sooner."""
    library = machine.library()
    for module in USERS:
        monkeypatch.setattr(module, "import_sounddevice", lambda: library)
    monkeypatch.setattr(reconnecting_stream, "LOST_AFTER_S", 0.25)
    monkeypatch.setattr(feeds, "LOST_AFTER_S", 0.25)
