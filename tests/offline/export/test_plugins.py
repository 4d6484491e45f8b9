"""A CLAP or VST3 plugin plays the native engine's bits in a host, whatever the host does."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.kernels import layout
from overview_dsp.offline.export.plugin_bundle import bundle_of, host_id, parameter_ids
from tests.offline.export.plugin_playing import (
    DOWN,
    EARLIER,
    FLUSHED,
    MIDI,
    NOT_THE_PRESETS,
    PRESETS,
    TRANSPORT,
    TRANSPORTS,
    UP,
    VALUE,
    Host,
    both_halves,
    built_host,
    followed,
    is_log,
    library_of,
    natively,
    normal,
    number_of,
    preset_named,
    score,
    switched,
)
from tests.parameters import first_in_gate

FORMATS = ("clap", "vst3")
EARLIER_STATES = Path(__file__).parents[2] / "earlier" / "0.1.0" / "states"
NO_MORE_TAIL = {"clap": 2**31 - 1, "vst3": 2**32 - 1}


@pytest.fixture(scope="module")
def presets():
    return {name: preset_named(name) for name in PRESETS}


@pytest.fixture(scope="module")
def timelines(match):
    return both_halves(match)


@pytest.fixture(scope="module")
def share():
    return ov.load_timeline("made-up-share")


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


@pytest.mark.parametrize("rate", first_in_gate([12_345.678, 44_100, 48_000, 96_000], 2))
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
    assert {is_log(id) for id, _ in own} == {True, False}
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
    wrong += [state[:7] + b"\3" + state[8:], state[:-40], state + state[-40:], state[:60]]
    wrong += [
        state[:begin] + struct.pack("<d", value) + state[begin + 8 :]
        for value in (np.nan, np.inf, -np.inf)
    ]
    paths = [tmp_path / f"wrong-{number}" for number in range(len(wrong))]
    for path, content in zip(paths, wrong, strict=True):
        path.write_bytes(content)
    # after a good one, whose bytes no short one may take for its own
    assert host.run("load", good, *paths, good).strip() == f"1{'0' * len(wrong)}1"


HEAD, NAME, STATE_ROW = 528, 256, 40  # of a state: before its rows, of a name, of a row


def rows_of_state(state, head=HEAD):
    """The values of a plugin's state by id."""
    rows = [state[at : at + STATE_ROW] for at in range(head, len(state), STATE_ROW)]
    return {row[:32].rstrip(b"\0").decode(): struct.unpack("<d", row[32:])[0] for row in rows}


def state_with(state, rows, timeline=None):
    """A state with other rows, and another name of its timeline."""
    name = state[8 : 8 + NAME] if timeline is None else timeline.encode().ljust(NAME, b"\0")
    packed = [id.encode().ljust(32, b"\0") + struct.pack("<d", value) for id, value in rows.items()]
    count = struct.pack("<q", len(rows))
    return state[:8] + name + state[8 + NAME : HEAD - 8] + count + b"".join(packed)


@pytest.fixture
def saved(host, play, presets, tmp_path):
    """A state of another timeline and preset, and the engine's preset with its values."""
    values = {"tactor.gain_db": -7.3, "clutch.backlash_percent": 0.5}
    settings = [(VALUE, id, EARLIER, value) for id, value in values.items()]
    play([SECOND_HALF, chosen("wells"), *settings], frames=1, saved=tmp_path / "saved")
    heard = {id: value for _, id, _, value in host.heard(settings, presets["wells"])}
    return (tmp_path / "saved").read_bytes(), presets["wells"].with_changes(heard)


HANDS = [event for event in score(20_000) if event[1] in NOT_THE_PRESETS or event[0] != VALUE]


def test_a_state_of_a_build_with_other_parameters_loads_with_what_it_knows(
    timelines, presets, play, saved, tmp_path
):
    state, preset = saved
    rows = rows_of_state(state)
    assert len(rows) == layout.PARAMETERS + 3
    more = {"future.thing": np.nan, **rows}
    fewer = {id: value for id, value in rows.items() if id != "clutch.backlash_percent"}
    own = presets["wells"].values["clutch.backlash_percent"]
    without = preset.with_changes({"clutch.backlash_percent": own})
    out_of_range = {**rows, "tactor.gain_db": 99.0}
    loud = preset.with_changes({"tactor.gain_db": PARAMETERS["tactor.gain_db"].high})
    mixed = dict(reversed(rows.items()))
    cases = [(more, preset), (fewer, without), (out_of_range, loud), (mixed, preset)]
    for number, (changed, expected) in enumerate(cases):
        path = tmp_path / f"state-{number}"
        path.write_bytes(state_with(state, changed))
        heard, _ = play(HANDS, frames=20_000, state=path)
        wanted = natively(timelines["second half"], expected, 48_000, HANDS, 20_000)
        assert np.abs(wanted).max() > 0.01
        assert np.array_equal(heard, wanted), number


