"""The page sounds as the native engine does: the same float32 samples in a real Chromium."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.live.output.settings import OutputSettings, SignalSettings
from overview_dsp.live.output.stream import connect, run_block
from overview_dsp.offline.export.browser_memory import encode_change, encode_engine, event_numbers
from overview_dsp.signal.engine.surface_slots import write_surface
from tests.web.schedule import BLOCK, FRAMES, RATE, RELEASE, engine, events, played
from tests.web.surfaces import preset_of

COLUMNS_A_BLOCK = 16_384  # as kernel.js copies them
SOURCE_EVENTS = [
    {"sampleTime": sample, "theta2": theta2, "touching": touching, "source": source}
    for sample, theta2, touching, source in events()
]


def rendered(browser, **given):
    out, told = browser.render(rate=RATE, frames=FRAMES, **given)
    assert told["faults"] == []
    return out, told


def test_drag_tap_and_release_are_the_native_samples(browser, match, football):
    expected = played(engine(match, football))
    browser.give(image=encode_engine(engine(match, football, hands=False)))
    out, told = rendered(browser, image="image", events=SOURCE_EVENTS)
    assert len(out) > 3 * RATE
    assert np.abs(out[:RELEASE]).max(axis=0).min() > 0.1
    assert np.abs(out[RELEASE + 100 :]).max() > 0.001
    assert np.array_equal(out, expected)
    per_block = told["seconds"] / (FRAMES / BLOCK)
    budget = BLOCK / RATE
    print(
        f"\na quantum of {BLOCK} frames: {per_block * 1e6:.1f} us, {per_block / budget:.1%} of its "
        f"budget (an OfflineAudioContext's whole rendering)"
    )


@pytest.mark.soak
def test_firefox_gives_the_native_samples_too(firefox, match, football):
    expected = played(engine(match, football))
    firefox.give(image=encode_engine(engine(match, football, hands=False)))
    out, told = rendered(firefox, image="image", events=SOURCE_EVENTS)
    assert np.array_equal(out, expected)
    print(f"\nFirefox: {told['seconds'] / (FRAMES / BLOCK) * 1e6:.1f} us a quantum")


@pytest.fixture(scope="module")
def goals(football):
    """Football with other goals and another gain, and with a new shaft besides."""
    heights = ov.Engine(football, ov.load_timeline("world-cup-final-2018"))
    heights.set("kinds.goal.height", 40.0)
    heights.set("tactor.gain_db", -9.0)
    first = heights.preset, heights.surface
    heights.set("disk.k2", 6e-3)
    heights.set("disk.release", "return")
    return first, (heights.preset, heights.surface)


def test_stamped_parameters_and_surfaces_are_the_native_samples(browser, match, football, goals):
    (first, surface), (second, _) = goals
    made = engine(match, football)
    made.set_preset(first, sample_time=30_001)
    made.set_preset(second, sample_time=60_500)
    expected = played(made)
    browser.give(
        image=encode_engine(engine(match, football, hands=False)),
        first=encode_change(football, first, RATE, surface, 30_001),
        second=encode_change(first, second, RATE, surface, 60_500),
    )
    out, _ = rendered(browser, image="image", events=SOURCE_EVENTS, changes=["first", "second"])
    assert np.array_equal(out, expected)
    assert not np.array_equal(expected, played(engine(match, football)))


def test_what_is_sent_while_it_plays_applies_at_the_next_quantum(browser, match, football, goals):
    """Hands, changes, the device's gains and the end by messages, as a host between two blocks."""
    (first, surface), (second, _) = goals
    given = OutputSettings(
        SignalSettings(1, gain_db=-5.0, delay_ms=5.0), SignalSettings(2, ceiling_db=-17.0)
    )
    gains = [
        {"gain": s.gain, "ceiling": gain_of_db(s.ceiling_db), "delay": s.delay_ms * 1e-3}
        for s in given.signals
    ]
    browser.give(
        image=encode_engine(engine(match, football, hands=False)),
        # a surface takes some blocks to copy, so it comes in time for its sample
        surface=encode_change(football, first, RATE, surface, 36_000),
        shaft=encode_change(first, second, RATE),
    )
    made = engine(match, football, hands=False)
    fade = made.memory.view(np.int64)
    steps = [
        (0, "control", [0.3, True], lambda: made.control(0.3, True)),
        (20_096, "control", [2.2, True, "remote"], lambda: made.control(2.2, True, None, "remote")),
        (30_080, "change", [{"given": "surface"}], lambda: made.set_preset(first, 36_000)),
        (40_064, "output", gains, lambda: given.write(made.memory, RATE)),
        (50_048, "change", [{"given": "shaft"}], lambda: release_by_return(made)),
        (60_032, "control", [0, False, "remote"], lambda: made.control(0, False, None, "remote")),
        (80_000, "control", [2.9, True], lambda: made.control(2.9, True)),
        (90_112, "control", [2.9, False], lambda: made.control(2.9, False)),
        (120_064, "stop", [], lambda: fade.__setitem__(layout.L_STOP, 1)),
    ]  # fmt: skip
    expected = np.empty((FRAMES, 2), dtype=np.float32)
    stops = [sample for sample, *_ in steps[1:]] + [FRAMES]
    for (start, _, _, native), stop in zip(steps, stops, strict=True):
        native()
        run_block(made, expected[start:stop])
    out, told = rendered(browser, image="image", sends=[list(step[:3]) for step in steps])
    assert np.array_equal(out, expected)
    assert np.abs(out[92_000:120_000]).max() > 0.001
    assert not out[123_000:].any()
    look = told["look"]
    assert look["over"]
    assert (look["rejected"], look["dropped"], look["resets"]) == (0, 0, 0)


