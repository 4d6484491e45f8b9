"""What the plugin tests play, what the native engine makes of it, and the hosts they play it in."""

from __future__ import annotations

import math
import shutil
import subprocess
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.offline.export.plugin_bundle import host_id
from tests.web.surfaces import preset_of

HERE = Path(__file__).parent
HEADERS = Path(ov.export.__file__).with_name("plugin")
VALUE, DOWN, UP, MIDI, TRANSPORT = range(5)
EARLIER, FLUSHED = -1, -2
"""Frames of events before the plugin is active, and without a block after it is."""

ROW = np.dtype([("kind", "i8"), ("number", "i8"), ("frame", "i8"), ("value", "f8")])
PRESETS = ("viscous", "bristles", "wells")
TIMELINES = ("match", "second half")
FRAMES = 40_000
HANDS = ("theta2", "touch")
NOT_THE_PRESETS = (*HANDS, "timeline", "preset", "follow")


def preset_named(name):
    given = {"viscous": ov.load_preset("football")}.get(name)
    given = given or preset_of({"bristles": "door", "wells": "dial"}[name])
    return replace(given, name=name)


def both_halves(match):
    return dict(zip(TIMELINES, (match, match.window(2700.0, 5600.0)), strict=True))


def is_log(id):
    return id in PARAMETERS and PARAMETERS[id].scale == "log"


def number_of(id):
    """A parameter's number in a CLAP host: FNV-1a of its id, on a logarithmic range of more."""
    value = 2166136261
    for byte in (host_id(id) + ".log" * is_log(id)).encode():
        value = (value ^ byte) * 16777619 % 2**32
    return value


def range_of(id):
    """A value's lowest and highest."""
    if id in NOT_THE_PRESETS:
        return 0.0, {"preset": len(PRESETS) - 1.0, "timeline": len(TIMELINES) - 1.0}.get(id, 1.0)
    known = PARAMETERS.get(id)
    if known is None:
        return 0.0, 1.0
    return (0.0, len(known.choices) - 1.0) if known.choices else (known.low, known.high)


ROOTS = 53  # bits of a number between 0 and 1


def roots(id):
    """Square root of a logarithmic range's ratio, that one's root, and so on, with their bits."""
    low, high = range_of(id)
    ratio = high / low
    for n in range(1, ROOTS + 1):
        ratio = math.sqrt(ratio)
        yield ratio, 0.5**n


def normal(id, value):
    """As a VST3 host says it, and on a logarithmic range a CLAP host."""
    low, high = range_of(id)
    if not is_log(id) or not low <= value <= high:
        return (value - low) / (high - low)
    if value == high:
        return 1.0
    part, rest = 0.0, value / low
    for ratio, bit in roots(id):
        if rest >= ratio:
            rest, part = rest / ratio, part + bit
    return part


def plain(id, part):
    """What a plugin makes of a host's number."""
    low, high = range_of(id)
    if not is_log(id):
        return low + part * (high - low)
    value = low
    for ratio, bit in roots(id):
        if part >= bit:
            part, value = part - bit, value * ratio
    return min(value, high)


def through_host(events, preset, to):
    """What comes out of numbers between 0 and 1: a preset's own values, others with a rounding."""
    heard = []
    for kind, id, frame, value in events:
        known = kind == VALUE and id in PARAMETERS and not PARAMETERS[id].choices
        if known and (to == "vst3" or is_log(id)):
            said, own = normal(id, value), preset.values[id]
            value = own if said == normal(id, own) else plain(id, said)
        heard.append((kind, id, frame, value))
    return heard


def rows_of(events, to):
    """As the tests' hosts read them; a value that is a float32 is what a VST3 host says itself."""

    def said(id, value):
        if isinstance(value, np.float32) or not (to == "vst3" or is_log(id)):
            return value
        return normal(id, value)

    return np.array(
        [
            (kind, number_of(id), frame, said(id, value))
            if kind == VALUE
            else (kind, id, frame, value)
            for kind, id, frame, value in events
        ],
        ROW,
    )


