"""A surface's rows: where events strike, what they let go, how far they reach, whom they hide."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels.layout import CELLS
from overview_dsp.signal.surface import build
from overview_dsp.signal.surface.build import MAX_FRICTION
from overview_dsp.signal.surface.fields import impedance
from overview_dsp.signal.surface.materials import louder, modes_of
from overview_dsp.signal.surface.profiles import profile, span
from tests.examples import plain_preset

LOUD, SOFT = (ov.ClickMode(500.0, 20.0),), (ov.ClickMode(900.0, 30.0, -6.0),)
KINDS = {
    "default": ov.EventKind(height=1.0, width_percent=1.0),
    "wide": ov.EventKind(height=8.0, width_percent=10.0, modes=LOUD),
    "slim": ov.EventKind(height=3.0, width_percent=0.5, shape="raised_cosine", modes=SOFT),
}


def surface_of(*events, preset=None, title="test", **kinds):
    """Events (time_s of 100, kind, weight) under kinds of these names, in place of `KINDS`'."""
    preset = preset or plain_preset(surface__friction=2e-3)
    changed = {**KINDS, **kinds}
    rows = tuple(ov.Event(t, k, str(n), weight=w) for n, (t, k, w) in enumerate(events))
    timeline = ov.Timeline(title, 100.0, rows)
    return ov.build_surface(timeline, replace(preset, kinds=changed))


def test_rows_are_in_the_order_in_which_a_hand_meets_them():
    surface = surface_of(
        (20.0, "slim", 1.0), (50.0, "wide", 0.5), (97.0, "slim", 2.0), (99.0, "wide", 1.0)
    )
    # the last one is wider than its way to the end: it strikes before the one before it
    assert surface.position.tolist() == pytest.approx([0.2, 0.5, 0.95, 0.97])
    assert surface.event.tolist() == [0, 1, 3, 2]
    assert surface.kind.tolist() == [2, 1, 1, 2]
    assert surface.kind_names == ("default", "wide", "slim")
    assert surface.kind_modes == ((), LOUD, SOFT)
    let_go = 16e-3 * profile("gaussian", np.array([-4.0]), 10.0)[0]
    assert surface.release == pytest.approx([6e-3, 8e-3, let_go, 12e-3])
    (slim,), (wide,) = ([span(KINDS[k].shape, KINDS[k].width_percent)] for k in ("slim", "wide"))
    centre = np.array([20.0, 50.0, 99.0, 97.0])
    first, last = np.array([slim, wide, wide, slim]).T
    assert surface.span[:, 0] == pytest.approx((centre + first) / 100.0)
    assert surface.span[:, 1] == pytest.approx(
        [*(centre + last)[:2] / 100.0, math.inf, 0.97 + slim[1] / 100.0]
    )


@pytest.mark.parametrize(
    ("shape", "at_start", "at_end"),
    [
        ("gaussian", 0.5, 0.5),
        ("plateau", 0.5, 0.5),
        ("ramp_up", 0.5, 1.0 - 4.0 / 15.0),  # falls within an eighth behind, rises over 15/8
        ("ramp_down", 1.0 - 4.0 / 15.0, 0.5),
    ],
)
def test_an_event_at_an_end_lets_go_what_its_profile_has_half_a_width_inside(
    shape, at_start, at_end
):
    kind = ov.EventKind(height=5.0, width_percent=4.0, shape=shape)
    surface = surface_of((0.0, "slim", 1.0), (100.0, "slim", 1.0), slim=kind)
    assert surface.position == pytest.approx([0.02, 0.98])
    assert surface.release == pytest.approx([10e-3 * at_start, 10e-3 * at_end])


