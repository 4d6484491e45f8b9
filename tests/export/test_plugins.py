"""A plugin plays the native engine's bits in a host, whatever the host does."""

from __future__ import annotations

import shutil
import struct
import subprocess
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.kernels import layout
from overview_dsp.presets.parameters import PARAMETERS
from tests.cli.running import MATCH, overview
from tests.web.surfaces import preset_of

HOST = Path(__file__).with_name("clap_host.c")
HEADERS = Path(ov.export.__file__).with_name("plugin")
VALUE, DOWN, UP, MIDI = range(4)
EARLIER, FLUSHED = -1, -2
"""Frames of events before the plugin is active, and in a flush after it is."""

ROW = np.dtype([("kind", "i8"), ("number", "i8"), ("frame", "i8"), ("value", "f8")])
PRESETS = ("viscous", "bristles", "wells")
FRAMES = 40_000
NOT_THE_PRESETS = ("theta2", "touch", "preset")
NO_MORE_TAIL = 2**31 - 1


def preset_named(name):
    given = {"viscous": ov.load_preset("football")}.get(name)
    given = given or preset_of({"bristles": "door", "wells": "dial"}[name])
    return replace(given, name=name)


def number_of(id):
    """A parameter's number in a CLAP host: FNV-1a of its id."""
    value = 2166136261
    for byte in id.encode():
        value = (value ^ byte) * 16777619 % 2**32
    return value


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


def natively(match, preset, rate, events, frames=FRAMES):
    engine = ov.Engine(preset, match, seed=3)
    engine.prepare(rate, frames)
    hands = Hands(engine)
    for event in events:
        hands.hear(*event)
    out = np.zeros((frames, 2), np.float32)
    engine.process(out)
    return out