@dataclass
class Hands:
    """What a host's events say to the engine: the plugin's rules, in Python."""

    engine: ov.Engine
    theta2: float = 0.0
    touch: bool = False
    note: int = -1
    finger: float = 0.0
    events: list = field(default_factory=list)

    def hear(self, kind, number, frame, value):
        source = "touch"
        if kind == VALUE and number == "theta2":
            self.theta2 = value
        elif kind == VALUE and number == "touch":
            self.touch = value > 0.0
        elif kind == VALUE:
            known = PARAMETERS[number]
            said = known.choices[int(value)] if known.choices else value
            self.engine.set(number, said, sample_time=frame)
            return
        elif kind == MIDI and self.note < 0:
            self.theta2 = (number & 127) / 127.0
        else:
            source = "midi"
            if kind == DOWN:
                self.note, self.finger = number, number / 127.0
            elif kind == UP and number == self.note:
                self.note = -1
            elif kind == UP:
                return
            else:
                self.finger = (number & 127) / 127.0
        place, held = (
            (self.theta2, self.touch) if source == "touch" else (self.finger, self.note >= 0)
        )
        self.engine.control(np.pi * place, held, frame, source)


def natively(timeline, preset, rate, events, frames=FRAMES):
    engine = ov.Engine(preset, timeline, seed=3)
    engine.prepare(rate, frames)
    hands = Hands(engine)
    for event in events:
        hands.hear(*event)
    out = np.zeros((frames, 2), np.float32)
    engine.process(out)
    return out


