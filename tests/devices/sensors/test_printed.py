"""Published forms of boards and apps are followed or refused with the right reason."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.devices.sensors.moving import G
from tests.devices.sensors.printed import (
    FOLLOWED,
    MISREAD,
    NO_ANSWER,
    PRINTED,
    REFUSED,
    WHICH,
    Printed,
    outcomes,
    set_up,
)
from tests.devices.sensors.test_setup import mounted

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")


@pytest.mark.parametrize("one", PRINTED, ids=lambda one: one.source)
def test_a_published_form_is_followed_or_refused_with_the_right_reason(one):
    found = outcomes(one)
    assert all(kind in (FOLLOWED, REFUSED) for kind, _ in found.values()), found
    turned = found.get("setup") or found["learn"]
    assert turned[0] == (REFUSED if one.refused else FOLLOWED), found
    assert "\n" not in turned[1] or turned[0] == FOLLOWED


def test_the_table_has_at_least_forty_sources_that_are_named():
    assert len({one.source for one in PRINTED}) == len(PRINTED) >= 40
    assert all(len(one.where) > 5 for one in PRINTED)


UNITS = {"m/s2": 1.0, "g": 1.0 / G, "mg": 1000.0 / G, "counts": 16384.0 / G}
RATES = {"deg/s": np.degrees(1.0), "rad/s": 1.0}


@st.composite
def forms(draw):
    """A line of a quantity with any unit, order, separator, label and neighbours."""
    quantity = draw(st.sampled_from(["wxyz", "xyzw", "deg", "rad", *UNITS]))
    gyroscope = draw(st.sampled_from(["", "before", "after"])) if quantity in UNITS else ""
    rate = draw(st.sampled_from([*RATES]))
    apart = draw(st.sampled_from([",", ", ", "\t", " ", ";"]))
    label = draw(st.sampled_from(["", "data ", "S,", "imu: ", "#DAT="]))
    clock, accuracy, temperature, field = (draw(st.booleans()) for _ in range(4))
    digits = draw(st.integers(2, 5))
    at = draw(st.permutations([0, 1, 2]))

    def line(s):
        values = {
            "wxyz": lambda: s.q, "xyzw": lambda: s.xyzw, "deg": lambda: [s.rpy[n] for n in at],
            "rad": lambda: np.radians([s.rpy[n] for n in at]),
        }.get(quantity, lambda: s.a * UNITS[quantity])()  # fmt: skip
        turned = s.g * (131.0 * np.degrees(1.0) if quantity == "counts" else RATES[rate])
        numbers = [*(turned if gyroscope == "before" else []), *values,
                   *(turned if gyroscope == "after" else []), *(s.m if field else [])]  # fmt: skip
        whole = quantity == "counts"
        cells = [f"{v:.0f}" if whole else f"{v:.{digits}f}" for v in numbers]
        cells = [*([str(s.ms)] if clock else []), *cells, *(["3"] if accuracy else []),
                 *(["24.31"] if temperature else [])]  # fmt: skip
        return label + apart.join(cells)

    yaw = draw(st.sampled_from([0.0, 20.0, 60.0, 90.0, 135.0, 180.0, 225.0, 340.0]))
    return Printed(f"{label}{quantity} {gyroscope} {rate}", "made here", line, WHICH, yaw)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(forms())
def test_a_form_that_nobody_has_seen_is_right_or_refused(one):
    found = outcomes(Printed(one.source, one.where, one.make, "", one.yaw))
    assert all(kind != MISREAD for kind, _ in found.values()), (one.make, found)
    # the turn shows each of these quantities
    assert found["setup"][0] not in (NO_ANSWER,), found


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(["straight", "side", "upright", "over"]), st.sampled_from([*UNITS]),
       st.sampled_from(["", "before", "after"]), st.booleans(), st.booleans(),
       st.lists(st.sampled_from(["3", "0", "24.31"]), max_size=2))  # fmt: skip
def test_a_setup_finds_an_acceleration_among_any_neighbours_in_any_mounting(
    kind, unit, gyroscope, clock, field, more
):
    def line(s):
        a, g, m = (np.array(mounted(one[None, :], kind))[:, 0] for one in (s.a, s.g, s.m))
        rates = np.degrees(g) * (131.0 if unit == "counts" else 1.0)
        numbers = [*(rates if gyroscope == "before" else []), *(a * UNITS[unit]),
                   *(rates if gyroscope == "after" else []), *(m if field else [])]  # fmt: skip
        cells = [f"{one:.0f}" if unit == "counts" else f"{one:.3f}" for one in numbers]
        return ",".join([*([str(s.ms)] if clock else []), *cells, *more])

    found, why = set_up(Printed(kind, "made here", line))
    assert found == FOLLOWED, (line, why)