def test_a_missing_timeline_is_reported_and_its_name_and_values_are_kept(
    match, host, play, saved, tmp_path
):
    state, preset = saved
    path, again = tmp_path / "state", tmp_path / "again"
    path.write_bytes(state_with(state, rows_of_state(state), "Halbzeit von gestern"))
    heard, _ = play(HANDS, frames=20_000, state=path)
    assert np.array_equal(heard, natively(match, preset, 48_000, HANDS, 20_000))
    play([], frames=1, state=path, saved=again)
    assert again.read_bytes() == path.read_bytes()
    bits = {"clap": 2**32 - 1, "vst3": 2**31 - 1}[host.to]
    (said,) = host.run("texts", path, number_of("timeline") & bits, "match").splitlines()
    assert said == "0\tmatch (in place of Halbzeit von gestern)"
    logged = (
        "Timeline 'Halbzeit von gestern' of the project is not in this plugin: 'match' plays in "
        "its place, with the project's values; build the plugin with it"
    )
    # a VST3 host has no log
    assert host.run("load", path).splitlines() == ["1", *([logged] if host.to == "clap" else [])]
    # one that is chosen afterwards is what the project has
    play([(VALUE, "timeline", 0, 1.0)], frames=100, state=path, saved=again)
    assert again.read_bytes()[8:].startswith(b"second half\0")
    # also if it is the one that played in the place of the missing one
    back = [(VALUE, "timeline", 0, 1.0), (VALUE, "timeline", 90, 0.0)]
    play(back, frames=100, state=path, saved=again)
    assert again.read_bytes()[8:].startswith(b"match\0")


def test_a_state_of_version_0_1_0_loads_with_what_it_knows(match, presets, host, play, tmp_path):
    path = EARLIER_STATES / f"football.{host.to}.state"
    old = rows_of_state(path.read_bytes(), 72)
    assert len(old) == 24
    ratio = old.pop("disk.catch_up")
    known = {host_id(id): id for id in parameter_ids()}
    values = {known[id]: value for id, value in old.items() if id in known}
    assert len(values) == len(old) - 3
    values["clutch.max_speed_ratio"] = ratio
    values["clutch.tap_duration_s"] = old["disk.unfold_s"] / ratio
    for id, value in values.items():
        if choices := PARAMETERS[id].choices:
            values[id] = choices[int(value)]
        elif isinstance(PARAMETERS[id].default, bool):
            values[id] = value > 0.0
    preset = presets["viscous"].with_changes(values)
    assert (preset.values["tactor.gain_db"], preset.values["disk.k2"]) == (-7.5, 0.0051)
    heard, _ = play(HANDS, frames=20_000, state=path)
    expected = natively(match, preset, 48_000, HANDS, 20_000)
    assert np.abs(expected).max() > 0.01
    assert np.array_equal(heard, expected)
    # it has no names of timeline and preset, which is said in sentences, until one is chosen
    bits = {"clap": 2**32 - 1, "vst3": 2**31 - 1}[host.to]
    given = [("timeline", "match"), ("preset", "viscous")]
    for id, name in given:
        (said,) = host.run("texts", path, number_of(id) & bits, name).splitlines()
        assert said == f"0\t{name} (the project names no {id})"
    logged = [
        f"The project was saved by an earlier build and names no {id}: '{name}' plays, with the "
        f"project's values; choose another {id} if it is a wrong one"
        for id, name in given
    ]
    assert host.run("load", path).splitlines() == ["1", *(logged if host.to == "clap" else [])]
    play([], frames=1, state=path, saved=tmp_path / "again")
    saved = (tmp_path / "again").read_bytes()
    assert saved[8:].startswith(b"match\0")
    assert saved[8 + NAME :].startswith(b"viscous\0")


def test_a_state_of_the_last_version_finds_timeline_and_preset_by_their_image(
    timelines, presets, play, saved, tmp_path
):
    state, preset = saved
    engine = ov.Engine(presets["wells"], timelines["second half"], seed=3)
    engine.prepare(48_000)
    digest = hashlib.sha256(ov.export.encode_engine(engine)).hexdigest()
    path = tmp_path / "state"
    path.write_bytes(state[:7] + b"\1" + digest.encode() + state[HEAD:])
    heard, _ = play(HANDS, frames=20_000, state=path)
    expected = natively(timelines["second half"], preset, 48_000, HANDS, 20_000)
    assert np.array_equal(heard, expected)


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