def test_wells_take_an_impedance_and_stops_and_bristles_let_go_their_height():
    models = {
        "wide": replace(KINDS["wide"], model="detent", width_percent=2.0),
        "slim": replace(KINDS["slim"], model="end_stop", damping=5e-3),
        "default": replace(KINDS["default"], model="bristle"),
    }
    surface = surface_of(
        (20.0, "wide", 0.25), (50.0, "slim", 1.0), (80.0, "default", 1.5), **models
    )
    well = impedance(plain_preset(), 4e-3, 0.01 * CELLS, CELLS)
    assert surface.release == pytest.approx([well, 6e-3, 3e-3])
    assert surface.kind_models == ("bristle", "detent", "end_stop")
    assert surface.own_model == "viscous"
    # only the stop has viscous friction: its damping
    rise = surface.friction - 2e-3
    place = np.arange(CELLS + 1) / CELLS
    assert rise.max() == pytest.approx(5e-3, rel=1e-2)
    assert np.all(rise[np.abs(place - 0.5) > 0.006] == 0.0)
    # the well below the surface, the stop above it
    energy, pull = surface.detents.energy, surface.detents.pull
    assert energy.min() == energy[np.abs(place - 0.2) < 0.02].min() < 0.0
    assert energy.max() == energy[np.abs(place - 0.5) < 0.01].max() > 0.0
    assert np.abs(pull[place < 0.4]).max() == pytest.approx(4e-3, rel=1e-2)
    assert pull[(place > 0.4) & (place < 0.5)].max() == pytest.approx(6e-3, rel=2e-2)
    assert surface.bristles.grip.max() == pytest.approx(3e-3, rel=1e-3)
    assert surface.bristles.owner.max() == 2


@pytest.mark.parametrize("model", ["viscous", "bristle", "detent"])
def test_a_course_drawn_by_hand_is_that_of_the_event_in_every_model(model):
    course = (0.1, 1.0, 0.4, 0.05)
    kind = ov.EventKind(height=4.0, width_percent=4.0, points=course, model=model)
    surface = surface_of((30.0, "slim", 1.0), slim=kind)
    distance = np.arange(CELLS + 1) / CELLS - 0.3
    expected = profile("gaussian", distance, 0.04, course)
    if model == "detent":
        found = surface.detents.energy.max() - surface.detents.energy
        found = found / found.max()
        within = np.abs(distance) < 0.039  # its steps pull more
        assert np.abs(surface.detents.pull[within]).max() == pytest.approx(8e-3, rel=0.01)
    else:
        found = (surface.friction - 2e-3 if model == "viscous" else surface.bristles.grip) / 8e-3
        assert surface.release == pytest.approx([8e-3 * profile("", np.zeros(1), 1.0, course)[0]])
    edge = np.abs(np.abs(distance) - 0.04) < 3.0 / CELLS  # its steps fall between points
    assert found[~edge] == pytest.approx(expected[~edge], abs=2e-3)
    first, last = span("gaussian", 0.04, course)
    assert surface.span[0] == pytest.approx([0.3 + first, 0.3 + last])


def test_a_surface_has_only_the_fields_that_its_preset_has():
    plain = surface_of((30.0, "slim", 1.0))
    assert plain.bristles is plain.detents is None
    assert plain.own_model == "viscous"
    sticky = plain_preset(
        surface__friction=2e-3, surface__model="bristle", surface__torque_ratio=1.0
    )
    surface = surface_of((30.0, "slim", 1.0), preset=sticky)
    assert surface.own_model == "bristle"
    assert surface.detents is None
    # a viscous event on it is viscous
    assert np.array_equal(surface.friction, plain.friction)
    assert np.all(surface.bristles.grip == 2e-3)


def test_a_kind_of_a_material_rings_as_its_parameters_say():
    kind = replace(
        KINDS["slim"], modes=(), material="wood", pitch_hz=600.0, decay_scale=0.3, gain_db=-2.0
    )
    expected = louder(modes_of("wood", 600.0, 0.3), -2.0)
    assert surface_of((30.0, "slim", 1.0), slim=kind).kind_modes[2] == expected


def test_events_that_strike_at_one_place_keep_their_order():
    # within half a width of the end all wide ones strike there
    events = [(95.0 + 0.02 * n, "wide" if n % 2 else "slim", 1.0) for n in range(200)]
    at = [95.0 if kind == "wide" else time_s for time_s, kind, _ in events]
    expected = sorted(range(200), key=lambda n: (at[n], n))
    assert surface_of(*events).event.tolist() == expected


def test_two_events_are_too_dense_where_half_the_timeline_is_too_little_for_each():
    for spacing, dense in ((50.0, False), (51.0, True)):
        kind = replace(KINDS["slim"], spacing_percent=spacing)
        surface = surface_of(
            (30.0, "slim", 1.0), (60.0, "slim", 1.0), (90.0, "wide", 1.0), slim=kind
        )
        assert surface.omitted_events == ({"slim": 2} if dense else {})


def test_a_span_that_begins_within_the_first_cell_has_a_beginning():
    first = span("raised_cosine", 0.5)[0]
    surface = surface_of((0.5 / CELLS * 100.0 - first, "slim", 1.0))
    assert surface.span[0, 0] == pytest.approx(0.5 / CELLS)