def score(frames=FRAMES, seed=1):
    """A hand that sweeps and lets go, keys, a wheel and parameters, at frames of no order."""
    random = np.random.default_rng(seed)
    places = np.sort(random.integers(0, frames // 2, 60))
    events = [(VALUE, "touch", 0, 1.0)]
    events += [(VALUE, "theta2", int(at), float(at / frames * 1.6)) for at in places]
    events += [(VALUE, "touch", frames // 2 + 17, 0.0)]
    sections = ("disk.", "tactor.", "click.", "texture.")
    ids = [id for id, one in PARAMETERS.items() if id.startswith(sections) and not one.surface]
    for at in np.sort(random.integers(0, frames, 12)):
        known = PARAMETERS[ids[random.integers(len(ids))]]
        value = (
            float(random.integers(2)) if known.choices else random.uniform(known.low, known.high)
        )
        if known.id.startswith("disk.") and not known.choices:
            value = known.default
        events.append((VALUE, known.id, int(at), float(value)))
    later = int(frames * 0.6)
    events += [(DOWN, 90, later, 1.0), (MIDI, 0xB0_01_40, later + 1001, 0.0)]
    events += [(UP, 5, later + 1500, 0.0), (UP, 90, later + 3001, 0.0)]
    events += [(MIDI, 0xB0_01_20, later + 4000, 0.0)]
    return sorted(events, key=lambda event: event[2])


TRANSPORTS = [
    (TRANSPORT, 1, 1024, 100.0013),
    (TRANSPORT, 1, 8_192, 2_000.0),
    (TRANSPORT, 0, 16_384, 2_000.2),
    (TRANSPORT, 1, 20_480, -0.05),
    (TRANSPORT, 1, 30_720, 5_879.95),
]
"""A host's transport that plays, jumps, stops, starts before the timeline and passes its end."""


def followed(*images, frames=FRAMES, rate=48_000, transports=TRANSPORTS, hands=()):
    """What engines play whose input is at the transport; `images` as in `switched`.

    `hands`: rows of a frame, a place, and whether it is touched, of the first image.
    """
    heard = None
    for number, (at, timeline, preset) in enumerate(images):
        until = images[number + 1][0] if number + 1 < len(images) else frames
        played = _followed(timeline, preset, at, until, frames, rate, transports, hands)
        hands = ()
        heard = played if heard is None else faded(heard, played, at, rate)
    return heard


def _followed(timeline, preset, first, until, frames, rate, transports, hands):
    """What one plays that begins at a frame; it is told of the transport until another begins."""
    engine = ov.Engine(preset, timeline, seed=3)
    engine.prepare(rate, frames)
    for frame, place, held in hands:
        engine.control(np.pi * place, held, frame, "touch")
    made, step = engine.surface.angle_map, round(0.002 * rate)
    times, places = made.time_s.tolist(), made.position.tolist()
    touches, expected, playing, begin, seconds = False, None, 0, 0, 0.0
    changes = {frame: (playing, seconds) for _, playing, frame, seconds in transports}
    for frame in range(until):
        if frame in changes:
            (playing, seconds), begin = changes[frame], frame
        song = round(seconds * rate) + frame - begin
        within = bool(playing) and 0.0 <= song / rate <= times[-1] and frame >= first
        if within != touches or (within and (song % step == 0 or song != expected)):
            if within:
                i = int(np.searchsorted(times[1:-1], song / rate, "right"))
                part = (song / rate - times[i]) / (times[i + 1] - times[i])
                place = places[i] + part * (places[i + 1] - places[i])
            engine.control(np.pi * place, within, frame - first, "remote")
        touches, expected = within, song + 1
    out = np.zeros((frames - first, 2), np.float32)
    engine.process(out)
    return out


def faded(before, after, at, rate=48_000):
    """Sound that gives way at a frame to what began there: over 30 ms."""
    fade = int(0.03 * rate) + 1
    heard = np.concatenate([before[:at], after])
    left = np.arange(fade, 0, -1)[:, None] / fade
    mixed = after[:fade] + (before[at : at + fade].astype(float) - after[:fade]) * left
    heard[at : at + fade] = mixed.astype(np.float32)
    return heard


def switched(images, events, frames, rate=48_000):
    """What an engine plays, and those that take its place, each faded in, with the hand as it is.

    `images`: rows of a frame, a timeline and a preset, the first at 0; the fades are over between.
    """
    borders = [at for at, *_ in images[1:]] + [frames]
    heard = None
    for (at, timeline, preset), until in zip(images, borders, strict=True):
        hands = {event[1]: event for event in events if event[2] < at and event[1] in HANDS}
        held = [(VALUE, id, 0, hands[id][3]) for id in HANDS if id in hands]
        own = [(*event[:2], event[2] - at, event[3]) for event in events if at <= event[2] < until]
        played = natively(timeline, preset, rate, [*held, *own], frames - at)
        heard = played if heard is None else faded(heard, played, at, rate)
    return heard


@dataclass(frozen=True)
class Host:
    """The tests' host of a format, and how it is started."""

    to: str
    program: tuple[str, ...]
    library: Path

    def run(self, *arguments, fails=False):
        said = subprocess.run(
            [*self.program, *map(str, (self.library, *arguments))],
            capture_output=True,
            text=True,
            timeout=600,
        )
        assert (said.returncode != 0) == fails, said.stderr
        # a plugin has nothing to say; a machine that is imitated may
        assert fails or len(self.program) > 1 or not said.stderr
        return said.stderr if fails else said.stdout

    def play(
        self, folder, events, *, rate=48_000, block=0, frames=FRAMES, state="-", saved="-", warm=0
    ):
        """The two outputs, and what the host found."""
        (folder / "events").write_bytes(rows_of(events, self.to).tobytes())
        given = (rate, block, frames, folder / "events", folder / "out", state, saved, warm)
        said = self.run("play", *given).split()
        names = ("status", "latency", "tail", "tail_changes", "rescans", "told")
        report = dict(zip(names, map(int, said), strict=True))
        return np.fromfile(folder / "out", np.float32).reshape(-1, 2), report

    def heard(self, events, preset):
        """What comes through of values."""
        return through_host(events, preset, self.to)


def library_of(plugin):
    """The library of a plugin for this machine."""
    return next(plugin.glob("Contents/*/*")) if plugin.is_dir() else plugin


def built_host(to, folder):
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    program = folder / f"{to}_host"
    warn = ("-Wall", "-Wextra", "-Werror")
    command = ["gcc", "-std=gnu11", *warn, f"-I{HEADERS}", str(HERE / f"{to}_host.c"), "-rdynamic"]
    subprocess.run([*command, "-o", str(program), "-ldl"], check=True, timeout=600)
    return (str(program),)
