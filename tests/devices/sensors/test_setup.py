"""Two twists make a sensor's file, with which the sensor is followed."""

from __future__ import annotations

import math
import os
import threading

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors.profile import parse_sensor
from overview_dsp.devices.sensors.setup import Setup
from overview_dsp.devices.sensors.source import SensorSource
from tests.cli.running import overview
from tests.devices.sensors.moving import RULES, G, course, turning

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")

RATE = 100.0
ROLL = course(RATE, (0, 0), (2, 0), (2.8, 170), (3.2, 170), (4, 0), (4.5, 0), (5.3, 170),
              (5.7, 170), (6.5, 0), (7.5, 0), (8.3, 120), (8.6, 120))  # fmt: skip
A, W = turning(ROLL, RATE, noise=1.0)


def rows(*columns) -> list[bytes]:
    table = np.column_stack(columns)
    return [(",".join(f"{value:.5g}" for value in row) + "\n").encode() for row in table]


def run_setup(pieces: list[bytes]) -> str:
    one = Setup()
    one.feed(b"\n", 0.0)
    for n, piece in enumerate(pieces):
        one.feed(piece, n / RATE)
        assert one.problem == ""
    assert one.done
    return one.toml()


def theta2_deg(text: str, pieces: list[bytes]) -> float:
    one = SensorSource(parse_sensor(text, "mine", "mine.toml"), RULES)
    one.feed(b"\n", 0.0)
    for n, piece in enumerate(pieces):
        one.feed(piece, n / RATE)
    assert one.angle is not None
    return math.degrees(one.angle.theta2)


def mounted(v, kind: str):
    """The sensor's axes of the device's x, y, z."""
    x, y, z = v.T
    return {"straight": (x, y, z), "side": (y, -x, z), "upright": (y, z, x), "over": (x, -y, -z)}[
        kind
    ]


@pytest.mark.parametrize("kind", ["straight", "side", "upright", "over"])
@pytest.mark.parametrize("turns", [True, False])
def test_two_twists_find_the_axes_of_a_sensor_in_any_mounting(kind, turns):
    parts = [*mounted(A, kind), *(mounted(W, kind) if turns else ())]
    pieces = rows(*parts)
    assert theta2_deg(run_setup(pieces), pieces) == pytest.approx(120.0, abs=1.0 if turns else 3.0)


@pytest.mark.parametrize("per_degree", [131.0, 65.5, 32.8, 16.4])
def test_the_range_of_a_bare_gyroscope_is_found_by_turning(per_degree):
    most = 32768 / per_degree
    speed = np.clip(np.degrees(W), -most, most) if per_degree < 100 else np.degrees(W)
    pieces = rows(np.rint(A / G * 8192), np.rint(speed * per_degree))
    text = run_setup(pieces)
    scale = parse_sensor(text, "mine", "mine.toml").number("angular_velocity.scale")
    assert 1.0 / scale == pytest.approx(per_degree)
    assert theta2_deg(text, pieces) == pytest.approx(120.0, abs=1.0)


def test_the_written_profile_names_the_twist_among_three_angles():
    shaken = np.sin(np.arange(len(ROLL)))
    pieces = [b"Orientation: " + row for row in rows(90 + shaken, np.degrees(ROLL), 0.5 * shaken)]
    text = run_setup(pieces)
    assert 'twist = "2"' in text
    assert theta2_deg(text, pieces) == pytest.approx(120.0, abs=0.1)


def test_a_quaternions_axes_are_found():
    w, s = np.cos(ROLL / 2), np.sin(ROLL / 2)
    pieces = [b"quat " + row for row in rows(w, 0 * s, s, 0 * s)]
    text = run_setup(pieces)
    assert 'x = "y"' in text
    assert theta2_deg(text, pieces) == pytest.approx(120.0, abs=0.2)