def test_bristles_name_the_row_of_their_event_in_its_order():
    sticky = {name: replace(KINDS[name], model="bristle") for name in ("slim", "wide")}
    surface = surface_of((97.0, "slim", 1.0), (99.0, "wide", 0.5), **sticky)
    assert surface.event.tolist() == [1, 0]
    owner = surface.bristles.owner
    assert owner[CELLS] == 0  # the wide one, first in the order of positions
    assert owner[round(0.5 * CELLS)] == -1


def test_friction_has_a_greatest_and_no_warning_below_it():
    most = MAX_FRICTION / 6e-3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        below = surface_of((50.0, "slim", 0.999 * most))
    assert below.release == pytest.approx([0.999 * MAX_FRICTION])
    with pytest.warns(ov.OverviewWarning, match=r"slim at 50 s: weight .*lowered to 1e\+06") as got:
        above = surface_of((20.0, "slim", 1.0), (50.0, "slim", 1.001 * most))
    assert len(got) == 1
    assert above.release.tolist() == [pytest.approx(6e-3), MAX_FRICTION]


def test_a_width_in_milliseconds_is_four_cells_or_more_and_the_timeline_at_most():
    narrowest = 4.0 / CELLS * 100e3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        surface = surface_of((50.0, "slim", 1.0), slim=ov.EventKind(1.0, width_ms=narrowest))
    half = span("gaussian", 4.0 / CELLS)[1]
    assert surface.span[0] == pytest.approx([0.5 - half, 0.5 + half])
    brief = ov.Timeline("brief", 1.0, (ov.Event(0.1, "default"),))
    kind = ov.EventKind(1.0, width_ms=5000.0)
    surface = ov.build_surface(brief, replace(plain_preset(), kinds={"default": kind}))
    # as wide as the table, it strikes in the middle
    assert surface.position.tolist() == [0.5]
    away = profile("gaussian", np.array([0.4]), 1.0)[0]
    assert surface.release == pytest.approx([1e-3 * away])


# --- more than a surface holds, in small ----------------------------------------------------------


def test_the_strongest_of_each_cell_stands_for_all_there(monkeypatch):
    monkeypatch.setattr(build, "MAX_EVENTS", 3)
    step = 100.0 / CELLS
    events = [
        (20.0, "slim", 1.0),
        (20.0 + 0.1 * step, "slim", 2.0),
        (40.0, "slim", 1.0),
        (60.0, "slim", 1.0),
    ]
    sticky = replace(KINDS["slim"], model="bristle")
    said = r"^the timeline: the surface keeps 3 of 4 events; .*use a shorter window$"
    with pytest.warns(ov.OverviewWarning, match=said):
        surface = surface_of(*events, title="", slim=sticky)
    assert surface.event.tolist() == [1, 2, 3]
    assert surface.position == pytest.approx([0.2, 0.4, 0.6], abs=1e-5)
    place = [round(part * CELLS) for part in (0.2, 0.4, 0.6)]
    assert surface.bristles.owner[place].tolist() == [0, 1, 2]
    with pytest.warns(ov.OverviewWarning, match="^test: the surface keeps 3 of 4 events"):
        surface_of(*events)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(surface_of(*events[1:]).event) == 3


@pytest.mark.filterwarnings("ignore:rough:overview_dsp.OverviewWarning")
def test_crests_leave_capacity_for_one_event_at_least(monkeypatch):
    values = {
        "surface__pattern": "waves", "surface__pattern_height": 2.0, "surface__material": "wood",
        "surface__pattern_period_percent": 5.0,
    }  # fmt: skip
    rough = plain_preset(**values)
    with_room = ((20, 0, True), (20, 1, False), (19, 1, False), (21, 1, True), (21, 2, True))
    for most, events, fits in with_room:
        monkeypatch.setattr(build, "MAX_EVENTS", most)
        timeline = ov.Timeline(
            "rough",
            100.0,
            tuple(ov.Event(50.0, "default", str(n)) for n in range(events)),
            ov.Intensity(np.array([0.0]), np.array([0.0])),
        )
        if fits:
            surface = ov.build_surface(timeline, replace(rough, kinds=KINDS))
            assert len(surface.event) == min(events, 1)
            assert len(surface.texture_strikes.position) == 20
            assert len(surface.own_modes) == 4
        else:
            with pytest.raises(ov.InputError, match=r"20 crests.*pattern_period_percent longer"):
                ov.build_surface(timeline, replace(rough, kinds=KINDS))
