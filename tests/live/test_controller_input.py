"""Controllers into a running engine: made-up ports, UDP by hand, MIDI on a headless server."""

from __future__ import annotations

import math
import socket
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import SOURCES
from overview_dsp.devices.controllers.control_map import Control
from overview_dsp.devices.controllers.control_messages import Scheduled
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.devices.controllers.osc_messages import OscReader
from overview_dsp.devices.controllers.source import ControllerSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.kernels import layout
from overview_dsp.live.inputs.controllers import ControllerInput
from overview_dsp.live.inputs.input import CombinedInput
from overview_dsp.live.inputs.takes_and_lines import TextLineInput
from overview_dsp.live.inputs.threaded import SourceWriter
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import NullStream
from overview_dsp.live.ports import osc as osc_out
from overview_dsp.live.ports.osc import OscOut, OscPort
from overview_dsp.live.ports.port import PortLostError
from overview_dsp.live.session.player import Player
from overview_dsp.live.session.presets import PresetWatch
from tests.devices.controllers.osc_bytes import bundle, message, messages


class MadePort:
    """A port that gives what a test puts in."""

    name = "made"

    def __init__(self):
        self._ready = threading.Event()
        self._waiting = []
        self.dropped = 0
        self.lost = self.closed = False

    def put(self, *datagrams):
        self._waiting.extend(datagrams)
        self._ready.set()

    def receive(self, wait_s):
        self._ready.wait(wait_s)
        self._ready.clear()
        if self.lost:
            raise PortLostError("gone")
        found, self._waiting = self._waiting, []
        return found

    def close(self):
        self.closed = True


@pytest.fixture
def engine(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 4800)
    return engine


@pytest.fixture
def running(engine):
    """The engine, run by a thread in real time."""
    stream = NullStream(engine, 256)
    stream.start()
    yield engine
    stream.close()


class Opened:
    """Inputs with made-up ports, that are closed in the end."""

    def __init__(self, engine):
        self.engine = engine
        self.ports = []
        self.inputs = []
        self.there = True

    def open(self, source, reader, silent_s=None, **options):
        def open_port():
            if not self.there:
                raise ov.InputError("made: no such port")
            self.ports.append(MadePort())
            return self.ports[-1]

        hand = ControllerInput(self.engine, source, open_port, reader, silent_s, **options)
        self.inputs.append(hand)
        return self.inputs[-1], self.ports[-1]


@pytest.fixture
def opened(running):
    opened = Opened(running)
    yield opened
    for one in opened.inputs:
        one.close()