def release_by_return(made):
    made.set("disk.k2", 6e-3)
    made.set("disk.release", "return")


def test_strikes_and_meters_are_reported_when_asked(browser, match, football):
    made = engine(match, football)
    played(made)
    browser.give(image=encode_engine(engine(match, football, hands=False)))
    _, told = rendered(browser, image="image", events=SOURCE_EVENTS)
    look, struck = told["look"], told["look"]["newStrikes"]
    strikes, meters = made.pop_strikes(), made.meters
    assert len(struck) == len(strikes) == look["strikes"] > 10
    assert [one["sample"] / RATE for one in struck] == strikes.time_s.tolist()
    names = [*event_numbers(made.surface), -1]  # the number -1 is the last
    assert [names[one["event"]] for one in struck] == strikes.event.tolist()
    assert [one["torque"] for one in struck] == strikes.torque.tolist()
    assert look["clock"] == FRAMES
    assert look["cursor"] == meters.cursor
    assert look["torque"] == meters.torque


@pytest.mark.parametrize("preset", ["football", "door", "gravel"])
def test_the_page_starts_from_the_engines_memory(browser, match, preset):
    made = engine(match, preset_of(preset))  # with events that wait, and its state
    played(made, 4_800)
    made.control(1.0, True, FRAMES + 77)
    browser.give(image=encode_engine(made))
    told = browser.call("runKernel", {"image": "image"})
    assert told["loaded"] == hashlib.sha256(made.memory.tobytes()).hexdigest()


