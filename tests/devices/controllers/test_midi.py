"""MIDI messages, byte by byte, without a port."""

from __future__ import annotations

import contextlib
import math
import re
import sys
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.controllers.control_map import (
    DEFAULT,
    TAPS,
    TOUCH,
    Control,
    load_map,
    parse_map,
    write_map,
)
from overview_dsp.devices.controllers.control_messages import (
    AngleChanged,
    ScaleParameter,
    StepParameter,
    TouchEnded,
    TouchStarted,
)
from overview_dsp.devices.controllers.learning import Learner
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.live.ports.midi import MidiPort, midi_ports


def read(reader, *messages, at=0.0):
    return [move for one in messages for move in reader.read(bytes(one), at)]


def bend(value, channel=1):
    return (0xE0 | channel - 1, value & 0x7F, value >> 7)


def change(number, value, channel=1):
    return (0xB0 | channel - 1, number, value)


def angles(moves):
    return [move.theta2 for move in moves]


def test_a_pitch_bend_turns_from_the_middle_to_either_end():
    moves = read(MidiReader(), *(bend(value) for value in (8192, 12288, 16383, 4096, 0)))
    assert angles(moves) == pytest.approx(
        [0.0, math.pi / 2, math.pi, math.pi / 2, math.pi], abs=1e-3
    )
    assert len({move.control for move in moves}) == 1


def test_channels_are_inputs_of_their_own_unless_the_map_has_a_touch_or_names_one():
    wheel, pad = Control("cc", 1), Control("note", 36, to=TOUCH)
    one, other = (
        {move.control for move in read(MidiReader((wheel,)), change(1, 64, channel))}
        for channel in (1, 5)
    )
    assert one != other
    # pads are often on channel 10, and wheels on channel 1
    reader = MidiReader((wheel, pad))
    read(reader, (0x99, 36, 100))
    (touched,) = read(reader, change(1, 64, 1))
    assert isinstance(touched, TouchStarted)
    assert read(reader, (0x89, 36, 0)) == [TouchEnded(touched.touch_id)]


def test_a_control_change_has_7_bits():
    moves = read(MidiReader(), change(1, 0), change(1, 64), change(1, 127))
    assert angles(moves) == pytest.approx([0.0, math.pi * 64 / 127, math.pi])


def test_with_its_fine_half_a_control_change_has_14_bits_without_a_step_between_the_halves():
    reader = MidiReader()
    read(reader, change(1, 0), change(33, 0))
    seen = []
    for value in range(16384):
        if value & 0x7F == 0:
            seen += angles(read(reader, change(1, value >> 7)))
        seen += angles(read(reader, change(33, value & 0x7F)))
    steps = np.diff(seen)
    assert len(seen) == 16384
    assert max(steps) < 1.01 * math.pi / 16383
    assert min(steps) > 0.0


def test_a_coarse_half_without_a_fine_half_is_used_after_5_ms():
    reader = MidiReader()
    read(reader, change(1, 10), change(33, 5))
    assert read(reader, change(1, 64), at=1.0) == []
    assert reader.tick(1.004) == []
    assert angles(reader.tick(1.006)) == pytest.approx([math.pi * (64 << 7) / 16383])
    assert reader.tick(2.0) == []


def test_an_assigned_control_32_above_is_not_taken_for_a_fine_half():
    reader = MidiReader((Control("cc", 1), Control("cc", 33, to="tactor.gain_db")))
    assert read(reader, change(1, 127), change(33, 127)) == [
        AngleChanged("cc 1/1", math.pi), ScaleParameter("tactor.gain_db", 1.0)
    ]  # fmt: skip
    assert read(reader, change(1, 0))[0].theta2 == 0.0


def test_keys_tap_across_the_timeline_until_they_are_released():
    moves = read(MidiReader(), (0x90, 36, 100), (0x90, 66, 1), (0x80, 36, 0), (0x90, 66, 0))
    assert moves == [
        TouchStarted("key 1/36", 0.0),
        TouchStarted("key 1/66", math.pi / 2),
        TouchEnded("key 1/36"),
        TouchEnded("key 1/66"),
    ]
    assert read(MidiReader(), (0x90, 97, 100)) == []


def test_all_notes_off_releases_every_touch():
    assert read(MidiReader(), change(123, 0), change(120, 0)) == [TouchEnded(), TouchEnded()]


def test_with_a_pedal_as_the_touch_the_wheel_moves_the_touch():
    reader = MidiReader((Control("bend"), Control("cc", 64, to=TOUCH)))
    moves = read(reader, change(64, 0), bend(16383), change(64, 127), bend(8192), change(64, 0))
    assert [type(move) for move in moves] == [TouchEnded, TouchStarted, TouchStarted, TouchEnded]
    assert moves[1].theta2 == pytest.approx(math.pi)
    assert moves[2].theta2 == 0.0


def test_low_and_high_reverse_a_control_and_narrow_its_range():
    reader = MidiReader((Control("cc", 7, low=0.6, high=0.4),))
    assert angles(read(reader, change(7, 0), change(7, 127))) == pytest.approx(
        [0.6 * math.pi, 0.4 * math.pi]
    )