def until(condition, seconds=10.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def said(hand, word, seconds=10.0):
    """Wait for a message with that word; every message until then."""
    lines = []

    def heard():
        lines.extend(hand.take_messages())
        return any(word in line for line in lines)

    until(heard, seconds)
    return lines


def bend(value):
    return bytes((0xE0, value & 0x7F, value >> 7))


def test_an_osc_touch_holds_moves_and_lets_go(opened, running):
    _, port = opened.open("osc", OscReader)
    port.put(message("/overview/theta2", 1.0, 1))
    until(lambda: running.active_input is not None)
    assert running.active_input == ("osc", pytest.approx(1.0))
    port.put(message("/overview/theta2", 2.0))
    until(lambda: running.active_input[1] == pytest.approx(2.0))
    port.put(message("/overview/touch", 0))
    until(lambda: running.active_input is None)


def applied_after(engine, make_input, send, count, block=1024):
    """Samples from the first block after each message to its event, in an engine run by hand."""
    made = make_input(engine)
    out = np.zeros((block, 2), np.float32)
    seen, waits = 0, []
    rings = engine.memory.view(np.int64)[layout.RING_WRITTEN : layout.RING_WRITTEN + layout.SOURCES]
    for number in range(count):
        # at changing times within a block
        time.sleep((number % 5) * 0.2 * block / engine.sample_rate)
        written = int(rings.sum())
        send(made, number)
        until(lambda written=written: rings.sum() > written)
        begins = engine.sample_time
        events, seen = [], seen
        for _ in range(100):  # blocks
            if len(events):
                break
            engine.process(out)
            events, seen = engine.pop_applied(seen)
        assert len(events)
        waits += [int(one) - begins for one in events["sample"]]
    return waits


@pytest.mark.parametrize("source", ["osc", "midi"])
def test_messages_apply_in_the_first_block_that_begins_after_them(engine, source):
    opened = Opened(engine)

    def send(port, number):
        if source == "osc":
            port.put(message("/overview/theta2", 1.0 + 0.001 * number, 1))
        else:
            port.put(bytes((0x90, 36 + number, 100)))

    reader = OscReader if source == "osc" else lambda counters: MidiReader(counters=counters)
    waits = applied_after(engine, lambda _: opened.open(source, reader)[1], send, 30)
    opened.inputs[0].close()
    assert set(waits) == {0}


@pytest.mark.parametrize("smooth_ms", [0, 6])
def test_smoothing_keeps_the_spacing_of_movements(engine, smooth_ms):
    now, block, spacing = [100.0], 1024, 336
    writer = SourceWriter(engine, "osc", now=lambda: now[0], smooth_s=1e-3 * smooth_ms)
    out = np.zeros((block, 2), np.float32)
    for number in range(200):
        now[0] = 100.0 + number * spacing / engine.sample_rate
        while engine.sample_time + block <= number * spacing:
            engine.process(out)
        writer.observe(now[0])
        writer.write([Event(now[0], 0.001 * number, True)])
    for _ in range(3):
        engine.process(out)
    applied = engine.pop_applied(0)[0]["sample"][100:]
    late = applied - spacing * np.arange(100, 200)
    if smooth_ms == 0:
        # at the start of a block
        assert set(applied % block) == {0}
        assert late.max() - late.min() > block / 2
    else:
        assert set(late) <= {48 * smooth_ms, 48 * smooth_ms + 1}


def test_a_silent_controller_releases_the_disk(opened, running):
    hand, port = opened.open("osc", OscReader, silent_s=0.3)
    port.put(message("/overview/theta2", 1.0, 1))
    until(lambda: running.active_input is not None)
    said(hand, "no messages for 0.3 s")
    until(lambda: running.active_input is None)
    # and takes hold again
    port.put(message("/overview/theta2", 2.0, 0), message("/overview/theta2", 2.0, 1))
    until(lambda: running.active_input is not None)


def test_a_lost_controller_lets_go_is_reported_once_and_comes_back(opened, running):
    hand, port = opened.open("midi", lambda counters: MidiReader(counters=counters))
    port.put(bytes((0x90, 60, 100)))
    until(lambda: running.active_input is not None)
    opened.there = False
    port.lost = True
    port.put()
    lines = said(hand, "disconnected")
    until(lambda: running.active_input is None)
    assert not hand.report()["connected"]
    assert "disconnected" in hand.status_text
    time.sleep(1.2)
    opened.there = True
    lines += said(hand, "reconnected")
    assert len(lines) == 2
    assert hand.report()["connections_lost"] == 1
    opened.ports[-1].put(bytes((0x90, 60, 100)))
    until(lambda: running.active_input is not None)
    assert hand.report()["messages"] == 2


def test_a_preset_whose_twist_lets_go_by_taps_alone_is_pointed_out(opened, running, football):
    hand, port = opened.open("osc", OscReader)
    running.set_preset(football.with_changes({"twist.release": "tap"}))
    hand.poll(running)
    port.put(message("/overview/theta2", 0.1), message("/overview/theta2", 0.2))
    assert len(said(hand, "twist.release")) == 1


def test_invalid_values_are_reported_once_per_parameter_and_counted(opened, running):
    hand, port = opened.open("osc", OscReader)
    for n in range(20):
        port.put(message("/overview/tactor/gain_db", 100.0 + n), message(f"/other/{n}", 1.0))
        until(lambda n=n: hand.report()["messages"] == n + 1)
        hand.poll(running)
    (line,) = hand.take_messages()
    assert "100" in line
    assert "only counted" in line
    assert hand.report()["rejected"] == hand.report()["unknown"] == 20


def test_a_knob_without_ends_goes_on_from_where_the_parameter_is(opened, running):
    controls = (Control("cc", 20, to="tactor.gain_db", low=-24.0, high=0.0, relative="twos",
                        steps=24.0),)  # fmt: skip
    hand, port = opened.open("midi", lambda counters: MidiReader(controls, counters))
    running.set("tactor.gain_db", -6.0)
    port.put(*(bytes((0xB0, 20, 127)) for _ in range(4)), bytes((0xB0, 20, 1)))
    until(lambda: hand.report()["messages"] == 5)
    hand.poll(running)
    assert running.preset.values["tactor.gain_db"] == pytest.approx(-9.0)
    port.put(*(bytes((0xB0, 20, 10)) for _ in range(9)))
    until(lambda: hand.report()["messages"] == 14)
    hand.poll(running)
    assert running.preset.values["tactor.gain_db"] == 0.0


def test_parameters_are_set_by_poll_and_wrong_ones_reported_once(opened, running):
    hand, port = opened.open("osc", OscReader)
    port.put(
        message("/overview/tactor/gain_db", -6.0),
        message("/overview/kinds.goal.height", 50),
        message("/overview/tactor/gian_db", -6.0),
        message("/overview/tactor/decay_ms", "loud"),
    )
    until(lambda: hand.report()["messages"] == 4)
    hand.poll(running)
    assert running.preset.values["tactor.gain_db"] == -6.0
    assert running.preset.kinds["goal"].height == 50.0
    lines = hand.take_messages()
    assert len(lines) == 2
    assert "did you mean 'tactor.gain_db'" in lines[0]
    port.put(message("/overview/tactor/gian_db", -6.0))
    until(lambda: hand.report()["messages"] == 5)
    hand.poll(running)
    assert hand.take_messages() == ()
    assert (hand.report()["unknown"], hand.report()["rejected"]) == (2, 1)


def test_many_surface_changes_wait_for_a_slot_and_the_last_one_wins(opened, running):
    hand, port = opened.open("osc", OscReader)
    for n in range(40):
        port.put(message("/overview/kinds/goal/height", 10.0 + n))
        time.sleep(0.002)
        hand.poll(running)

    def settled():
        hand.poll(running)
        return running.preset.kinds["goal"].height == 49.0

    until(settled)
    assert hand.take_messages() == ()


def test_two_controllers_change_over_without_a_jump(opened, running):
    osc, osc_port = opened.open("osc", OscReader)
    midi, midi_port = opened.open("midi", lambda counters: MidiReader(counters=counters))
    both = CombinedInput({"osc": osc, "midi": midi})
    blend_s = running.preset.number("twist.blend_ms") * 1e-3

    def change_over():
        """Move the fader to 2.0, then the wheel; return whether no step is too fast."""
        for theta2 in np.linspace(0.0, 2.0, 20):
            osc_port.put(message("/overview/theta2", float(theta2)))
            time.sleep(0.005)
        until(lambda: running.active_input is not None)
        until(lambda: running.active_input[1] == pytest.approx(2.0))
        _, before = running.pop_applied(0)
        for value in range(8192, 13000, 100):
            read = midi.report()["messages"]
            midi_port.put(bend(value))
            until(lambda read=read: midi.report()["messages"] > read)
        end = (12992 - 8192) / 8191 * math.pi
        until(lambda: running.active_input[1] == pytest.approx(end, abs=0.01))
        assert running.active_input[0] == "midi"
        applied, _ = running.pop_applied(before)
        held = applied[applied["touching"]]
        assert len(held) > 20
        # it begins where the fader is, and goes over within twist.blend_ms: half as fast again in
        # the middle, beside what the wheel itself turns by
        assert held["theta2"][0] == pytest.approx(2.0)
        steps = np.abs(np.diff(held["theta2"]))
        assert (steps < 1.9).all()
        apart_s = np.diff(held["sample"]) / running.sample_rate
        return (steps < 1.5 * 2.0 / blend_s * (apart_s + 0.01) + 0.08).all()

    # on a busy machine the samples may stand still for a moment while messages go on
    for _ in range(5):
        if is_smooth := change_over():
            break
        midi_port.put(bend(8192))
        until(lambda: not midi.report()["holding"])
    assert is_smooth
    # the fader that lies at 2.0 is turned again
    for theta2 in np.linspace(2.0, 3.0, 20):
        osc_port.put(message("/overview/theta2", float(theta2)))
        time.sleep(0.01)
    until(
        lambda: running.active_input[0] == "osc" and running.active_input[1] == pytest.approx(3.0)
    )
    # and back at the middle the wheel lets go: nothing more of it
    midi_port.put(bend(8192))
    until(lambda: not midi.report()["holding"])
    assert running.active_input[0] == "osc"
    assert set(both.report()) == {"osc", "midi"}
    assert len(both.status_text.splitlines()) == 2


def test_a_flood_is_read_and_leaves_nothing_behind(opened, running):
    hand, port = opened.open("osc", OscReader)
    for _ in range(200):
        port.put(*(message("/overview/theta2", (k % 300) / 100, 1) for k in range(100)))
        time.sleep(0.001)
    until(lambda: hand.report()["messages"] == 20_000, 30.0)
    port.put(message("/overview/theta2", 1.5, 1))
    until(
        lambda: running.active_input is not None and running.active_input[1] == pytest.approx(1.5)
    )
    assert running.meters.dropped_events == 0
    port.put(message("/overview/touch", 0))
    until(lambda: running.active_input is None)


def test_what_controllers_did_and_set_is_recorded_and_renders_to_the_same_bits(
    match, football, tmp_path
):
    path = tmp_path / "take.csv"
    player = Player(
        match, PresetWatch("football"), lambda engine, given: NullStream(engine, 256, given),
        OutputSettings(), callback="python", record=path,
    )  # fmt: skip
    opened = Opened(player.engine)
    osc, osc_port = opened.open("osc", OscReader)
    midi, midi_port = opened.open("midi", lambda counters: MidiReader(counters=counters))

    def played(seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            osc.poll(player.engine)
            midi.poll(player.engine)
            player.poll()
            time.sleep(0.01)

    for n in range(40):
        osc_port.put(message("/overview/theta2", 0.05 * n))
        midi_port.put(bend(8192 + 100 * n))
        osc_port.put(message("/overview/tactor/gain_db", -0.2 * n))
        played(0.01)
    osc_port.put(message("/overview/kinds/goal/height", 60))
    midi_port.put(bytes((0x90, 90, 100)))
    played(0.3)
    for one in opened.inputs:
        one.close()
    played(0.2)
    player.close()
    take = ov.load_gesture(path)
    assert {SOURCES[source] for source in take.source} >= {"osc", "midi"}
    assert len(take.changes) > 5
    result = ov.render(match, football, take, tail="none")
    assert result.trace.cursor[player.engine.sample_time - 1] == player.engine.meters.cursor
    assert result.engine.meters.strikes == player.engine.meters.strikes
    assert result.engine.preset.kinds["goal"].height == 60.0


# --- UDP ------------------------------------------------------------------------------------------


@pytest.fixture
def number():
    """Of a port that is free."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def test_datagrams_of_a_client_made_by_hand_move_the_disk(running, number):
    hand = ControllerInput(running, "osc", lambda: OscPort(str(number)), OscReader)
    client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        client.sendto(message("/overview/theta2", 2.0, 1), ("127.0.0.1", number))
        until(lambda: running.meters.cursor > 0.6)
        client.sendto(b"rubbish", ("127.0.0.1", number))
        client.sendto(message("/overview/touch", 0), ("127.0.0.1", number))
        until(lambda: running.active_input is None)
        assert hand.report()["rejected"] == 1
        with pytest.raises(ov.InputError, match="another program uses this port"):
            OscPort(str(number))
    finally:
        client.close()
        hand.close()
    OscPort(str(number)).close()  # given back


def at(engine, theta2):
    """Whether the hand that holds the disk is there."""
    held = engine.active_input
    return held is not None and held[1] == pytest.approx(theta2, abs=1e-6)


def test_two_osc_senders_are_two_inputs_and_the_earlier_gets_the_disk_back(running, number):
    hand = ControllerInput(running, "osc", lambda: OscPort(str(number)), OscReader)
    first, second = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    try:
        to = ("127.0.0.1", number)
        first.sendto(message("/overview/theta2", 2.0, 1), to)
        until(lambda: at(running, 2.0))
        second.sendto(message("/overview/theta2", 1.0, 1), to)
        until(lambda: at(running, 1.0))
        assert f"127.0.0.1:{second.getsockname()[1]}: 57°, touching" in hand.status_text
        first.sendto(message("/overview/theta2", 2.5), to)  # moves, but doesn't hold
        time.sleep(0.1)
        assert at(running, 1.0)
        second.sendto(message("/overview/touch", 0), to)
        until(lambda: at(running, 2.5))
        assert f"127.0.0.1:{first.getsockname()[1]}: 143°, touching" in hand.status_text
        first.sendto(message("/overview/theta2", 2.5, 0), to)
        until(lambda: running.active_input is None)
    finally:
        first.close()
        second.close()
        hand.close()


@pytest.mark.parametrize("block", [64, 256, 1024])
def test_time_tags_keep_their_spacing_to_the_sample(engine, block, monkeypatch):
    """Bundles a block and 10 ms ahead, sent unevenly; blocks and messages arrive unevenly, too."""
    random, rate = np.random.default_rng(block), engine.sample_rate
    now, since_1970 = [100.0], 1.8e9
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time, "time", lambda: since_1970 + now[0] * (1.0 + 2e-5))  # clocks drift
    writer = SourceWriter(engine, "osc", now=lambda: now[0], smooth_s=0.0)
    source, reader = ControllerSource(TouchRules.of(engine.preset)), OscReader()
    out = np.zeros((block, 2), np.float32)
    sent = 100.0 + 0.004 + np.cumsum(random.uniform(0.004, 0.012, 300))
    starts = 100.0 + block / rate * np.arange(1, 5.0 * rate / block)
    steps = [(one + random.uniform(0.0, 0.4) * block / rate, None) for one in starts]
    steps += [(one + random.uniform(0.0, 0.001), at) for at, one in enumerate(sent)]
    due = sent + block / rate + 0.01
    for now[0], number in sorted(steps, key=lambda step: step[0]):
        if number is None:
            engine.process(out)
            continue
        unix = since_1970 + due[number] * (1.0 + 2e-5)
        data = bundle(message("/overview/theta2", 0.5 + 0.005 * number, 1), seconds=unix)
        writer.tags.observe(now[0], engine.sample_time)
        for one in reader.read(data, now[0]):
            assert isinstance(one, Scheduled)
            found = source.move(one.movement, now[0])
            writer.write([replace(event, scheduled_s=one.time_s) for event in found])
    for _ in range(round(0.2 * rate) // block + 2):
        engine.process(out)
    applied = engine.pop_applied(0)[0]["sample"]
    assert len(applied) == 300
    late = (applied - rate * (due - due[0]))[20:]
    line = np.polyval(np.polyfit(due[20:], late, 1), due[20:])
    assert np.abs(late - line).max() <= 1.0
    assert engine.meters.late_events == 0


@pytest.mark.realtime
@pytest.mark.parametrize("block", [64, 256, 1024])
def test_time_tags_are_kept_by_a_real_socket_and_a_real_clock(engine, number, block):
    stream = NullStream(engine, block)
    stream.start()
    hand = ControllerInput(engine, "osc", lambda: OscPort(str(number)), OscReader)
    random = np.random.default_rng(1)
    ahead_s = block / engine.sample_rate + 0.01
    sent = []
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            for n in range(150):
                sent.append(time.time() + ahead_s)
                one = message("/overview/theta2", 0.5 + 0.01 * n, 1)
                client.sendto(bundle(one, seconds=sent[-1]), ("127.0.0.1", number))
                time.sleep(random.uniform(0.004, 0.012))
            until(lambda: at(engine, 0.5 + 0.01 * 149))
            applied = engine.pop_applied(0)[0]
    finally:
        hand.close()
        stream.close()
    taken = applied["sample"][applied["touching"] == 1]
    assert len(taken) == 150
    late = (taken - engine.sample_rate * (np.array(sent) - sent[0]))[20:]
    drift = np.polyval(np.polyfit(np.arange(len(late)), late, 1), np.arange(len(late)))
    assert np.abs(late - drift).max() <= 1.5


def test_a_time_tag_far_ahead_applies_at_once_and_says_so(running, number):
    hand = ControllerInput(running, "osc", lambda: OscPort(str(number)), OscReader)
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            one = message("/overview/theta2", 1.0, 1)
            client.sendto(bundle(one, seconds=time.time() + 60.0), ("127.0.0.1", number))
            until(lambda: at(running, 1.0))
        said(hand, "time tags more than 10 s ahead apply at once")
    finally:
        hand.close()


def test_commands_with_a_new_socket_each_are_one_input(running, number):
    """As `oscsend` sends: touches, moves, and releases."""
    hand = ControllerInput(running, "osc", lambda: OscPort(str(number)), OscReader)

    def send(*words):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            one.sendto(message(*words), ("127.0.0.1", number))

    try:
        for turn in range(2):
            for theta2 in (0.5, 1.0, 1.5, 2.0):
                send("/overview/theta2", theta2 + 0.1 * turn, 1)
                until(lambda: at(running, theta2 + 0.1 * turn))  # noqa: B023
            send("/overview/theta2", 2.1, 0)
            until(lambda: running.active_input is None)
            send("/overview/touch", 1)
            until(lambda: running.active_input is not None)
            send("/overview/theta2", 0.7 + turn)
            until(lambda: at(running, 0.7 + turn))  # noqa: B023
            send("/overview/touch", 0)
            until(lambda: running.active_input is None)
    finally:
        hand.close()


def test_two_midi_channels_are_two_inputs_and_the_screen_names_the_one_that_holds(running):
    port = MadePort()
    hand = ControllerInput(
        running, "midi", lambda: port, lambda counters: MidiReader(counters=counters)
    )
    try:
        for value in (*range(0, 120, 10), 127):  # a bend wheel, whose turn touches
            port.put(bytes([0xE0, 0, 64 + value // 2]))
            time.sleep(0.01)
        until(lambda: running.active_input is not None)
        assert "bend" in hand.status_text
        first = hand.status_text.split(": ")[1]
        for value in (*range(0, 60, 6), 64):
            port.put(bytes([0xE4, 0, 64 + value // 2]))
            time.sleep(0.01)
        until(lambda: hand.status_text.split(": ")[1] != first)
        assert "/1" in first
        assert "/5" in hand.status_text.split(": ")[1]
    finally:
        hand.close()


@pytest.mark.parametrize(
    "text", ["", "x", "0", "70000", "1:2:x", ":9000", "no.such.host.invalid:9"]
)
def test_an_invalid_address_gives_a_one_line_error(text):
    with pytest.raises(ov.InputError):
        OscPort(text)


def test_what_the_disk_does_is_sent_out(running, match):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        out = OscOut(running, str(listener.getsockname()[1]))
        running.control(3.0, True)
        heard = {}
        events = []
        end = time.monotonic() + 10.0
        while time.monotonic() < end and not (events and heard.get("/overview/cursor", 0) > 0.8):
            address, values = messages(listener.recv(65535))
            heard[address] = values[0]
            events += [values] if address == "/overview/event" else []
        out.close()
    assert heard["/overview/touching"] == 1
    assert "/overview/torque" in heard
    happened = [(event.kind, event.label) for event in match.events]
    for kind, label, _, level in events:
        assert (kind, label) in happened
        assert level > 0.0


def test_a_failed_osc_report_is_reported_once_and_reports_continue(running, monkeypatch):
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.bind(("127.0.0.1", 0))
    listener.settimeout(10.0)
    said = []
    failing = threading.Event()
    take = running.pop_strike_events

    def fail():
        if failing.is_set():
            raise RuntimeError("made up")
        return take()

    monkeypatch.setattr(running, "pop_strike_events", fail)
    monkeypatch.setattr(osc_out, "RETRY_AFTER_S", 0.01)
    failing.set()
    with listener:
        out = OscOut(running, str(listener.getsockname()[1]), said.append)
        until = time.monotonic() + 10.0
        while not said and time.monotonic() < until:
            time.sleep(0.01)
        failing.clear()
        assert b"/overview/" in listener.recv(1000)
        out.close()
    assert len(said) == 1
    assert "made up; sending continues" in said[0]


def test_lines_that_cannot_be_read_are_told_and_let_go(engine):
    def lines():
        yield "1.0 1\n"
        raise UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte")

    hand = TextLineInput(lines(), engine)
    until = time.monotonic() + 10.0
    while not hand.is_over(engine) and time.monotonic() < until:
        time.sleep(0.01)
    engine.process(np.empty((4800, 2), dtype=np.float32))
    assert not engine.meters.touching
    (said,) = hand.take_messages()
    assert "invalid start byte" in said


def test_unknown_osc_addresses_are_counted_and_one_is_reported(engine):
    port = MadePort()
    hand = ControllerInput(engine, "osc", lambda: port, OscReader)
    port.put(*(message(f"/overview/nothing/of{number}", 1.0) for number in range(50)))
    until = time.monotonic() + 10.0
    while hand.counters.unknown < 50 and time.monotonic() < until:
        hand.poll(engine)
        time.sleep(0.01)
    said = hand.take_messages()
    hand.close()
    assert hand.counters.unknown == 50
    assert len(said) == 1
    assert "further ones are only counted" in said[0]


def test_osc_asks_for_takes_replays_presets_and_windows(engine):
    port, asked = MadePort(), []
    hand = ControllerInput(
        engine, "osc", lambda: port, OscReader, queue_command=lambda *words: asked.append(words)
    )
    port.put(
        message("/overview/record"),
        message("/overview/record", 0),
        message("/overview/replay", 1.0),
        message("/overview/preset", "football-stadium"),
        message("/overview/preset", 2),
        message("/overview/window", 0, 2700.5),
    )
    until = time.monotonic() + 10.0
    while len(asked) < 6 and time.monotonic() < until:
        time.sleep(0.01)
    hand.close()
    assert asked == [
        ("record",),
        ("record", "0"),
        ("replay", "1"),
        ("preset", "football-stadium"),
        ("preset", "2"),
        ("window", "0", "2700.5"),
    ]