def test_a_page_sounds_on_where_the_engine_was(browser, match, football):
    made = engine(match, football)
    half = np.empty((FRAMES // 2, 2), dtype=np.float32)
    run_block(made, half)
    browser.give(image=encode_engine(made))  # connecting clears the device's delay lines
    out, _ = browser.render(rate=RATE, frames=FRAMES // 2, image="image")
    run_block(made, half)
    assert np.abs(half).max() > 0.1
    assert np.array_equal(out, half)


def test_a_surface_is_copied_into_the_free_slot_in_pieces(browser, match, football, goals):
    (first, surface), _ = goals
    browser.give(
        image=encode_engine(engine(match, football, hands=False)),
        rough=encode_change(football, preset_of("door"), RATE, creaking(match)),
        goal=encode_change(preset_of("door"), first, RATE, surface),
    )
    slot = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    slot[layout.S_SAMPLE_RATE] = RATE
    write_surface(slot, 0, surface)
    region = [layout.SURFACES + 2 * layout.SLOT_SIZE, layout.SURFACES + 3 * layout.SLOT_SIZE]
    given = {"image": "image", "region": region, "blocks": 200}
    # the first goes into slot 1, the second into 2, a third over what the image had in 0
    told = browser.call("runKernel", {**given, "changes": ["rough", "goal"]})
    assert told["region"] == hashlib.sha256(slot[layout.SURFACES :].tobytes()).hexdigest()
    pieces = 2 * layout.SLOT_SIZE / COLUMNS_A_BLOCK
    assert pieces - 2 < told["waited"] < pieces + 2


def creaking(match):
    return ov.build_surface(match, preset_of("door"))


def test_a_used_slot_keeps_nothing_of_its_old_surface(browser, match, football, goals):
    (first, surface), _ = goals
    door = preset_of("door")
    browser.give(
        image=encode_engine(engine(match, door, hands=False)),
        goal=encode_change(door, first, RATE, surface),
    )
    slot = np.zeros(layout.SURFACES + layout.SLOT_SIZE)
    slot[layout.S_SAMPLE_RATE] = RATE
    write_surface(slot, 0, surface)
    start = layout.SURFACES  # slot 0, where the door was
    given = {"image": "image", "region": [start, start + layout.SLOT_SIZE], "blocks": 300}
    told = browser.call("runKernel", {**given, "changes": ["goal", "goal", "goal"]})
    assert told["region"] == hashlib.sha256(slot[layout.SURFACES :].tobytes()).hexdigest()


@pytest.mark.parametrize(
    ("damage", "line"),
    [
        (lambda b: b[:-8], "damaged"),
        (lambda b: b + bytes(8), "damaged"),
        (lambda b: b[:-1], "not a valid change"),
        (lambda b: b"", "not a valid change"),
        (lambda b: bytes(8) + b[8:], "another kernel version"),
        (lambda b: b[:24] + np.float64(44_100).tobytes() + b[32:], "44100 Hz"),
        (lambda b: b[:12] + np.int32(-1).tobytes() + b[16:], "damaged"),
        (lambda b: b[:12] + np.int32(2**31 - 1).tobytes() + b[16:], "damaged"),
        (lambda b: b[:8] + np.int32(0).tobytes() + b[12:], "damaged"),
        (lambda b: b[:40] + np.float64(-1).tobytes() + b[48:], "damaged"),  # a slot of its own
        (lambda b: b[:40] + np.float64(0.5).tobytes() + b[48:], "damaged"),
        (lambda b: b[:56] + np.int32(7).tobytes() + b[60:], "damaged"),  # no such run
        (lambda b: b[:60] + np.int32(-1).tobytes() + b[64:], "damaged"),
        (lambda b: b[:56] + np.array([2, 3], np.int32).tobytes() + b[64:], "damaged"),
    ],
)
def test_damaged_bytes_are_refused_in_one_line(browser, match, football, goals, damage, line):
    (first, surface), _ = goals
    good = encode_change(football, first, RATE, surface)
    assert np.frombuffer(good, "<i4", 2, 8)[1] == 1  # a pair: the runs begin at byte 56
    browser.give(image=encode_engine(engine(match, football, hands=False)), good=good)
    assert browser.call("refusal", "image", "good") == ""
    browser.give(bad=damage(good))
    refused = browser.call("refusal", "image", "bad")
    assert line in refused
    assert "\n" not in refused


@pytest.mark.parametrize("rate", [44_100, RATE])
def test_one_image_plays_at_every_sample_rate(browser, match, football, rate):
    made = ov.Engine(football, match)
    made.prepare(44_100, 44_100)
    browser.give(image=encode_engine(made))
    given = {"frames": 44_032, "image": "image", "events": [{"theta2": 2.0, "touching": True}]}
    out, _ = browser.render(**given, rate=rate)
    own = ov.Engine(football, match)
    own.prepare(rate, 44_100)
    connect(own, None)
    own.control(2.0, True)
    expected = np.empty((44_032, 2), dtype=np.float32)
    run_block(own, expected)
    assert np.array_equal(out, expected)


def test_a_pads_channels_carry_the_signals(browser, match, football):
    """Clicks nowhere, the tactor on the fourth channel: a context that has four gets them."""
    pad = OutputSettings(SignalSettings(0), SignalSettings(4))
    made = engine(match, football, settings=pad)
    expected = np.empty((12_800, 4), dtype=np.float32)
    run_block(made, expected)
    browser.give(image=encode_engine(engine(match, football, hands=False, settings=pad), pad))
    out, _ = browser.render(
        rate=RATE, frames=12_800, image="image", events=SOURCE_EVENTS, channels=4
    )
    out = out.reshape(-1, 4)
    assert np.abs(out[:, 3]).max() > 0.01
    assert np.array_equal(out, expected)


def test_a_bad_send_is_reported_and_disturbs_no_sample(browser, match, football):
    expected = played(engine(match, football))
    browser.give(image=encode_engine(engine(match, football, hands=False)))
    out, told = browser.render(
        rate=RATE, frames=FRAMES, image="image", events=SOURCE_EVENTS, foul=9_984
    )
    assert np.array_equal(out, expected)
    assert len(told["faults"]) == 2
    assert "unknown input" in told["faults"][0]
    assert "not a valid change" in told["faults"][1]


def test_a_third_surface_waits_until_a_slot_is_free(browser, match, football, goals):
    """Not in the slot that is faded from, nor in the one that waits."""
    (first, surface), _ = goals
    door = preset_of("door")
    stamps = 20_000, 21_000, 90_000
    made = engine(match, football)
    made.set_preset(first, sample_time=stamps[0])
    made.set_preset(football, sample_time=stamps[1])
    expected = np.empty((FRAMES, 2), dtype=np.float32)
    run_block(made, expected[:30_000])
    made.set_preset(door, sample_time=stamps[2])
    run_block(made, expected[30_000:])
    bare = engine(match, football, hands=False)
    browser.give(
        image=encode_engine(bare),
        one=encode_change(football, first, RATE, surface, stamps[0]),
        two=encode_change(first, football, RATE, bare.surface, stamps[1]),
        three=encode_change(football, door, RATE, creaking(match), stamps[2]),
    )
    changes = ["one", "two", "three"]
    out, told = rendered(browser, image="image", events=SOURCE_EVENTS, changes=changes)
    assert np.array_equal(out, expected)
    assert told["look"]["changesWaiting"] == 0


def test_a_block_allocates_nothing(browser, match, football, goals):
    (first, surface), _ = goals
    browser.give(
        image=encode_engine(engine(match, football, hands=False)),
        goal=encode_change(football, first, RATE, surface),
    )
    blocks = 20_000
    told = browser.call("heapGrowth", {"image": "image", "blocks": blocks, "change": "goal"})
    budget = BLOCK / RATE * 1e6
    print(
        f"\na quantum of {BLOCK} frames: {told['microseconds']:.1f} us, "
        f"{told['microseconds'] / budget:.2%} of its budget (the kernel and its JavaScript alone)"
    )
    assert told["waiting"] == 0
    assert told["grown"] < blocks  # a number a block would be 12 bytes or more


@pytest.mark.soak
def test_ten_minutes_grow_no_memory(browser, match, football, goals):
    (first, surface), _ = goals
    browser.give(
        image=encode_engine(engine(match, football, hands=False)),
        goal=encode_change(football, first, RATE, surface),
    )
    blocks = 600 * RATE // BLOCK
    told = browser.call("heapGrowth", {"image": "image", "blocks": blocks, "change": "goal"})
    print(f"\nin {blocks} quanta the heap grew by {told['grown']} bytes")
    assert told["grown"] < 100_000


def test_the_kernel_plays_in_real_time_in_a_browser(browser, match, rigid_football):
    browser.give(image=encode_engine(engine(match, rigid_football, hands=False)))
    told = browser.call("playInTime", "image", RATE, 200)
    assert told["faults"] == []
    assert 0 < told["first"]["clock"] < told["second"]["clock"]
    assert told["first"]["cursor"] == 0.0
    assert 0.3 < told["second"]["cursor"] < 0.9
    assert told["second"]["newStrikes"]
    assert told["last"]["over"]