@pytest.mark.parametrize("name", PRESETS)
def test_the_angle_follows_the_transport_of_a_host_in_any_blocks(match, presets, host, play, name):
    expected = followed((0, match, presets[name]))
    assert np.abs(expected[:8192]).max() > 0.01
    follows = (VALUE, "follow", EARLIER, 1.0)
    # a VST3 host says where its transport is as a block begins, a CLAP host at any frame
    for block in (1024, 64) if host.to == "vst3" else (1024, 17, 0):
        heard, report = play([chosen(name), follows, *TRANSPORTS], block=block)
        assert np.array_equal(heard, expected), block
    assert report["status"] == 1
    assert not play([chosen(name), *TRANSPORTS])[0].any()


def test_the_newest_touch_holds_be_it_the_transports_or_a_hands(match, presets, host, play):
    # a hand's lasts into the transport's, the next one begins and ends within it
    hands = [(500, 0.9, True), (9_000, 0.9, False), (20_000, 0.2, True), (30_000, 0.2, False)]
    transports = [(TRANSPORT, 1, 1_024, 2_000.0)]
    expected = followed((0, match, presets["wells"]), transports=transports, hands=hands)
    touches = [
        event
        for at, place, held in hands
        for event in ((VALUE, "theta2", at, place), (VALUE, "touch", at, float(held)))
    ]
    events = [chosen("wells"), (VALUE, "follow", EARLIER, 1.0), *touches, *transports]
    heard, _ = play(sorted(events, key=lambda event: event[2]), block=512)
    assert np.array_equal(heard, expected)


def test_a_plugin_that_follows_the_transport_does_not_sleep(play, host):
    """A host calls a plugin that sleeps at its next event, which no start of the transport is."""
    if host.to == "vst3":
        return  # it has no such state: a host is told only that a block is silent
    assert play([(VALUE, "follow", EARLIER, 0.0)])[1]["status"] == 4
    assert play([(VALUE, "follow", EARLIER, 1.0)])[1]["status"] == 1


@pytest.mark.parametrize("id", ["preset", "timeline"])
def test_another_image_while_the_transport_is_followed_sounds_alike_in_any_blocks(
    match, timelines, presets, host, play, id
):
    image = {
        "preset": (match, presets["bristles"]),
        "timeline": (timelines["second half"], presets["viscous"]),
    }[id]
    images = [(0, match, presets["viscous"]), (9_601, *image)]
    events = [(VALUE, "follow", EARLIER, 1.0), (TRANSPORT, 1, 0, 2_650.0), (VALUE, id, 9_601, 1.0)]
    expected = followed(*images, transports=events[1:2])
    assert np.abs(expected[9_601:]).max() > 0.001
    for block in (17, 480, 512):
        assert np.array_equal(play(events, block=block)[0], expected), block
    # the second half is over: nothing is touched in it
    late = [events[0], (TRANSPORT, 1, 0, 2_950.0), events[2], (VALUE, id, 9_700, 0.0)]
    blocks = [play(late, block=block)[0] for block in (17, 480, 512)]
    assert np.array_equal(blocks[0], blocks[1])
    assert np.array_equal(blocks[0], blocks[2])


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


def last_sound(samples):
    """The number of samples up to the last one that is not zero."""
    return int(np.flatnonzero(samples.any(axis=1))[-1]) + 1


@pytest.mark.parametrize("name", PRESETS)
def test_silence_sleeps_and_the_tail_ends_with_the_last_sound(match, presets, host, play, name):
    rate, released = 48_000, 100
    tapped = [(DOWN, 127, 0, 1.0), (UP, 127, released, 0.0)]
    _, report = play([chosen(name), *tapped], frames=200)
    tail = report["tail"]
    assert report["status"] == 1
    frames = released + tail + rate
    heard, report = play([chosen(name), *tapped], frames=frames, block=4096)
    assert not heard[released + tail :].any()
    if name == "viscous":
        # with bristles and detents another movement sounds for longer
        assert released + tail - last_sound(heard) <= rate // 2
    assert (report["status"], report["tail_changes"]) == (4, 0)
    assert tail <= ov.Engine(presets[name], match).tail_seconds * rate
    _, report = play([*tapped, (VALUE, "tactor.decay_ms", 150, 90.0)], frames=200)
    # of two instances; a VST3 host asks by itself
    told = 2 if host.to == "clap" else 0
    assert (report["tail"], report["tail_changes"]) == (NO_MORE_TAIL[host.to], told)


