"""A CLAP or VST3 plugin plays the native engine's bits in a host, whatever the host does."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import layout
from overview_dsp.offline.export.plugin_bundle import parameter_ids
from tests.offline.export.plugin_playing import (
    DOWN,
    EARLIER,
    FLUSHED,
    MIDI,
    NOT_THE_PRESETS,
    PRESETS,
    UP,
    VALUE,
    Host,
    both_halves,
    built_host,
    library_of,
    natively,
    normal,
    number_of,
    preset_named,
    score,
    switched,
)

FORMATS = ("clap", "vst3")
NO_MORE_TAIL = {"clap": 2**31 - 1, "vst3": 2**32 - 1}


@pytest.fixture(scope="module")
def presets():
    return {name: preset_named(name) for name in PRESETS}


@pytest.fixture(scope="module")
def timelines(match):
    return both_halves(match)


@pytest.fixture(scope="module", params=FORMATS)
def host(request, timelines, presets, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plugins")
    program = built_host(request.param, folder)
    plugin = ov.export.build_plugin(
        timelines, [*presets.values()], request.param, folder, name="Match!", seed=3
    )
    return Host(request.param, program, library_of(plugin))


@pytest.fixture
def play(host, tmp_path):
    def run(events, **options):
        return host.play(tmp_path, events, **options)

    return run


SECOND_HALF = (VALUE, "timeline", EARLIER, 1.0)


def chosen(name):
    return (VALUE, "preset", EARLIER, float(PRESETS.index(name)))


@pytest.mark.parametrize("rate", [44_100, 48_000, 96_000, 12_345.678])
@pytest.mark.parametrize("name", PRESETS)
def test_events_at_any_frame_in_blocks_of_any_size_are_the_engines(
    match, presets, host, play, name, rate
):
    expected = natively(match, presets[name], rate, host.heard(score(), presets[name]))
    assert np.abs(expected).max(axis=0).min() > 0.01
    heard, report = play([chosen(name), *score()], rate=rate)
    assert np.array_equal(heard, expected)
    assert report["latency"] == 0


@pytest.mark.parametrize("block", [1, 17, 64, 512, 4096])
def test_no_block_size_changes_a_bit(match, presets, host, play, block):
    events = host.heard(score(), presets["viscous"])
    expected = natively(match, presets["viscous"], 48_000, events, 20_000)
    assert np.array_equal(play(score(), block=block, frames=20_000)[0], expected)


def test_parameters_that_a_host_sets_as_floats_have_the_exact_values(match, presets, host, play):
    own = [(id, presets["viscous"].values[id]) for id in parameter_ids()]
    own = [(id, value) for id, value in own if isinstance(value, float)]
    said = [np.float32(normal(*one)) if host.to == "vst3" else one[1] for one in own]
    again = [(VALUE, id, 100, value) for (id, _), value in zip(own, said, strict=True)]
    heard, _ = play([again[0], *again, *turned(101, 9_000), (DOWN, 90, 9_500, 1.0)])
    expected = natively(
        match, presets["viscous"], 48_000, [*turned(101, 9_000), (DOWN, 90, 9_500, 1.0)]
    )
    assert np.abs(expected).max() > 0.01
    assert np.array_equal(heard, expected)


def test_a_reset_is_a_new_voice_with_the_values_of_the_moment(play):
    touched = [(VALUE, "touch", EARLIER, 1.0), (VALUE, "tactor.gain_db", EARLIER, -9.0)]
    swept = [(VALUE, "theta2", at, at / 8000) for at in range(100, 8000, 97)]
    fresh, _ = play([*touched, (VALUE, "theta2", EARLIER, swept[-1][3]), *swept])
    again, _ = play([*touched, *swept], warm=9000)
    assert np.abs(fresh).max() > 0.01
    assert np.array_equal(again, fresh)


def test_state_opens_in_a_fresh_host(timelines, presets, host, play, tmp_path):
    values = {"tactor.gain_db": -7.3, "click.mute": 1.0, "disk.release": 1.0}
    settings = [(VALUE, id, EARLIER, value) for id, value in values.items()]
    state = tmp_path / "state"
    play([SECOND_HALF, chosen("wells"), *settings], frames=100, saved=state)
    (*_, gain), *_ = host.heard(settings, presets["wells"])
    changed = presets["wells"].with_changes(
        {"tactor.gain_db": gain, "click.mute": True, "disk.release": "return"}
    )
    hands = [event for event in score() if event[1] in NOT_THE_PRESETS or event[0] != VALUE]
    heard, report = play(hands, state=state, saved=tmp_path / "again")
    assert np.array_equal(heard, natively(timelines["second half"], changed, 48_000, hands))
    # of two instances; a VST3 host asks by itself
    assert report["rescans"] == (2 if host.to == "clap" else 0)
    play([], state=state, frames=1, saved=tmp_path / "again")
    assert (tmp_path / "again").read_bytes() == state.read_bytes()


def test_a_flush_and_a_state_that_come_while_it_is_active_glide_in(
    match, presets, host, play, tmp_path
):
    values = {"tactor.gain_db": -7.25, "texture.gain_db": -20.0}
    hands = [
        (VALUE, "touch", 0, 1.0),
        *((VALUE, "theta2", at, at / 9e3) for at in range(1, 8000, 80)),
    ]
    changes = [(VALUE, id, 0, value) for id, value in values.items()]
    events = host.heard([*changes, *hands], presets["viscous"])
    expected = natively(match, presets["viscous"], 48_000, events, 9_000)
    flushed = [(VALUE, id, FLUSHED, value) for id, value in values.items()]
    assert np.array_equal(play([*flushed, *hands], frames=9_000)[0], expected)
    earlier = [(VALUE, id, EARLIER, value) for id, value in values.items()]
    play(earlier, frames=1, saved=tmp_path / "state")
    heard, _ = play(hands, frames=9_000, state=f"+{tmp_path / 'state'}")
    assert np.array_equal(heard, expected)
    # nothing glides that is there from the beginning
    assert not np.array_equal(play([*earlier, *hands], frames=9_000)[0], expected)


def test_damaged_state_is_refused(host, play, tmp_path):
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
    assert host.run("load", good, *paths, good).strip() == f"1{'0' * len(wrong)}1"


def turned(first, last):
    """A finger that is down from the beginning on."""
    down = [(VALUE, "touch", 0, 1.0)] if first == 0 else []
    return [*down, *((VALUE, "theta2", at, at / 20_000) for at in range(first, last, 111))]


@pytest.mark.parametrize("id", ["preset", "timeline"])
def test_another_image_fades_in_and_then_is_the_only_one(match, timelines, presets, play, id):
    at, frames = 9_001, 30_000
    early, late = turned(0, at), turned(9_102, 20_000)
    assert early[-1][2] + 111 == late[0][2] > at
    heard, report = play([*early, (VALUE, id, at, 1.0), *late], frames=frames)
    image = {
        "preset": (match, presets["bristles"]),
        "timeline": (timelines["second half"], presets["viscous"]),
    }[id]
    images = [(0, match, presets["viscous"]), (at, *image)]
    expected = switched(images, [*early, *late], frames)
    assert np.abs(expected[at : at + 1000]).max() > 1e-3
    assert np.array_equal(heard, expected)
    # a preset's values, of two instances
    assert report["told"] == (2 * layout.PARAMETERS if id == "preset" else 0)


def test_an_image_that_comes_in_a_fade_waits_for_its_end(match, presets, play):
    fade, first, frames = int(0.03 * 48_000) + 1, 9_001, 20_000
    second = first + fade
    early, late = turned(0, first), turned(10_545, 20_000)
    assert early[-1][2] < first < second < late[0][2]
    # the last of those that come meanwhile
    switches = [(first, 1.0), (first + 100, 0.0), (first + 700, 2.0)]
    events = [*early, *((VALUE, "preset", at, value) for at, value in switches), *late]
    heard, _ = play(events, frames=frames)
    images = [(0, "viscous"), (first, "bristles"), (second, "wells")]
    named = [(at, match, presets[name]) for at, name in images]
    assert np.array_equal(heard, switched(named, [*early, *late], frames))


def test_a_damaged_image_is_refused(host, timelines, presets, tmp_path):
    library = host.library.read_bytes()
    engine = ov.Engine(presets["viscous"], timelines["match"], seed=3)
    engine.prepare(48_000)
    image = ov.export.encode_engine(engine)
    begin, random = library.index(image), np.random.default_rng(1)
    # an image begins with the digest of its layout
    wrong = [bytes([image[0] ^ 1]), *(random.bytes(size) for size in (8, 40, len(image)))]
    # one that ends early
    wrong += [image[:size] + bytes(len(image) - size) for size in (40, len(image) // 16 * 8)]
    for damaged in wrong:
        path = tmp_path / host.library.name
        path.write_bytes(library[:begin] + damaged + library[begin + len(damaged) :])
        (tmp_path / "events").write_bytes(b"")
        given = (48_000, 0, 100, tmp_path / "events", tmp_path / "out", "-", "-", 0)
        assert "not activated" in replace(host, library=path).run("play", *given, fails=True)


def test_every_function_bears_or_refuses_what_can_not_be(host):
    host.run("probe")


def test_any_values_at_any_time_leave_numbers_and_a_voice_that_recovers(match, presets, host, play):
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
    (*_, gain), *_ = host.heard(full[-3:], presets["viscous"])
    quieter = presets["viscous"].with_changes({"tactor.gain_db": gain})
    expected = natively(match, quieter, 48_000, full[-2:])
    assert expected[9_000:, 1].any()
    assert np.array_equal(play(full)[0][9_000:], expected[9_000:])


def test_silence_sleeps_and_the_tail_is_true(match, presets, host, play):
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
    # of two instances; a VST3 host asks by itself
    told = 2 if host.to == "clap" else 0
    assert (report["tail"], report["tail_changes"]) == (NO_MORE_TAIL[host.to], told)


def test_markers_of_a_render_are_where_the_plugin_strikes(match, presets, play):
    sweep, rate = ov.sweep(1.0), 48_000
    rendered = ov.render(match, presets["viscous"], sweep, rate, 3, tail="none")
    line = zip(sweep.stamps(rate).tolist(), sweep.theta2.tolist(), strict=True)
    # a render lets go when the disk has arrived, which a line of automation can't know
    angles = [(VALUE, "theta2", at, theta2 / np.pi) for at, theta2 in line if at <= rate]
    heard, _ = play([angles[0], (VALUE, "touch", 0, 1.0), *angles[1:]], frames=rate)
    passed = [time for time in rendered.strikes.of_events().time_s.tolist() if time < 0.95]
    assert len(passed) > 10
    for time in passed:
        at, near = round(time * rate), 96
        assert np.abs(heard[at : at + near, 0]).max() > 4 * np.abs(heard[at - near : at, 0]).max()
    assert np.abs(heard - rendered.samples[:rate]).max() < 1e-5


def test_the_host_lists_every_parameter(host, presets):
    lines = [line.split("\t") for line in host.run("list").splitlines()]
    kind = {"clap": "org.overview-dsp.match", "vst3": "Instrument|Synth"}[host.to]
    assert lines[:3] == [[kind, "Match!"], ["output", "Click", "1"], ["output", "Tactor", "1"]]
    rows = {int(line[0]): line[1:] for line in lines[3:]}
    ids = [id for id in PARAMETERS if hasattr(layout, f"PARAM_{id.upper().replace('.', '_')}")]
    assert len(ids) == layout.PARAMETERS
    bits = {"clap": 2**32 - 1, "vst3": 2**31 - 1}[host.to]
    numbers = {id: number_of(id) & bits for id in (*NOT_THE_PRESETS, *ids)}
    midi = {"clap": set(), "vst3": {0, 1}}[host.to]
    assert set(rows) == {*numbers.values(), *midi}
    first = presets["viscous"].values
    for id in ids:
        known, (_, section, low, high, default, _, text) = PARAMETERS[id], rows[numbers[id]]
        assert host.to == "vst3" or section.lower() == id.partition(".")[0]
        if known.choices:
            assert (float(low), float(high)) == (0.0, len(known.choices) - 1)
            assert known.choices[int(float(default))] == first[id]
        else:
            assert (float(low), float(high), float(default)) == (known.low, known.high, first[id])
            assert text.endswith(known.unit)
    assert rows[numbers["preset"]][-1].strip() == "viscous"
    assert rows[numbers["timeline"]][-1].strip() == "match"


def test_an_angle_is_told_and_taken_as_a_moment_of_the_chosen_timeline(
    host, timelines, presets, play, tmp_path
):
    number = number_of("theta2") & {"clap": 2**32 - 1, "vst3": 2**31 - 1}[host.to]
    play([SECOND_HALF], frames=1, saved=tmp_path / "second")
    places = (0.0, 0.1, 0.25, 0.52, 0.7176, 0.999, 1.0)
    clocks = {"0:00": 0.0, "45:10": 2710.0, "0:45:10": 2710.0, "40:00.5": 2400.5}
    wrong = ("2:00:00", "-0:30", "1:2:3:4", "45:", ":10", "45:x", "1.5", "kick-off")
    for state, timeline in zip(("-", tmp_path / "second"), timelines.values(), strict=True):
        surface = ov.build_surface(timeline, presets["viscous"])
        assert not surface.angle_map.is_linear
        said = host.run("texts", state, number, *places, *clocks, *wrong).splitlines()
        for place, line in zip(places, said, strict=False):
            moment = timeline.moment_text(float(surface.time_at(place)))
            value, text = line.split("\t")
            assert (float(value), text) == (place, f"{place:.9g} ({moment})")
        for time_s, line in zip(clocks.values(), said[len(places) :], strict=False):
            value = float(line.partition("\t")[0])
            assert value == pytest.approx(float(surface.position_of(time_s)), abs=1e-12)
        assert said[-len(wrong) :] == ["refused"] * len(wrong)