def test_a_control_with_a_channel_ignores_other_channels():
    reader = MidiReader((Control("cc", 7, channel=3),))
    assert read(reader, change(7, 1)) == []
    assert len(read(reader, change(7, 1, channel=3))) == 1
    assert reader.counters.unknown == 1


def test_invalid_messages_are_counted_and_clock_messages_are_ignored():
    reader = MidiReader()
    assert read(reader, (), (5, 5), (0x90, 60), (0x90, 200, 1), (0xB0, 1, 2, 3)) == []
    assert reader.counters.rejected == 5
    assert read(reader, (0xF8,), (0xFE,), (0xF0, 1, 2, 0xF7)) == []
    assert reader.counters.rejected == 5


@given(st.lists(st.binary(max_size=5), max_size=30))
def test_any_bytes_give_angles_on_the_timeline_without_an_exception(messages):
    reader = MidiReader()
    for n, one in enumerate(messages):
        for move in (*reader.read(one, 0.01 * n), *reader.tick(0.01 * n)):
            if isinstance(move, AngleChanged | TouchStarted):
                assert 0.0 <= move.theta2 <= math.pi


# --- the list of controls -------------------------------------------------------------------------

WHOLE = """
schema = 1

[[control]]
control = "cc 7"
to = "tactor.gain_db"
channel = 2
low = -24.0
high = 0.0

[[control]]
control = "keys 48-72"
to = "taps"

[[control]]
control = "bend"
to = "theta2"
high = 0.5
"""


def test_a_map_file_assigns_controls_and_is_written_as_it_was_read(tmp_path):
    controls = parse_map(WHOLE, "my.toml")
    assert controls == (
        Control("cc", 7, channel=2, to="tactor.gain_db", low=-24.0, high=0.0),
        Control("keys", 48, 72, to=TAPS),
        Control("bend", high=0.5),
    )
    path = tmp_path / "my.toml"
    path.write_text(write_map(controls))
    assert load_map(path) == controls
    assert parse_map(write_map(DEFAULT), "x") == DEFAULT


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("schema = 1", "", ("schema",)),
        ("schema = 1", "schema = 2", ("schema",)),
        ("schema = 1", "schema = ", ("not TOML",)),
        ("schema = 1", "schema = 1\nother = 3", ("other", "unknown")),
        ('"cc 7"', '"cc 7a"', ("control 1", "cc 0 to cc 119")),
        ('"cc 7"', '"cc 120"', ("control 1", "cc 0 to cc 119")),
        ('"cc 7"', "7", ("control", "text")),
        ('"cc 7"', '"keys 1-5"', ("taps",)),
        ('"keys 48-72"', '"keys 72-48"', ("keys LOW-HIGH",)),
        ('"taps"', '"theta2"', ("keys", "taps")),
        ("channel = 2", "channel = 17", ("channel", "16")),
        ("channel = 2", 'chanel = "x"', ("chanel", "channel")),
        ("high = 0.5", "high = 1.5", ("control 3", "0 to 1")),
        ("high = 0.5", 'high = "up"', ("is not a number",)),
        ('"bend"', '"note 60"', ("touch",)),
        ('control = "bend"\nto = "theta2"', 'control = "keys 48-72"\nto = "taps"', ("twice",)),
    ],
)
def test_a_wrong_map_file_is_an_error_of_one_line_with_its_location(before, after, words):
    assert before in WHOLE
    with pytest.raises(ov.InputError) as caught:
        parse_map(WHOLE.replace(before, after, 1), "my.toml")
    line = str(caught.value)
    assert re.match(r"my\.toml(:\d+)?: ", line), line
    for word in words:
        assert word in line


@given(st.text(max_size=80))
def test_any_text_is_read_or_gives_an_input_error(text):
    with contextlib.suppress(ov.InputError):
        parse_map(text, "x")


# --- learning -------------------------------------------------------------------------------------


def learned(to, *messages):
    learner = Learner(to)
    for one in messages:
        found = learner.read(bytes(one))
        if found is not None:
            return found
    return None


def test_the_moved_control_is_learnt_and_not_a_trembling_one():
    trembling = [change(5, 60 + n % 3) for n in range(40)]
    moved = [change(7, 3 * n, channel=2) for n in range(40)]
    mixed = [one for pair in zip(trembling, moved, strict=True) for one in pair]
    assert learned("tactor.gain_db", *mixed) == Control("cc", 7, channel=2, to="tactor.gain_db")
    assert learned("theta2", *trembling) is None


def test_the_coarse_half_of_a_fine_control_is_learnt():
    sent = []
    for value in range(0, 16384, 16):
        sent += [change(1, value >> 7), change(33, value & 0x7F)]
    assert learned("theta2", *sent) == Control("cc", 1, channel=1)