@pytest.mark.parametrize("name", PRESETS)
def test_a_tap_or_sweep_sounds_no_longer_than_the_tail(timelines, presets, name):
    bundle = bundle_of("x", timelines, [presets[name]], 3)
    random = np.random.default_rng(4)
    for image, timeline in zip(bundle.images, timelines.values(), strict=True):
        gestures = [ov.tap(place, 0.01) for place in random.random(4).tolist()]
        gestures += [ov.sweep(float(random.uniform(0.2, 3.0)), *random.random(2).tolist())]
        gestures += [ov.arm(1.5) + ov.tap(float(random.random()))]
        for one in ov.render_many(ov.render_jobs([timeline], [presets[name]], gestures, [3])):
            end_s = last_sound(one.samples) / one.sample_rate
            assert end_s - one.job.gesture.duration_s <= image.tail_s


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
@pytest.mark.parametrize("name", first_in_gate(ov.bundled_presets(), 5))
def test_no_tap_on_a_preset_sounds_longer_than_the_tail(match, share, name):
    """Where the disk arrives late at an event, and creeps over it on its way back."""
    preset, timelines = ov.load_preset(name), {"match": match, "share": share}
    places = (0.731, 0.847, 0.919, 0.981, 0.987)
    from_end = [ov.sweep(3.0, 1.0, 1.0) + ov.tap(place) for place in (0.541, 0.841, 0.879, 0.974)]
    gestures = [*map(ov.tap, places), *from_end]
    for image, timeline in zip(
        bundle_of("x", timelines, [preset], 0).images, timelines.values(), strict=True
    ):
        for one in ov.render_many(ov.render_jobs([timeline], [preset], gestures, [0])):
            end_s = last_sound(one.samples) / one.sample_rate
            assert end_s - one.job.gesture.duration_s <= image.tail_s


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
def test_the_tail_is_not_shorter_at_higher_rates(match):
    """Where the texture of a slow disk is heard for longer."""
    preset = ov.load_preset("plain")
    (image,) = bundle_of("x", {"match": match}, [preset], 3).images
    gestures = [ov.tap(0.69), ov.tap(0.63), ov.sweep(3.0, 0.73, 0.73)]
    for octaves, rate in enumerate((48_000, 96_000, 192_000)):
        for one in ov.render_many(ov.render_jobs([match], [preset], gestures, [3]), rate):
            end_s = last_sound(one.samples) / rate - one.job.gesture.duration_s
            assert end_s <= image.tail_s + octaves * image.tail_per_octave_s


def test_the_plugin_reports_the_tail_of_its_rate(match, presets, play):
    (image,) = bundle_of("x", {"match": match}, [presets["viscous"]], 3).images
    for rate, octaves in ((44_100, 0), (48_000, 0), (88_200, 1), (96_000, 1), (192_000, 2)):
        tail_s = image.tail_s + octaves * image.tail_per_octave_s
        assert play([], rate=rate, frames=1)[1]["tail"] - 1 == pytest.approx(tail_s * rate, abs=1)


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
    kind = {"clap": "org.overview-dsp.match.7fb6ff13", "vst3": "Instrument|Synth"}[host.to]
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
        elif host.to == "clap" and is_log(id):
            assert (float(low), float(high), float(default)) == (0.0, 1.0, normal(id, first[id]))
            assert text == f"{first[id]:.9g} {known.unit}"
        else:
            assert (float(low), float(high), float(default)) == (known.low, known.high, first[id])
            assert text.endswith(known.unit)
    assert rows[numbers["preset"]][-1].strip() == "viscous"
    assert rows[numbers["timeline"]][-1].strip() == "match"


def test_frequencies_inertias_stiffness_and_torques_have_logarithmic_ranges(host, presets):
    texts = {
        "tactor.frequency_hz": ("200 Hz", "Hz"),
        "disk.inertia": ("0.0001 kg·m²", "kg·m²"),
        "disk.k2": ("0.01 N·m/rad", "N·m/rad"),
        "tactor.reference_torque_mnm": ("31.6227766 mN·m", "mN·m"),
    }
    bits = {"clap": 2**32 - 1, "vst3": 2**31 - 1}[host.to]
    for id, (text, unit) in texts.items():
        # the middle of a range is the geometric one
        assert PARAMETERS[id].unit == unit
        (said,) = host.run("texts", "-", number_of(id) & bits, text).splitlines()
        value, shown = said.split("\t")
        assert float(value) == pytest.approx(0.5, abs=1e-9)
        assert shown == (text if host.to == "clap" else text.split()[0])


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