@pytest.mark.parametrize("ends", [(30.0, 4000.0), (1010.0, 12.0)])
def test_the_ends_of_a_potentiometer_are_found_in_either_direction(ends):
    low, high = ends
    values = np.rint(low + (high - low) * np.degrees(ROLL) / 170.0)
    pieces = rows(values)
    text = run_setup(pieces)
    assert theta2_deg(text, pieces) == pytest.approx(120.0 * 180.0 / 170.0, abs=2.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_counts_of_an_encoder_are_found_in_either_direction(sign):
    values = np.rint(sign * 80.0 * np.degrees(ROLL) / 170.0)
    pieces = [b'{"count": %d}\n' % value for value in values]
    assert theta2_deg(run_setup(pieces), pieces) == pytest.approx(127.0, abs=3.0)


def test_a_knob_that_names_its_column_once_a_second_is_detected_between_the_names():
    """As the kit's boards do: an encoder isn't taken for a potentiometer."""
    pieces = rows(np.rint(40.0 * np.degrees(ROLL) / 170.0))
    for second in range(50, len(pieces), 100):
        pieces[second] = b"count\n"
    text = run_setup(pieces)
    assert "[encoder]\ncounts = 40\n" in text
    assert "potentiometer" not in text


def test_the_instruction_fits_each_type_of_sensor():
    for values, words in ((np.degrees(ROLL), "from one end to the other"), (A, "face down")):
        one = Setup()
        assert one.instruction == "keep it at rest: a sensor face up, a knob at one end"
        for n, piece in enumerate(rows(values)[:300]):
            one.feed(piece, n / RATE)
        assert one.instruction == f"now turn it {words} and back, 2 times"


def test_setup_waits_while_the_sensor_turns_at_the_start():
    """It was picked up and laid down: what it rests on then is face up."""
    moved = course(RATE, (0, 60), (0.8, 130), (1.5, 0), (4, 0), (4.8, 170), (5.2, 170), (6, 0),
                   (6.5, 0), (7.3, 170), (7.7, 170), (8.5, 0), (9.5, 0), (10.3, 120))  # fmt: skip
    pieces = rows(*turning(moved, RATE, noise=1.0)[0].T)
    assert 'x = "x"\ny = "y"\nz = "z"' in run_setup(pieces)


def test_a_tilted_rest_or_turn_is_reported_in_one_line():
    c, s = math.cos(math.radians(45)), math.sin(math.radians(45))
    x, y, z = A.T
    for parts, said in (((x, c * y - s * z, s * y + c * z), "was tilted"),
                        ((c * x - s * y, s * x + c * y, z), "no axis")):  # fmt: skip
        with pytest.raises(ov.InputError, match=said) as caught:
            run_setup(rows(*parts))
        assert "\n" not in str(caught.value)


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
def test_the_command_reads_a_port_and_writes_a_profile_that_loads(tmp_path):
    import tty

    ours, theirs = os.openpty()
    tty.setraw(theirs)
    # a longer rest: what comes before the port is open goes by
    said = np.vstack([A[:100]] * 4 + [A])
    sent = b"".join(
        b"t_ms:%d AX:%.3f AY:%.3f AZ:%.3f\n" % (10 * n, *row) for n, row in enumerate(said)
    )
    threading.Thread(target=os.write, args=(ours, sent), daemon=True).start()
    path = tmp_path / "mine.toml"
    outcome = overview("sensor", "setup", os.ttyname(theirs), "-o", path, "--timeout", 60)
    assert outcome.code == 0, outcome.err
    assert "face down and back" in outcome.err
    assert 'x = "x"' in path.read_text(encoding="utf-8")
    os.close(theirs)
    os.close(ours)


def test_a_missing_port_is_an_error_of_one_line(tmp_path):
    outcome = overview("sensor", "setup", tmp_path / "none", "-o", tmp_path / "mine.toml")
    assert outcome.code == 2
    assert "no such port" in outcome.err