def score(rate=48_000, frames=FRAMES, seed=1):
    """A hand that sweeps and lets go, keys, a wheel and parameters, at frames of no order."""
    random = np.random.default_rng(seed)
    places = np.sort(random.integers(0, frames // 2, 60))
    events = [(VALUE, "touch", 0, 1.0)]
    events += [(VALUE, "theta2", int(at), float(at / frames * 1.6)) for at in places]
    events += [(VALUE, "touch", frames // 2 + 17, 0.0)]
    ids = [id for id in PARAMETERS if id.startswith(("disk.", "tactor.", "click.", "texture."))]
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


@pytest.fixture(scope="session")
def host(tmp_path_factory):
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    program = tmp_path_factory.mktemp("host") / "clap_host"
    warn = ("-Wall", "-Wextra", "-Werror")
    command = ["gcc", "-std=gnu11", *warn, f"-I{HEADERS}", str(HOST), "-rdynamic", "-o"]
    subprocess.run([*command, str(program), "-ldl"], check=True, timeout=600)

    def run(*arguments, fails=False):
        said = subprocess.run(
            [program, *map(str, arguments)], capture_output=True, text=True, timeout=600
        )
        assert (said.returncode != 0) == fails, said.stderr
        return said.stderr if fails else said.stdout

    return run


@pytest.fixture(scope="module")
def presets():
    return {name: preset_named(name) for name in PRESETS}


@pytest.fixture(scope="module")
def plugin(match, presets, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plugins")
    return ov.export.build_plugin(match, [*presets.values()], "clap", folder, name="Match!", seed=3)


@pytest.fixture
def play(host, plugin, tmp_path):
    def run(events, *, rate=48_000, block=0, frames=FRAMES, state="-", saved="-", warm=0):
        rows = [
            (kind, number_of(number) if kind == VALUE else number, frame, value)
            for kind, number, frame, value in events
        ]
        (tmp_path / "events").write_bytes(np.array(rows, ROW).tobytes())
        given = (rate, block, frames, tmp_path / "events", tmp_path / "out", state, saved, warm)
        said = host(plugin, "play", *given).split()
        names = ("status", "latency", "tail", "tail_changes", "rescans", "told")
        report = dict(zip(names, map(int, said), strict=True))
        return np.fromfile(tmp_path / "out", np.float32).reshape(-1, 2), report

    return run


def chosen(name):
    return (VALUE, "preset", EARLIER, float(PRESETS.index(name)))


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000, 12_345.678])
@pytest.mark.parametrize("name", PRESETS)
def test_events_at_any_frame_in_blocks_of_any_size_are_the_engines(
    match, presets, play, name, rate
):
    expected = natively(match, presets[name], rate, score())
    assert np.abs(expected).max(axis=0).min() > 0.01
    heard, report = play([chosen(name), *score()], rate=rate)
    assert np.array_equal(heard, expected)
    assert report["latency"] == 0


@pytest.mark.parametrize("block", [1, 17, 64, 512, 4096])
def test_no_block_size_changes_a_bit(match, presets, play, block):
    expected = natively(match, presets["viscous"], 48_000, score(), 20_000)
    assert np.array_equal(play(score(), block=block, frames=20_000)[0], expected)


def test_a_reset_is_a_new_voice_with_the_values_of_the_moment(play):
    touched = [(VALUE, "touch", EARLIER, 1.0), (VALUE, "tactor.gain_db", EARLIER, -9.0)]
    swept = [(VALUE, "theta2", at, at / 8000) for at in range(100, 8000, 97)]
    fresh, _ = play([*touched, (VALUE, "theta2", EARLIER, swept[-1][3]), *swept])
    again, _ = play([*touched, *swept], warm=9000)
    assert np.abs(fresh).max() > 0.01
    assert np.array_equal(again, fresh)


def test_state_opens_in_a_fresh_host(match, presets, play, tmp_path):
    values = {"tactor.gain_db": -7.25, "click.mute": 1.0, "disk.release": 1.0}
    settings = [(VALUE, id, EARLIER, value) for id, value in values.items()]
    state = tmp_path / "state"
    play([chosen("wells"), *settings], frames=100, saved=state)
    changed = presets["wells"].with_changes(
        {"tactor.gain_db": -7.25, "click.mute": True, "disk.release": "return"}
    )
    hands = [event for event in score() if event[1] in NOT_THE_PRESETS or event[0] != VALUE]
    heard, report = play(hands, state=state, saved=tmp_path / "again")
    assert np.array_equal(heard, natively(match, changed, 48_000, hands))
    assert report["rescans"] == 2  # of two instances
    play([], state=state, frames=1, saved=tmp_path / "again")
    assert (tmp_path / "again").read_bytes() == state.read_bytes()


def test_a_flush_and_a_state_that_come_while_it_is_active_glide_in(match, presets, play, tmp_path):
    values = {"tactor.gain_db": -7.25, "texture.gain_db": -20.0}
    hands = [
        (VALUE, "touch", 0, 1.0),
        *((VALUE, "theta2", at, at / 9e3) for at in range(1, 8000, 80)),
    ]
    changes = [(VALUE, id, 0, value) for id, value in values.items()]
    expected = natively(match, presets["viscous"], 48_000, [*changes, *hands], 9_000)
    flushed = [(VALUE, id, FLUSHED, value) for id, value in values.items()]
    assert np.array_equal(play([*flushed, *hands], frames=9_000)[0], expected)
    earlier = [(VALUE, id, EARLIER, value) for id, value in values.items()]
    play(earlier, frames=1, saved=tmp_path / "state")
    heard, _ = play(hands, frames=9_000, state=f"+{tmp_path / 'state'}")
    assert np.array_equal(heard, expected)
    # nothing glides that is there from the beginning
    assert not np.array_equal(play([*earlier, *hands], frames=9_000)[0], expected)


def test_damaged_state_is_refused(host, plugin, play, tmp_path):
    good = tmp_path / "good"
    play([], frames=1, saved=good)
    state, random = good.read_bytes(), np.random.default_rng(1)
    begin = state.index(b"theta2") + 32
    wrong = [
        b"",
        state[:7],
        state[:-1],
        state + b"\0",
        random.bytes(len(state)),
        random.bytes(1 << 20),
    ]
    wrong += [state[:7] + b"\2" + state[8:], state[:8] + b"0" * 64 + state[72:]]
    wrong += [
        state[:begin] + struct.pack("<d", value) + state[begin + 8 :]
        for value in (np.nan, np.inf, -0.1, 1.1)
    ]
    wrong += [state.replace(b"tactor.mute", b"tactor.mite")]
    paths = [tmp_path / f"wrong-{number}" for number in range(len(wrong))]
    for path, content in zip(paths, wrong, strict=True):
        path.write_bytes(content)
    # after a good one, whose bytes no short one may take for its own
    assert host(plugin, "load", good, *paths, good).strip() == f"1{'0' * len(wrong)}1"


def test_another_preset_fades_in_and_then_is_the_only_one(match, presets, play):
    at, frames, fade = 9_001, 30_000, int(0.03 * 48_000) + 1
    hands = [(VALUE, "touch", 0, 1.0)]
    hands += [(VALUE, "theta2", frame, frame / 20_000) for frame in range(0, 20_000, 111)]
    heard, report = play([*hands[:83], (VALUE, "preset", at, 2.0), *hands[83:]], frames=frames)
    assert hands[82][2] < at <= hands[83][2]
    before = natively(match, presets["viscous"], 48_000, hands[:83], frames)
    later = [(VALUE, "theta2", 0, hands[82][3]), hands[0]]
    later += [(kind, id, frame - at, value) for kind, id, frame, value in hands[83:]]
    after = natively(match, presets["wells"], 48_000, later, frames - at)
    assert np.array_equal(heard[:at], before[:at])
    assert np.array_equal(heard[at + fade :], after[fade:])
    left = np.arange(fade, 0, -1)[:, None] / fade
    mixed = after[:fade] + (before[at : at + fade].astype(float) - after[:fade]) * left
    assert np.array_equal(heard[at : at + fade], mixed.astype(np.float32))
    assert report["told"] == 2 * 22  # its values, of two instances


def test_any_values_at_any_time_leave_numbers_and_a_voice_that_recovers(match, presets, play):
    random = np.random.default_rng(5)
    ids = [*NOT_THE_PRESETS, *(id for id in PARAMETERS if not id.startswith("surface."))]
    wild = (np.nan, np.inf, -np.inf, 1e300, -1.0, 0.0, 5e-324, 1.0)
    frames = np.sort(random.integers(0, 12_000, 3_000))
    frames[1000:2500] = frames[1000]  # more at one frame than a queue holds
    events = [
        (VALUE, ids[random.integers(len(ids))], int(at), float(random.choice(wild)))
        for at in frames
    ]
    events += [(MIDI, int(random.integers(1 << 24)), 12_000, 0.0) for _ in range(50)]
    events += [(VALUE, "nothing", 12_000, 1.0)]
    heard, _ = play(events, frames=14_000)
    assert np.abs(heard).max() <= 1.0
    # what was asked for last is what it is, though there was no room for it at once
    full = [(VALUE, "tactor.gain_db", 3, float(n % 72 - 60)) for n in range(3_000)]
    full += [(VALUE, "tactor.gain_db", 3, -3.0)]
    full += [(VALUE, "theta2", 9_000, 0.9), (VALUE, "touch", 9_000, 1.0)]
    quieter = presets["viscous"].with_changes({"tactor.gain_db": -3.0})
    expected = natively(match, quieter, 48_000, full[-2:])
    assert expected[9_000:, 1].any()
    assert np.array_equal(play(full)[0][9_000:], expected[9_000:])


def test_silence_sleeps_and_the_tail_is_true(match, presets, play):
    tapped = [(DOWN, 100, 0, 1.0), (UP, 100, 9_600, 0.0)]
    rate = 48_000
    _, report = play(tapped, frames=9_700)
    tail = report["tail"]
    engine = ov.Engine(presets["viscous"], match)
    engine.prepare(rate)
    assert tail == int(engine.tail_seconds * rate) + 1
    assert report["status"] == 1
    heard, report = play(tapped, frames=9_600 + tail + 4_800, block=512)
    assert heard[9_600:].any()
    assert not heard[9_600 + tail :].any()
    assert (report["status"], report["tail_changes"]) == (4, 0)
    _, report = play([*tapped, (VALUE, "tactor.decay_ms", 1_000, 90.0)], frames=9_700)
    assert (report["tail"], report["tail_changes"]) == (NO_MORE_TAIL, 2)


def test_the_host_is_told_every_parameter(host, plugin, presets):
    lines = [line.split("\t") for line in host(plugin, "list").splitlines()]
    assert lines[:3] == [
        ["org.overview-dsp.match", "Match!"],
        ["output", "Click", "1"],
        ["output", "Tactor", "1"],
    ]
    rows = {int(line[0]): line[1:] for line in lines[3:]}
    ids = [id for id in PARAMETERS if hasattr(layout, f"PARAM_{id.upper().replace('.', '_')}")]
    assert len(ids) == layout.PARAMETERS
    assert set(rows) == {number_of(id) for id in (*NOT_THE_PRESETS, *ids)}
    first = presets["viscous"].values
    for id in ids:
        known, (_, section, low, high, default, _, text) = PARAMETERS[id], rows[number_of(id)]
        assert section.lower() == id.partition(".")[0]
        if known.choices:
            assert (float(low), float(high)) == (0.0, len(known.choices) - 1)
            assert known.choices[int(float(default))] == first[id]
        else:
            assert (float(low), float(high), float(default)) == (known.low, known.high, first[id])
            assert text.endswith(known.unit)
    assert rows[number_of("preset")][-1] == "viscous"


def test_the_command_builds_one(host, tmp_path):
    done = overview("plugin", "build", MATCH, "--preset", "gravel", "--to", "clap", "-o", tmp_path)
    assert done.code == 0, done.err
    assert done.out.startswith(f"{tmp_path / MATCH}.clap: gravel;")
    assert host(tmp_path / f"{MATCH}.clap", "list").startswith(
        f"org.overview-dsp.{MATCH}\t{MATCH}\n"
    )


def test_what_can_not_be_built_is_one_line(match, football, tmp_path, monkeypatch):
    build = ov.export.build_plugin
    with pytest.raises(InputError, match="no plugin format 'vst3'; it is clap or lv2"):
        build(match, football, "vst3", tmp_path)
    with pytest.raises(InputError, match="1 to 16 presets, not 0"):
        build(match, [], "clap", tmp_path)
    with pytest.raises(InputError, match="the same name"):
        build(match, [football, football], "clap", tmp_path)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(OverviewError, match="no compiler 'no-such-compiler', which CC names"):
        build(match, football, "clap", tmp_path)
    monkeypatch.setenv("CC", "false")
    with pytest.raises(OverviewError, match="the C compiler false failed"):
        build(match, football, "clap", tmp_path)
    monkeypatch.setenv("CC", "")
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(OverviewError, match="apt install gcc"):
        build(match, football, "clap", tmp_path)
    assert not [*tmp_path.iterdir()]