def test_a_wheel_a_pedal_a_key_and_a_range_of_keys_are_learnt():
    assert learned("theta2", *(bend(v) for v in range(0, 16383, 500))) == Control("bend", channel=1)
    assert learned(TOUCH, change(64, 10), change(64, 127)) == Control("cc", 64, channel=1, to=TOUCH)
    assert learned(TOUCH, (0x93, 60, 9)) == Control("note", 60, channel=4, to=TOUCH)
    assert learned(TAPS, (0x90, 72, 9), (0x80, 72, 0), (0x90, 48, 9)) == Control(
        "keys", 48, 72, channel=1, to=TAPS
    )
    assert learned("theta2", (0x90, 60, 9)) is None


@given(st.lists(st.binary(max_size=4), max_size=40), st.sampled_from(["theta2", TOUCH, TAPS]))
def test_a_learnt_control_can_be_written(messages, to):
    found = learned(to, *messages)
    if found is not None:
        assert parse_map(write_map((found,)), "x") == (found,)


# --- knobs without ends ---------------------------------------------------------------------------

SAID = {"twos": (1, 127), "offset": (65, 63), "signed": (1, 65)}


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("relative", SAID)
def test_an_endless_knob_is_learnt_from_a_turn_to_the_right_and_one_to_the_left(relative, reverse):
    right, left = SAID[relative][::-1] if reverse else SAID[relative]
    trembling = [change(5, 60 + n % 3) for n in range(12)]
    sent = [*trembling, *8 * [change(20, right)], *8 * [change(20, left)]]
    found = learned("theta2", *sent)
    assert found == Control("cc", 20, channel=1, relative=relative, reverse=reverse)
    assert parse_map(write_map((found,)), "x") == (found,)
    reader = MidiReader((found,))
    moves = read(reader, *30 * [change(20, right)], *10 * [change(20, left)])
    assert angles(moves)[29] == pytest.approx(math.pi / 2)
    assert angles(moves)[-1] == pytest.approx(math.pi / 3)


def test_larger_steps_of_a_fast_endless_knob_are_not_taken_for_a_control_with_ends():
    steps = [1, 1, 2, 3, 5, 4, 2, 2, 1, 1, 1]
    sent = [change(20, one) for one in steps] + [change(20, 128 - one) for one in steps]
    assert learned("theta2", *sent) == Control("cc", 20, channel=1, relative="twos")


def test_an_endless_knob_stops_at_the_ends_and_returns_at_once():
    reader = MidiReader((Control("cc", 20, relative="twos", steps=10.0),))
    moves = read(reader, *25 * [change(20, 1)], change(20, 126), *25 * [change(20, 127)])
    assert angles(moves)[24] == math.pi
    assert angles(moves)[25] == pytest.approx(0.8 * math.pi)
    assert angles(moves)[-1] == 0.0


def test_an_endless_knob_changes_a_parameter_by_steps_of_its_range():
    reader = MidiReader((Control("cc", 20, to="tactor.gain_db", relative="signed", steps=20.0),))
    assert read(reader, change(20, 2), change(20, 66)) == [
        StepParameter("tactor.gain_db", 0.1), StepParameter("tactor.gain_db", -0.1)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("line", "word"),
    [('relative = "up"', "twos, offset, signed"), ("reverse = true", "relative"),
     ('relative = "twos"\nsteps = 0', "steps"),
     ('relative = "twos"\nreverse = 1', "true or false")],
)  # fmt: skip
def test_an_invalid_relative_control_is_an_error_of_one_line(line, word):
    text = f'schema = 1\n[[control]]\ncontrol = "cc 1"\nto = "theta2"\n{line}\n'
    with pytest.raises(ov.InputError, match=word):
        parse_map(text, "x")


# --- either library -------------------------------------------------------------------------------


class MadeRtmidi2:
    """rtmidi2 as it is: a system that it hasn't got gives the first that it has."""

    API_MACOSX_CORE, API_LINUX_ALSA, API_UNIX_JACK, API_WINDOWS_MM = 1, 2, 3, 4
    made: ClassVar[list] = []

    class MidiIn:
        def __init__(self, name, queued, api):
            if api == 3:
                raise RuntimeError("no server")
            self.api, self.callback, self.open = 2, None, None
            self.ports = ["nano 20:0", "other 24:0"]
            MadeRtmidi2.made.append(self)

        def get_current_api(self):
            return self.api

        def ignore_types(self, sysex, timing, sensing):
            self.ignored = (sysex, timing, sensing)

        def open_port(self, index):
            self.open = index

        def close_port(self):
            self.open = None


def test_rtmidi2_serves_where_python_rtmidi_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "rtmidi", None)
    monkeypatch.setitem(sys.modules, "rtmidi2", MadeRtmidi2)
    assert midi_ports() == ["nano", "other"]
    port = MidiPort("nano")
    (one,) = [made for made in MadeRtmidi2.made if made.open is not None]
    assert (one.open, one.ignored) == (0, (True, True, False))
    one.callback([0x90, 60, 100], 0.0)
    one.callback([0xFE], 0.0)
    assert port.receive(0.0) == [bytes([0x90, 60, 100])]
    port.close()
    assert one.callback is None
